//! Whole designs: what they are worth, their file, and specifications that have none.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "common/designed.rs"]
mod designed;

use std::sync::OnceLock;

use steerguard_designer::analysis::certificate::{check, error_dynamics};
use steerguard_designer::lmi::matrix::matrix;
use steerguard_designer::problem::inputs::Inputs;
use steerguard_designer::spec::{
    ActuatorTable, Calibration, Covers, Evaluation, Manoeuvre, OperatingRangeTable, ThresholdKind,
    UncertaintyTable,
};
use steerguard_designer::synthesis::gains::ObserverGains;
use steerguard_designer::synthesis::solve::{AttenuationMatrices, Lyapunov};
use steerguard_designer::synthesis::theorem4::Theorem4;
use steerguard_designer::threshold::by_cause;
use steerguard_designer::{
    Design, DesignError, DesignFileError, DesignStatus, FORMAT, Obstacle, Spec, Step, design,
};
use steerguard_detector::{Cause, Detector, Initialisation, Input, Measurement, Monitor};
use steerguard_test_support::cases::ReferenceCase;
use steerguard_verify::Refusal;
use steerguard_world::{Excitation, STEP_S, State, Steering, TrueVehicle, World, steady_angle};

use designed::designed;

/// The paper's case with few drives in the calibration, among them the worst.
fn spec() -> Spec {
    let mut spec = Spec::paper();
    spec.evaluation.calibration = Calibration {
        speeds: 2,
        manoeuvres: vec![Manoeuvre::Straight, Manoeuvre::StepSteer],
        lateral_acceleration_m_per_s2: vec![3.0],
        disturbance_frequencies: 1,
        disturbance_phases: 2,
        initial_v_y_m_per_s: Some(vec![0.0]),
        duration_s: 4.0,
        search_drives: 0,
        ..Calibration::default()
    };
    spec
}

fn papers_design() -> &'static Design {
    static DESIGN: OnceLock<Design> = OnceLock::new();
    DESIGN.get_or_init(|| designed(&spec()).unwrap())
}

fn near(value: f64, expected: f64, relative: f64) {
    assert!((value / expected - 1.0).abs() < relative, "{value}, expected {expected}");
}

#[test]
fn papers_case_meets_its_reference_values() {
    let design = papers_design();
    let synthesis = &design.synthesis;
    let largest_beta = ReferenceCase::read("largest_beta");
    largest_beta.check("bound", synthesis.beta_bound);
    let largest = synthesis.largest_beta.as_ref().unwrap().beta;
    largest_beta.check("solved", largest);
    assert!(largest < synthesis.beta_bound);
    near(synthesis.beta, 0.97 * synthesis.beta_bound, 1e-12);
    let reference = ReferenceCase::read("well_posed");
    reference.check("gamma", synthesis.gamma);
    reference.check("frozen_beta", design.performance.frozen.beta);
    reference.check("frozen_gamma", design.performance.frozen.gamma);
    reference.check("spectral_radius_at_30_m_per_s", design.performance.spectral_radii[2]);
    assert!(design.performance.spectral_radii.iter().all(|&radius| radius < 0.97));
    assert_eq!(synthesis.status, DesignStatus::Certified);
}

#[test]
fn frozen_gains_lie_within_what_is_certified() {
    let Design { synthesis, performance, .. } = papers_design();
    let frozen = performance.frozen;
    assert!(synthesis.beta < frozen.beta_at_least && frozen.beta_at_least < frozen.beta);
    let gamma_at_most = frozen.gamma_at_most.expect("the grid is fine enough");
    assert!(frozen.gamma < gamma_at_most && gamma_at_most < synthesis.gamma);
    near(frozen.beta_at_least, frozen.beta, 0.01);
    near(gamma_at_most, frozen.gamma, 0.01);
}

/// Theorem and numbers of a design, from its file alone.
fn from_file(design: &Design) -> (Theorem4, ObserverGains, Lyapunov) {
    let theorem =
        Theorem4::of(&design.spec, &Inputs::of(&design.spec).unwrap(), design.performance.decay);
    let gains = ObserverGains {
        gains: design.configuration().gains,
        h: design.vertices.map(|rule| rule.h),
    };
    let c = &design.certificate;
    let lyapunov = Lyapunov {
        p_s: c.p_s.map(|p| matrix(&p)),
        attenuation: c
            .attenuation
            .iter()
            .flatten()
            .map(|of_band| AttenuationMatrices {
                gamma: of_band.gamma,
                p: of_band.p_d.map(|p| matrix(&p)),
                q: matrix(&of_band.q_d),
            })
            .collect(),
        p_f: c.p_f.unwrap().map(|p| matrix(&p)),
        q_f: matrix(&c.q_f.unwrap()),
        r: matrix(&c.r.unwrap()),
    };
    (theorem, gains, lyapunov)
}

#[test]
fn the_file_holds_all_that_the_check_needs() {
    let design = papers_design();
    let (theorem, gains, lyapunov) = from_file(design);
    let synthesis = &design.synthesis;
    let check = |gains: &ObserverGains, gamma: f64, beta: f64| {
        let mut lyapunov = lyapunov.clone();
        lyapunov.attenuation[0].gamma = gamma;
        check(&theorem, gains, &lyapunov, beta)
    };
    let margins = check(&gains, synthesis.gamma, synthesis.beta);
    assert_eq!(Some(margins), design.certificate.margins);
    assert!(margins.holds());
    assert!(margins.observer_equation_error < 1e-10);

    // Better figures, or other gains, are not proven by these matrices.
    assert!(!check(&gains, 0.99 * synthesis.gamma, synthesis.beta).disturbance_attenuation.holds());
    assert!(!check(&gains, synthesis.gamma, 1.01 * synthesis.beta).fault_sensitivity.holds());
    for (row, column) in [(0, 0), (1, 1), (1, 2), (2, 1), (2, 2)] {
        let mut changed = gains;
        changed.gains.n[3][row][column] += 0.05;
        assert!(!check(&changed, synthesis.gamma, synthesis.beta).holds(), "N[{row}][{column}]");
    }
}

#[test]
fn start_up_residual_obeys_its_bound_under_switching() {
    let design = papers_design();
    let (theorem, gains, _) = from_file(design);
    let dynamics = error_dynamics(&theorem, &gains);
    let e = &design.detector.evaluation;
    let (amplitude, decay) = (e.start_up_amplitude, e.start_up_decay);
    assert!(design.threshold.start_up.margin.holds() && decay <= 0.97);
    let mut largest_share = 0.0_f64;
    let mut seed = 7_u64;
    for _ in 0..200 {
        let mut e = nalgebra::DMatrix::<f64>::from_column_slice(3, 1, &[0.0, 1.5, 0.0]);
        for j in 0..300 {
            let residual = e[0].hypot(e[2]);
            let bound = amplitude * decay.powi(j);
            largest_share = largest_share.max(residual / bound);
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            e = &dynamics[(seed >> 33) as usize % 4][(seed >> 40) as usize % 2] * e;
        }
    }
    assert!(largest_share <= 1.0, "{largest_share}");
    // A bound far above what can happen would be of no use.
    assert!(largest_share > 0.1, "{largest_share}");
}

/// Simulates the paper's scenario at a constant speed with a steering fault in degrees from 5 s on;
/// returns the first alarm in samples and J's share of its threshold just before the onset.
fn scenario(design: &Design, v_x: f64, v_y: f64, fault_deg: f64) -> (Option<u64>, f64) {
    let vehicle = design.detector.model.vehicle;
    let mut detector = Detector::new(&design.configuration()).unwrap();
    assert_eq!(detector.initialisation(), Initialisation::FirstMeasurement);
    let world = World::of(TrueVehicle::linear(vehicle), Steering::DIRECT);
    let mut state = State::new(&world, STEP_S, [v_x, v_y, 0.0].into(), 0.0);
    let mut share = 0.0;
    for k in 0..800 {
        let t = f64::from(k) * 0.01;
        let delta = 0.02 * (0.5 * t).sin() * (5.0 / v_x).sqrt();
        let t_eng_n_m = vehicle.cruise_torque(v_x);
        let u = Input { t_eng_n_m, delta_rad: delta };
        let output = detector.sample(state.motion.measured(), u);
        assert_eq!(output.monitor, Monitor::Monitoring);
        if k == 499 {
            share = output.j_rms / output.j_th;
        }
        let fault = if k >= 500 { fault_deg.to_radians() } else { 0.0 };
        let wave = 0.1 * (-0.1 * std::f64::consts::PI * t).sin();
        let side_force_n = vehicle.mass_kg * wave;
        let excitation = Excitation {
            drive_torque_n_m: t_eng_n_m,
            command_rad: delta,
            fault_rad: fault,
            push: world.vehicle.push(side_force_n, 0.25 * side_force_n),
        };
        for _ in 0..10 {
            state.step(&world, &excitation, STEP_S);
        }
    }
    (detector.output().first_alarm, share)
}

#[test]
fn detects_the_smallest_fault_soon_and_nothing_before() {
    let design = papers_design();
    for v_x in [6.0, 15.0, 25.0] {
        for v_y in [-1.0, 0.0, 1.0] {
            let (alarm, share) = scenario(design, v_x, v_y, 0.5);
            let delay = alarm.and_then(|alarm| alarm.checked_sub(500)).expect("alarm after 5 s");
            assert!(delay <= 10, "{v_x} m/s: {delay} samples");
            assert!(share < 0.5, "{v_x} m/s: J / J_th = {share} without a fault");
            assert_eq!(scenario(design, v_x, v_y, 0.0).0, None);
        }
    }
}

#[test]
fn threshold_is_the_calibrated_level_times_the_margin() {
    let design = papers_design();
    let (e, causes) = (&design.detector.evaluation, &design.threshold);
    let calibration = causes.calibration.as_ref().unwrap();
    near(e.threshold, causes.margin * calibration.level, 1e-15);
    assert_eq!(calibration.drives, 2 * 2 * 2);
    // The tightest turn at the lowest speed leaves the operating range.
    assert!(calibration.monitored > 0.75 && calibration.monitored < 1.0);
    assert_eq!(calibration.worst.manoeuvre, Manoeuvre::StepSteer);
    // The budget: at most half of what the smallest fault reaches.
    assert!(e.threshold < 0.5 * design.performance.smallest_fault_residual);
}

#[test]
fn an_adaptive_threshold_scales_level_and_bound_by_what_uncertain_vehicles_need() {
    let uncertainty = UncertaintyTable { mass_percent: [-20.0, 30.0], ..Default::default() };
    let evaluation =
        Evaluation { threshold: ThresholdKind::Adaptive, margin: 1.2, ..spec().evaluation };
    let adaptive = designed(&Spec { uncertainty, evaluation, ..spec() }).unwrap();
    let (e, causes) = (&adaptive.detector.evaluation, &adaptive.threshold);
    let (level, ratio) = (causes.calibration.as_ref().unwrap(), causes.uncertain.as_ref().unwrap());
    assert_eq!(
        causes.calibration,
        papers_design().threshold.calibration,
        "of the specified vehicle"
    );
    near(e.uncertainty_share, 1.2 * ratio.level, 1e-15);
    near(e.threshold, 1.2 * ratio.level * level.level, 1e-15);
    assert!(ratio.level > 0.1 && ratio.level < 1.1, "{}", ratio.level);
    // Of n drives none was larger than the largest: 1 - 0.05^(1/8).
    near(ratio.exceeded_at_most, 0.312344, 1e-6);
    assert!(causes.searched.is_empty(), "none was asked for");

    // The bounds are what the farther end of each interval does to the forces' effect.
    let bounds = adaptive.configuration().deviations.uncertainty;
    near(bounds.mass, 1.0 / 0.8 - 1.0, 1e-15);
    near(bounds.front_cornering_stiffness, 0.1, 1e-15);
    near(bounds.bank_m_per_s2, 9.80665 * 3_f64.to_radians().sin(), 1e-15);
    assert_eq!(adaptive.vertices, papers_design().vertices, "the gains stay as they are");
}

#[test]
fn an_adaptive_threshold_covers_what_a_search_finds() {
    let adaptive = |covers, margin| {
        let mut spec = Spec { uncertainty: UncertaintyTable::default(), ..spec() };
        spec.evaluation.threshold = ThresholdKind::Adaptive;
        spec.evaluation.margin = margin;
        spec.evaluation.covers = covers;
        spec.evaluation.calibration.search_drives = 400;
        designed(&spec).unwrap()
    };
    let design = adaptive(Covers::WorstCase, 1.05);
    let (e, causes) = (&design.detector.evaluation, &design.threshold);
    let names: Vec<&str> = causes.searched.iter().map(|found| found.family.as_str()).collect();
    assert_eq!(names, ["any_course", "friction"]);
    assert!(causes.searched.iter().all(|found| (1..=400).contains(&found.drives)));
    let found = causes.searched.iter().map(|found| found.level).fold(0.0, f64::max);
    let (level, ratio) = (causes.calibration.as_ref().unwrap(), causes.uncertain.as_ref().unwrap());
    assert!(found > ratio.level && found < 1.0 / 1.05, "{found}, at random {}", ratio.level);
    near(e.uncertainty_share, 1.05 * found, 1e-15);
    near(e.threshold, 1.05 * found * level.level, 1e-15);

    // What was found is covered as far as the whole bound goes.
    let whole = adaptive(Covers::WorstCase, 2.0 / found);
    assert_eq!(whole.threshold.searched, causes.searched);
    let random = whole.threshold.uncertain.as_ref().unwrap().level;
    near(whole.detector.evaluation.uncertainty_share, f64::max(1.0, 2.0 / found * random), 1e-15);

    // Where random drives decide, it is stated all the same.
    let random = adaptive(Covers::RandomDrives, 1.05);
    assert_eq!(random.threshold.searched, causes.searched);
    near(random.detector.evaluation.uncertainty_share, 1.05 * ratio.level, 1e-15);
}

/// What people are shown cause by cause is what the detector settles at.
#[test]
fn the_threshold_by_cause_is_that_of_steady_driving() {
    let evaluation = Evaluation { threshold: ThresholdKind::Adaptive, ..spec().evaluation };
    let uncertainty = UncertaintyTable::DEFAULT;
    let design = designed(&Spec { uncertainty, evaluation, ..spec() }).unwrap();
    let points = by_cause(&design.configuration());
    assert_eq!(points.len(), 6);
    for point in points {
        let (v_x, a_y) = (point.v_x_m_per_s, point.lateral_acceleration_m_per_s2);
        let y = Measurement { v_x_m_per_s: v_x, r_rad_per_s: a_y / v_x };
        let u = Input {
            t_eng_n_m: design.detector.model.vehicle.cruise_torque(v_x),
            delta_rad: steady_angle(&design.detector.model.vehicle, v_x, a_y),
        };
        let mut detector = Detector::new(&design.configuration()).unwrap();
        for _ in 0..3000 {
            detector.sample(y, u);
        }
        let output = detector.output();
        near(output.j_th, point.j_th, 1e-3);
        near(output.detectability * output.j_th, point.smallest_fault_j, 1e-6);
        near(point.level + point.uncertainties.iter().sum::<f64>(), point.j_th, 1e-12);
        assert_eq!(point.uncertainties[Cause::Actuator as usize], 0.0, "it has come to rest");
    }
}

#[test]
fn a_constant_threshold_is_taken_as_it_is() {
    let evaluation = Evaluation {
        threshold: ThresholdKind::Constant,
        constant: Some(0.002),
        ..spec().evaluation
    };
    let design = designed(&Spec { evaluation, ..spec() }).unwrap();
    let (told, e) = (design.detector.evaluation, design.threshold);
    assert_eq!((told.threshold, told.uncertainty_share), (0.002, 0.0));
    assert!(e.calibration.is_none() && e.uncertain.is_none() && e.guaranteed.is_none());
}

/// The calibration's vehicle has the actuator that the detector knows of: the level stays low, where
/// one left out is like a fault of more than a degree. The gains stay as they are.
#[test]
fn an_actuator_changes_the_threshold_little_and_nothing_else() {
    let actuator = ActuatorTable {
        lag_s: 0.1,
        delay_s: 0.0373,
        rate_limit_rad_per_s: Some(0.2),
        angle_limit_deg: Some(40.0),
    };
    let with = designed(&Spec { actuator, ..spec() }).unwrap();
    let without = papers_design();
    assert_eq!(with.vertices, without.vertices);
    // What is seen, the actuator delays.
    let mut performance = without.performance.clone();
    performance.sight.clone_from(&with.performance.sight);
    assert_eq!(with.performance, performance);
    assert_eq!(with.certificate, without.certificate);
    let ratio = with.detector.evaluation.threshold / without.detector.evaluation.threshold;
    assert!(ratio < 1.2 && ratio != 1.0, "{ratio}");
    assert_eq!(with.configuration().actuator, actuator.actuator());
    assert_eq!(Design::from_json(&with.to_json().unwrap()).unwrap(), with);
}

#[test]
fn same_specification_gives_the_same_bytes() {
    let again = design(&spec(), &mut |_| {}).unwrap();
    assert_eq!(again.to_json().unwrap(), papers_design().to_json().unwrap());
}

#[test]
fn file_reads_back_bit_for_bit() {
    let text = papers_design().to_json().unwrap();
    let read = Design::from_json(&text).unwrap();
    assert_eq!(&read, papers_design());
    assert_eq!(read.to_json().unwrap(), text);
    // Layout is free.
    let compact: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(Design::from_json(&compact.to_string()).unwrap().hash, read.hash);
}

#[test]
fn changed_files_are_refused() {
    let design = papers_design();
    let text = design.to_json().unwrap();
    let refusal = |text: &str| match Design::from_json(text).unwrap_err() {
        DesignFileError::Refused(refusal) => refusal,
        other => panic!("{other}"),
    };
    let gain = design.detector.gains.e[1][1];
    let changed = text.replacen(&format!("{gain:?}"), &format!("{:?}", gain + 1e-15), 1);
    assert!(matches!(refusal(&changed), Refusal::Hash { .. }));
    let status = text.replacen("\"certified\",", "\"uncertified\",", 1);
    assert!(matches!(refusal(&status), Refusal::Hash { .. }));
    for older in ["steerguard-design/1", "steerguard-design/2", "steerguard-design/3"] {
        let format = text.replacen(FORMAT, older, 1);
        assert!(matches!(refusal(&format), Refusal::Format { found } if found == older));
    }
    for blank in ["", " \n"] {
        assert!(matches!(refusal(blank), Refusal::Empty));
    }
    assert!(matches!(refusal("{}"), Refusal::NoFormat));
    assert!(matches!(refusal(&text[..text.len() / 2]), Refusal::Truncated(_)));

    // A forged hash does not hide numbers that cannot run; verify finds the other contradictions.
    let forged = |change: &dyn Fn(&mut Design)| {
        let mut design = design.clone();
        change(&mut design);
        design.hash = design.computed_hash().unwrap();
        Design::from_json(&design.to_json().unwrap()).unwrap_err()
    };
    let spec = forged(&|design| design.spec.evaluation.margin = 0.0);
    assert!(matches!(spec, DesignFileError::Spec(_)));
    let threshold = forged(&|design| design.detector.evaluation.threshold = 0.0);
    assert!(matches!(threshold, DesignFileError::Configuration(_)));
}

#[test]
fn zero_has_no_sign_in_a_design() {
    let design = papers_design();
    let mut signed = design.clone();
    signed.detector.gains.e[0][1] = -0.0;
    signed.hash = signed.computed_hash().unwrap();
    let mut unsigned = signed.clone();
    unsigned.detector.gains.e[0][1] = 0.0;
    assert_eq!(unsigned.computed_hash().unwrap(), signed.hash);
    let text = signed.to_json().unwrap();
    assert!(text.contains("-0.0"));
    let read = Design::from_json(&text).unwrap();
    assert!(read.detector.gains.e[0][1].is_sign_positive(), "one hash is one detector");
}

/// The specification inside a design outlives its format.
#[test]
fn specification_of_an_older_design_is_read() {
    let design = papers_design();
    let text = design.to_json().unwrap();
    for format in ["steerguard-design/1", "steerguard-design/2", "steerguard-design/3"] {
        let older = text.replacen(FORMAT, format, 1).replacen("\"detector\": ", "\"d\": ", 1);
        assert_ne!(older, text);
        assert_eq!(Design::spec_from_json(&older).unwrap(), design.spec);
    }
    // As it was written: what has a key since has its default.
    let written = include_str!("fixtures/steerguard-design-2.json");
    let spec = Design::spec_from_json(written).unwrap();
    assert_eq!(spec.evaluation.window(spec.sampling.period_s), 40);
    assert_eq!(spec.operating_range, OperatingRangeTable::PAPER);
    assert_eq!(spec.evaluation.alarm_hold_s, 1.0);
    let other = text.replacen(FORMAT, "another/1", 1);
    assert!(matches!(
        Design::spec_from_json(&other),
        Err(DesignFileError::Refused(Refusal::Format { .. }))
    ));
    let newer = text.replacen("\"lag_s\"", "\"lag_h\"", 1);
    let error = Design::spec_from_json(&newer).unwrap_err();
    assert!(matches!(error, DesignFileError::OldSpec { .. }));
    assert!(error.to_string().contains("actuator.lag_h"), "{error}");
}

#[test]
fn progress_names_every_step() {
    let mut steps = Vec::new();
    let mut spec = spec();
    spec.evaluation.calibration.manoeuvres = vec![Manoeuvre::Straight];
    design(&spec, &mut |step| steps.push(step)).unwrap();
    assert_eq!(
        steps,
        [
            Step::LargestBeta,
            Step::SmallestGamma,
            Step::Check,
            Step::Certify,
            Step::StartUp,
            Step::Calibration { done: 0, of: 4 },
            Step::Calibration { done: 4, of: 4 },
            Step::Sight,
        ]
    );
}

/// The obstacle of a specification that has no design.
fn obstacle(change: impl Fn(&mut Spec)) -> Obstacle {
    let mut spec = spec();
    change(&mut spec);
    match designed(&spec) {
        Err(DesignError::Infeasible(obstacle)) => obstacle,
        other => panic!("{other:?}"),
    }
}

#[test]
fn too_fast_a_decay_is_blamed_on_stability() {
    let found = obstacle(|spec| spec.design.decay = Some(0.5));
    let Obstacle::Stability { decay, smallest: Some(smallest) } = found else {
        panic!("{found:?}");
    };
    assert_eq!(decay, 0.5);
    assert!(found.to_string().contains("(33)"));
    // Its twin: the decay rate it names is possible.
    let mut twin = spec();
    twin.design.decay = Some(smallest);
    designed(&twin).unwrap();
}

#[test]
fn too_small_a_gamma_is_blamed_on_disturbance_attenuation() {
    let found = obstacle(|spec| spec.design.gamma = 1e-6);
    let Obstacle::Disturbance { gamma, smallest: Some(smallest), .. } = found else {
        panic!("{found:?}");
    };
    assert_eq!(gamma, Some(1e-6));
    assert!(smallest > 1e-6);
    assert!(found.to_string().contains("(31)"));
    // Its twin, not as tight, holds what was asked for.
    let mut twin = spec();
    twin.design.gamma = 5e-4;
    let design = designed(&twin).unwrap();
    assert!(design.synthesis.gamma <= 5e-4);
    assert!(design.synthesis.beta < 0.5 * design.synthesis.beta_bound);
    assert_eq!(design.synthesis.status, DesignStatus::Certified);
}

#[test]
fn a_useless_multiplier_is_blamed_on_fault_sensitivity() {
    let found = obstacle(|spec| spec.design.alpha_f = -1.0);
    assert!(matches!(found, Obstacle::Fault { alpha_f: -1.0, .. }), "{found:?}");
    assert!(found.to_string().contains("(32)"));
}
