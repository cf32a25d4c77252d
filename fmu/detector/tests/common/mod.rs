//! A detector behind the C functions, and the design it carries.

#![allow(
    dead_code,
    clippy::unwrap_used,
    clippy::undocumented_unsafe_blocks,
    reason = "plays the importer; not every test file uses all of it"
)]

use std::cell::RefCell;
use std::ffi::{CStr, c_char, c_void};
use std::ptr;
use std::sync::LazyLock;

use steerguard_detector::{
    Actuator, Configuration, Deviations, Estimator, Evaluation, Gains, Interval, OperatingRange,
    Staleness, TsModel, Vehicle, Zero,
};
use steerguard_fmi2::types::*;
use steerguard_fmu::{BakedDesign, DetectorModel};
use steerguard_fmu_core::Block;
use steerguard_model_description::VariableSet;
use steerguard_model_description::detector::DetectorVariable;

pub use fmi2::*;

pub const GUID: &CStr = c"{00000000-0000-0000-0000-000000000000}";
pub const PERIOD: f64 = 0.01;
pub const OK: fmi2Status = fmi2Status::fmi2OK;

/// A stable observer without E: N_i keeps the lateral dynamics and contracts the measured states.
pub fn design() -> BakedDesign {
    let model = TsModel {
        vehicle: Vehicle::PAPER,
        sampling_period_s: PERIOD,
        range: OperatingRange {
            v_x: Interval::new(5.0, 30.0),
            v_y: Interval::new(-1.5, 1.5),
            r: Interval::new(-0.55, 0.55),
        },
    };
    let gains = Gains {
        n: model
            .vertices()
            .map(|a| [[0.5, a[0][1], 0.0], [0.0, a[1][1], 0.0], [0.0, a[2][1], 0.5]]),
        l: [[[0.5, 0.0], [0.0, 0.0], [0.0, 0.5]]; 4],
        m: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        e: [[0.0; 2]; 3],
    };
    let evaluation = Evaluation {
        window: 40,
        weights: [1.0, 1.0],
        threshold: 1e-3,
        uncertainty_share: 0.0,
        start_up_amplitude: 0.1,
        start_up_decay: 0.97,
        debounce_samples: 1,
        alarm_hold_s: 1.0,
    };
    BakedDesign {
        hash: *b"0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef",
        certified: true,
        blind: false,
        beta: 0.35,
        gamma: 0.003,
        gap: 9.5,
        configuration: Configuration {
            model,
            hysteresis: [0.5, 0.25, 0.05],
            gains,
            evaluation,
            deviations: Deviations::NONE,
            actuator: Actuator {
                lag_s: 0.05,
                delay_s: 0.037,
                rate_limit_rad_per_s: Some(0.4),
                angle_limit_rad: Some(0.6),
            },
            zero: Zero::default(),
            staleness: Staleness { after_s: 0.0, v_x_jump_m_per_s: 0.3, r_jump_rad_per_s: 0.2 },
            // Runs and is saved; raises no alarm.
            estimator: Some(Estimator {
                threshold: 1e6,
                estimate_factor: 2.0,
                noise: [0.02, 0.002],
            }),
        },
    }
}

static BLOCK: LazyLock<Block> =
    LazyLock::new(|| Block::sealed(GUID.to_str().unwrap(), &design().encode().unwrap()).unwrap());

steerguard_fmi2::export_fmi2!(DetectorModel, block = &BLOCK);

/// Category and text of the messages.
pub type Messages = RefCell<Vec<(String, String)>>;

unsafe extern "C" fn log(
    environment: *mut c_void,
    _name: *const c_char,
    _status: fmi2Status,
    category: *const c_char,
    text: *const c_char,
) {
    let string = |pointer| unsafe { CStr::from_ptr(pointer) }.to_str().unwrap().to_owned();
    let messages = unsafe { &*environment.cast::<Messages>() };
    messages.borrow_mut().push((string(category), string(text)));
}

/// A detector instance.
pub struct Detector {
    pub c: fmi2Component,
    pub messages: Box<Messages>,
}

impl Detector {
    pub fn instantiated() -> Self {
        type Plain = unsafe extern "C" fn(
            *mut c_void,
            *const c_char,
            fmi2Status,
            *const c_char,
            *const c_char,
        );
        let messages = Box::new(Messages::default());
        let callbacks = fmi2CallbackFunctions {
            // A caller passes fixed arguments to a variadic function as to any other on the
            // platforms that run these tests.
            logger: Some(unsafe { std::mem::transmute::<Plain, fmi2CallbackLogger>(log) }),
            allocateMemory: None,
            freeMemory: None,
            stepFinished: None,
            componentEnvironment: ptr::from_ref(&*messages).cast_mut().cast(),
        };
        let (name, guid) = (c"detector".as_ptr(), GUID.as_ptr());
        let c = unsafe { fmi2Instantiate(name, 1, guid, ptr::null(), &callbacks, 0, 1) };
        assert!(!c.is_null(), "{messages:?}");
        Self { c, messages }
    }

    pub fn initialised(start: f64) -> Self {
        let detector = Self::instantiated();
        detector.initialise(start);
        detector
    }

    pub fn initialise(&self, start: f64) {
        unsafe {
            assert_eq!(fmi2SetupExperiment(self.c, 0, 0.0, start, 0, 0.0), OK);
            assert_eq!(fmi2EnterInitializationMode(self.c), OK);
            assert_eq!(fmi2ExitInitializationMode(self.c), OK);
        }
    }

    /// Sets v_x, r, T_eng, delta.
    pub fn set_inputs(&self, values: [f64; 4]) {
        let status = unsafe { fmi2SetReal(self.c, [0, 1, 2, 3].as_ptr(), 4, values.as_ptr()) };
        assert_eq!(status, OK);
    }

    pub fn set(&self, variable: DetectorVariable, value: f64) -> fmi2Status {
        unsafe { fmi2SetReal(self.c, &variable.value_reference(), 1, &value) }
    }

    pub fn set_integer(&self, variable: DetectorVariable, value: i32) -> fmi2Status {
        unsafe { fmi2SetInteger(self.c, &variable.value_reference(), 1, &value) }
    }

    pub fn set_boolean(&self, variable: DetectorVariable, value: bool) -> fmi2Status {
        unsafe { fmi2SetBoolean(self.c, &variable.value_reference(), 1, &value.into()) }
    }

    pub fn step(&self, point: f64, size: f64) -> fmi2Status {
        unsafe { fmi2DoStep(self.c, point, size, fmi2True) }
    }

    pub fn real(&self, variable: DetectorVariable) -> f64 {
        let mut value = f64::NAN;
        let vr = variable.value_reference();
        assert_eq!(unsafe { fmi2GetReal(self.c, &vr, 1, &mut value) }, OK);
        value
    }

    pub fn integer(&self, variable: DetectorVariable) -> i32 {
        let mut value = -1;
        let vr = variable.value_reference();
        assert_eq!(unsafe { fmi2GetInteger(self.c, &vr, 1, &mut value) }, OK);
        value
    }

    pub fn boolean(&self, variable: DetectorVariable) -> bool {
        let mut value = -1;
        let vr = variable.value_reference();
        assert_eq!(unsafe { fmi2GetBoolean(self.c, &vr, 1, &mut value) }, OK);
        value != 0
    }

    /// Its whole state, serialised.
    pub fn serialised(&self) -> Vec<u8> {
        let (mut state, mut size) = (ptr::null_mut(), 0);
        unsafe {
            assert_eq!(fmi2GetFMUstate(self.c, &mut state), OK);
            assert_eq!(fmi2SerializedFMUstateSize(self.c, state, &mut size), OK);
            let mut bytes = vec![0; size];
            let pointer = bytes.as_mut_ptr().cast();
            assert_eq!(fmi2SerializeFMUstate(self.c, state, pointer, size), OK);
            assert_eq!(fmi2FreeFMUstate(self.c, &mut state), OK);
            bytes
        }
    }

    pub fn restore(&self, bytes: &[u8]) {
        let mut state = ptr::null_mut();
        unsafe {
            let (pointer, size) = (bytes.as_ptr().cast(), bytes.len());
            assert_eq!(fmi2DeSerializeFMUstate(self.c, pointer, size, &mut state), OK);
            assert_eq!(fmi2SetFMUstate(self.c, state), OK);
            assert_eq!(fmi2FreeFMUstate(self.c, &mut state), OK);
        }
    }

    pub fn reset(&self) {
        assert_eq!(unsafe { fmi2Reset(self.c) }, OK);
    }

    /// Messages of a category since the last call.
    pub fn messages(&self, category: &str) -> Vec<String> {
        let messages = self.messages.take();
        messages.into_iter().filter(|(c, _)| c == category).map(|(_, text)| text).collect()
    }
}

impl Drop for Detector {
    fn drop(&mut self) {
        unsafe { fmi2FreeInstance(self.c) };
    }
}
