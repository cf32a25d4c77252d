//! The packaged detector and its twin in plain C, behind the same three functions of FMI 2.0.

use std::ffi::{CString, c_void};
use std::io::{Cursor, Read};
use std::path::Path;
use std::ptr;

use libloading::Library;
use steerguard::fmu::package::detector_fmu;
use steerguard::fmu::runtime::Runtimes;
use steerguard::platform::Platform;
use steerguard::report::design_summary::{Record, baked};
use steerguard_designer::spec::EstimatorTable;
use steerguard_designer::{Spec, design};
use steerguard_detector::{Actuator, Configuration};
use steerguard_fmi2::pointers;
use steerguard_fmi2::types::{
    fmi2CallbackFunctions, fmi2CoSimulation, fmi2False, fmi2Status, fmi2True,
};
use steerguard_fmu::BakedDesign;
use steerguard_model_description::detector::DetectorVariable as V;
use steerguard_model_description::{VariableSet, names};

#[cfg(test)]
#[path = "../../../designer/tests/common/designed.rs"]
mod designed;

/// Why there is nothing to measure.
pub type Error = Box<dyn std::error::Error>;

/// The designs that are compared, by name: the paper's, which states no uncertainty, and the default.
///
/// # Errors
/// What designing says.
pub fn designs() -> Result<[(&'static str, BakedDesign); 2], Error> {
    let designed = |spec: &Spec| -> Result<_, Error> { Ok(baked(&design(spec, &mut |_| {})?)?) };
    Ok([("paper", designed(&Spec::paper())?), ("default", designed(&Spec::default())?)])
}

/// The default design with its second test, which has no twin in plain C.
///
/// # Errors
/// What designing says.
pub fn with_second_test() -> Result<BakedDesign, Error> {
    let estimator = EstimatorTable { enabled: true };
    let spec = Spec { estimator, ..Spec::default() };
    Ok(baked(&design(&spec, &mut |_| {})?)?)
}

/// The FMU of `design`.
///
/// # Errors
/// What packaging says.
pub fn fmu(design: &BakedDesign) -> Result<Vec<u8>, Error> {
    Ok(detector_fmu(design, &Record::default(), &Runtimes::detector())?)
}

/// One detector behind the C interface.
pub struct Detector {
    set_real: pointers::fmi2SetReal,
    do_step: pointers::fmi2DoStep,
    get_real: pointers::fmi2GetReal,
    component: *mut c_void,
    step_s: f64,
    steps: u64,
    code: Library,
}

impl Detector {
    /// The library in an FMU, in Step Mode.
    ///
    /// # Errors
    /// If it cannot be loaded or refuses a call.
    pub fn packaged(fmu: &[u8], step_s: f64) -> Result<Self, Error> {
        let mut archive = zip::ZipArchive::new(Cursor::new(fmu))?;
        let mut xml = String::new();
        archive.by_name("modelDescription.xml")?.read_to_string(&mut xml)?;
        let guid = xml.split("guid=\"").nth(1).and_then(|rest| rest.split('"').next());
        let guid = CString::new(guid.ok_or("no guid")?)?;
        let platform = Platform::HOST.ok_or("FMUs do not run here")?;
        let mut library = tempfile::NamedTempFile::new()?;
        let name = platform.library_path(names::DETECTOR);
        std::io::copy(&mut archive.by_name(&name)?, &mut library)?;

        let code = load(library.path())?;
        // SAFETY: the FMI 2.0 headers declare the functions with these types.
        let (instantiate, setup, enter, exit) = unsafe {
            (
                *code.get::<pointers::fmi2Instantiate>("fmi2Instantiate")?,
                *code.get::<pointers::fmi2SetupExperiment>("fmi2SetupExperiment")?,
                *code
                    .get::<pointers::fmi2EnterInitializationMode>("fmi2EnterInitializationMode")?,
                *code.get::<pointers::fmi2ExitInitializationMode>("fmi2ExitInitializationMode")?,
            )
        };
        // The FMU may keep the pointer: it lives as long as the process.
        let callbacks = Box::leak(Box::new(fmi2CallbackFunctions {
            logger: None,
            allocateMemory: None,
            freeMemory: None,
            stepFinished: None,
            componentEnvironment: ptr::null_mut(),
        }));
        // SAFETY: strings and callbacks are valid; the calls follow the standard's sequence.
        let (component, statuses) = unsafe {
            let component = instantiate(
                c"bench".as_ptr(),
                fmi2CoSimulation,
                guid.as_ptr(),
                ptr::null(),
                callbacks,
                fmi2False,
                fmi2False,
            );
            if component.is_null() {
                return Err("fmi2Instantiate gave no instance".into());
            }
            (
                component,
                [
                    setup(component, fmi2False, 0.0, 0.0, fmi2False, 0.0),
                    enter(component),
                    exit(component),
                ],
            )
        };
        if statuses.iter().any(|&status| status != fmi2Status::fmi2OK) {
            return Err(format!("initialisation answered {statuses:?}").into());
        }
        Self::new(code, component, step_s)
    }

    /// The detector in plain C.
    ///
    /// # Errors
    /// If its library cannot be loaded, or the configuration has an actuator, which it does not know.
    pub fn plain_c(configuration: &Configuration, step_s: f64) -> Result<Self, Error> {
        let code = load(Path::new(env!("DETECTOR_C")))?;
        let configuration = CConfiguration::of(configuration)?;
        // SAFETY: detector.c declares the function with this type, and `CConfiguration` is its
        // Configuration; it copies what it is given.
        let component = unsafe {
            let new = code.get::<unsafe extern "C" fn(*const CConfiguration) -> *mut c_void>(
                "detector_new",
            )?;
            new(&raw const configuration)
        };
        Self::new(code, component, step_s)
    }

    fn new(code: Library, component: *mut c_void, step_s: f64) -> Result<Self, Error> {
        // SAFETY: both libraries define these functions with the standard's types.
        let (set_real, do_step, get_real) = unsafe {
            (
                *code.get::<pointers::fmi2SetReal>("fmi2SetReal")?,
                *code.get::<pointers::fmi2DoStep>("fmi2DoStep")?,
                *code.get::<pointers::fmi2GetReal>("fmi2GetReal")?,
            )
        };
        Ok(Self { set_real, do_step, get_real, component, step_s, steps: 0, code })
    }

    /// Sets v_x, r, T_eng, delta.
    pub fn set(&mut self, inputs: &[f64; 4]) -> fmi2Status {
        let references =
            [V::SpeedX, V::YawRate, V::DriveTorque, V::SteeringAngle].map(V::value_reference);
        // SAFETY: a live instance and four elements each.
        unsafe { (self.set_real)(self.component, references.as_ptr(), 4, inputs.as_ptr()) }
    }

    /// Steps over one sample.
    pub fn step(&mut self) -> fmi2Status {
        let time_s = self.steps as f64 * self.step_s;
        self.steps += 1;
        // SAFETY: a live instance.
        unsafe { (self.do_step)(self.component, time_s, self.step_s, fmi2True) }
    }

    /// Gets residual.v_x, residual.r, J_rms, J_th.
    pub fn get(&self) -> [f64; 4] {
        self.values([V::ResidualSpeedX, V::ResidualYawRate, V::Rms, V::Threshold])
    }

    /// Gets detectability.
    pub fn detectability(&self) -> f64 {
        let [detectability] = self.values([V::Detectability]);
        detectability
    }

    /// Bytes of a serialised state of an FMU.
    ///
    /// # Errors
    /// If the library is no FMU, or refuses a call.
    pub fn state_bytes(&self) -> Result<usize, Error> {
        // SAFETY: the FMI 2.0 headers declare the functions with these types.
        let (get, size, free) = unsafe {
            (
                *self.code.get::<pointers::fmi2GetFMUstate>("fmi2GetFMUstate")?,
                *self
                    .code
                    .get::<pointers::fmi2SerializedFMUstateSize>("fmi2SerializedFMUstateSize")?,
                *self.code.get::<pointers::fmi2FreeFMUstate>("fmi2FreeFMUstate")?,
            )
        };
        let (mut state, mut bytes) = (ptr::null_mut(), 0);
        // SAFETY: a live instance, and a state that it gave.
        let statuses = unsafe {
            [
                get(self.component, &raw mut state),
                size(self.component, state, &raw mut bytes),
                free(self.component, &raw mut state),
            ]
        };
        if statuses.iter().any(|&status| status != fmi2Status::fmi2OK) {
            return Err(format!("the state answered {statuses:?}").into());
        }
        Ok(bytes)
    }

    fn values<const N: usize>(&self, variables: [V; N]) -> [f64; N] {
        let references = variables.map(V::value_reference);
        let mut values = [f64::NAN; N];
        // SAFETY: a live instance and N elements each.
        unsafe {
            (self.get_real)(self.component, references.as_ptr(), N, values.as_mut_ptr());
        }
        values
    }
}

/// Inputs at sample k: a gentle weave, with a steering error from sample 500 on.
pub fn inputs(k: u64) -> [f64; 4] {
    let phase = (k % 2000) as f64 * 0.01;
    let delta = 0.01 * (0.5 * phase).sin();
    let error = if k >= 500 { 0.005 } else { 0.0 };
    [15.0 + 0.1 * (0.3 * phase).sin(), 4.0 * (delta + error), 78.75, delta]
}

fn load(path: &Path) -> Result<Library, Error> {
    // SAFETY: both libraries are ours and have no initialisers of consequence.
    Ok(unsafe { Library::new(path)? })
}

/// `Configuration` of detector.c.
#[repr(C)]
struct CConfiguration {
    vehicle: [f64; 10],
    period: f64,
    range: [f64; 4],
    n: [[[f64; 3]; 3]; 4],
    l: [[[f64; 2]; 3]; 4],
    m: [[f64; 3]; 3],
    e: [[f64; 2]; 3],
    weights: [f64; 2],
    threshold: f64,
    start_up: [f64; 2],
    share: f64,
    uncertainty: [f64; 14],
    smallest_fault: [f64; 3],
    zero: [f64; 2],
    euler_correction: usize,
    window: usize,
}

impl CConfiguration {
    fn of(configuration: &Configuration) -> Result<Self, Error> {
        let Configuration { model, gains, evaluation, deviations, actuator, zero, .. } =
            configuration;
        let q = &deviations.uncertainty;
        if *actuator != Actuator::NONE || q.slowest(actuator) != *actuator {
            return Err("the detector in plain C knows no actuator".into());
        }
        let v = &model.vehicle;
        Ok(Self {
            vehicle: [
                v.mass_kg,
                v.yaw_inertia_kg_m2,
                v.effective_longitudinal_inertia_kg_m,
                v.front_axle_distance_m,
                v.rear_axle_distance_m,
                v.front_cornering_stiffness_n_per_rad,
                v.rear_cornering_stiffness_n_per_rad,
                v.longitudinal_drag_n_m_s2_per_m2,
                v.lateral_drag_n_s2_per_m2,
                v.centre_of_gravity_height_m,
            ],
            period: model.sampling_period_s,
            range: [model.range.v_x.min, model.range.v_x.max, model.range.r.min, model.range.r.max],
            n: gains.n,
            l: gains.l,
            m: gains.m,
            e: gains.e,
            weights: evaluation.weights,
            threshold: evaluation.threshold,
            start_up: [evaluation.start_up_amplitude, evaluation.start_up_decay],
            share: evaluation.uncertainty_share,
            uncertainty: [
                q.mass,
                q.yaw_inertia,
                q.front_cornering_stiffness,
                q.rear_cornering_stiffness,
                q.friction.unwrap_or(0.0),
                q.load_transfer,
                q.bank_m_per_s2,
                q.gust.speed_m_per_s,
                q.gust.coefficient_n_s2_per_m2,
                q.gust.acting_ahead_m,
                q.steering_ratio,
                q.steering_offset_rad,
                q.yaw_rate_bias_rad_per_s,
                q.v_x_scale,
            ],
            smallest_fault: deviations.smallest_fault,
            zero: [zero.steering_offset_rad, zero.yaw_rate_bias_rad_per_s],
            euler_correction: usize::from(deviations.euler_correction),
            window: evaluation.window,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::designed::designed;

    /// `design` with all that plain C knows: sensors with zeros and errors, tyres that let reference
    /// motions be drawn to the measured yaw rate.
    fn with_everything(mut design: BakedDesign) -> BakedDesign {
        let Configuration { deviations, zero, .. } = &mut design.configuration;
        let uncertainty = &mut deviations.uncertainty;
        uncertainty.front_cornering_stiffness = 0.5;
        uncertainty.rear_cornering_stiffness = 0.5;
        uncertainty.steering_ratio = 0.03;
        uncertainty.steering_offset_rad = 0.004;
        uncertainty.yaw_rate_bias_rad_per_s = 0.002;
        uncertainty.v_x_scale = 0.01;
        zero.steering_offset_rad = 0.01;
        zero.yaw_rate_bias_rad_per_s = -0.005;
        design
    }

    #[test]
    fn both_give_the_same_outputs_bit_for_bit() {
        let of = |spec: &Spec| baked(&designed(spec).unwrap()).unwrap();
        let paper = ("paper", of(&Spec::paper()));
        let default = ("default", of(&Spec::default()));
        let everything = ("everything", with_everything(default.1));
        for (name, design) in [paper, default, everything] {
            let configuration = &design.configuration;
            let step_s = configuration.model.sampling_period_s;
            let mut packaged = Detector::packaged(&fmu(&design).unwrap(), step_s).unwrap();
            let mut plain = Detector::plain_c(configuration, step_s).unwrap();
            let (mut largest, mut thresholds) = (0.0_f64, [f64::INFINITY, 0.0_f64]);
            for k in 0..10_000 {
                for detector in [&mut packaged, &mut plain] {
                    assert_eq!(detector.set(&inputs(k)), fmi2Status::fmi2OK);
                    assert_eq!(detector.step(), fmi2Status::fmi2OK);
                }
                let [ours, theirs] = [&packaged, &plain].map(|detector| {
                    let [v_x, r, j_rms, j_th] = detector.get();
                    [v_x, r, j_rms, j_th, detector.detectability()]
                });
                assert_eq!(
                    ours.map(f64::to_bits),
                    theirs.map(f64::to_bits),
                    "{name} at {k}: {ours:?} {theirs:?}"
                );
                largest = largest.max(ours[2]);
                if k > 1000 {
                    let [low, high] = thresholds;
                    thresholds = [low.min(ours[3]), high.max(ours[3])];
                }
            }
            assert!(largest > 0.0, "the comparison saw a residual");
            let [low, high] = thresholds;
            let adapts = configuration.evaluation.uncertainty_share > 0.0;
            assert_eq!(high > 1.01 * low, adapts, "{name}: J_th from {low} to {high}");
        }
    }
}
