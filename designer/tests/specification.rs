//! Specifications as users write them: the paper's file, and every kind of mistake.

#![allow(clippy::expect_used, clippy::unwrap_used)]

use steerguard_designer::Spec;
use steerguard_designer::document::MistakeKind;
use steerguard_designer::problem::model;
use steerguard_designer::spec::{Disturbance, Fault, MultiplierV};
use steerguard_test_support::cases::ReferenceCase;

const PAPER: &str = include_str!("../../examples/paper.toml");

#[test]
fn papers_file_spells_out_the_defaults() {
    assert_eq!(Spec::from_toml(PAPER).unwrap(), Spec::paper());
    assert_eq!(Spec::from_toml("").unwrap(), Spec::default());
}

#[test]
fn papers_file_names_every_key() {
    let of_file: toml::Table = PAPER.parse().unwrap();
    let of_spec = toml::Table::try_from(Spec::paper()).unwrap();
    assert_eq!(of_file, of_spec);
}

#[test]
fn a_specification_names_only_what_differs() {
    let spec = Spec::from_toml(
        r#"
        vehicle.mass_kg = 2000
        [[fault]]
        channel = "torque"
        smallest_n_m = 50
        [[disturbance]]
        name = "bank"
        kind = "bank"
        bound_deg = 3
        band_hz = [0, 50]
        [[disturbance]]
        name = "gust"
        kind = "yaw_moment"
        bound_n_m = 100
        band_hz = [0, 50]
        [design]
        V = [0, 1, 2]
        "#,
    )
    .unwrap();
    assert_eq!(spec.vehicle.mass_kg, 2000.0);
    assert_eq!(spec.vehicle.yaw_inertia_kg_m2, 1810.0);
    assert_eq!(spec.fault, [Fault::Torque { smallest_n_m: 50.0, band_hz: [0.0, 1.5] }]);
    assert_eq!(spec.disturbance[1].direction(&spec.vehicle), [0.0, 0.0, 1.0 / 1810.0]);
    assert_eq!(spec.design.v, MultiplierV::Given([0.0, 1.0, 2.0]));
}

#[test]
fn disturbances_act_as_documented() {
    let vehicle = Spec::paper().vehicle;
    let bank = Disturbance::Bank { name: "bank".into(), bound_deg: 3.0, band_hz: [0.0, 1.5] };
    let [_, lateral, yaw] = bank.direction(&vehicle);
    // With the left side raised by one degree, gravity pulls to the right.
    assert!((lateral + 9.80665 * std::f64::consts::PI / 180.0).abs() < 1e-15);
    assert_eq!(yaw, 0.0);
    let d = model::d(&Spec::paper());
    assert_eq!(d[1], 0.01);
    ReferenceCase::read("model").check("d_3", d[2]);
}

/// A key that nobody wrote stands in nobody's way.
#[test]
fn what_is_not_stated_follows_a_narrow_range() {
    let spec = Spec::from_toml(
        "[operating_range]\nv_x_m_per_s = [5, 7.4]\nv_y_m_per_s = [-0.3, 0.6]\n\
         r_rad_per_s = [-0.3, 0.3]",
    )
    .unwrap();
    let range = &spec.operating_range;
    let near = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-12, "{value}");
    near(range.v_x_hysteresis_m_per_s, 0.2);
    near(range.v_y_hysteresis_m_per_s, 0.075);
    near(range.r_hysteresis_rad_per_s, 0.05);
    let initial = spec.evaluation.calibration.initial_v_y_in(range.v_y_m_per_s);
    assert_eq!(initial, [-0.3, 0.0, 0.6]);
    let wide = Spec::default();
    assert_eq!(wide.operating_range.hysteresis(), [0.5, 0.5, 0.1]);
    let initial = wide.evaluation.calibration.initial_v_y_in(wide.operating_range.v_y_m_per_s);
    assert_eq!(initial, [-1.0, 0.0, 1.0]);
    // Stated, it is not touched.
    let stated = Spec::from_toml("operating_range.v_y_hysteresis_m_per_s = 1").unwrap();
    assert_eq!(stated.operating_range.v_y_hysteresis_m_per_s, 1.0);
}

/// The window of the default shrinks to what the detector holds, where a stated one is refused.
#[test]
fn the_window_is_in_seconds_or_samples() {
    for (text, samples) in [
        ("", 40),
        ("sampling.period_s = 0.02", 20),
        ("sampling.period_s = 0.001", 256),
        ("evaluation.window_s = 1", 100),
        ("evaluation.window_samples = 7", 7),
        ("sampling.period_s = 0.02\nevaluation.window_samples = 40", 40),
    ] {
        let text = format!("operating_range.v_x_m_per_s = [6, 30]\n{text}");
        let spec = Spec::from_toml(&text).unwrap();
        assert_eq!(spec.evaluation.window(spec.sampling.period_s), samples, "{text}");
    }
}

#[test]
fn signals_and_road_of_a_specification_reach_the_detector() {
    let spec = Spec::from_toml(
        "[sensors]\nsteering_offset_deg = 0.5\nyaw_rate_bias_deg_per_s = -0.3\n\
         [actuator]\nangle_limit_deg = 35\n\
         [uncertainty]\nsteering_ratio_percent = [-2, 3]\nsteering_offset_deg = 0.1\n\
         yaw_rate_bias_deg_per_s = 0.2\nv_x_scale_percent = 2\nfriction = [0.3, 1.0]\n\
         load_transfer_percent = 20",
    )
    .unwrap();
    let near = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-12, "{value}");
    let zero = spec.sensors.zero();
    near(zero.steering_offset_rad, 0.5_f64.to_radians());
    near(zero.yaw_rate_bias_rad_per_s, -0.3_f64.to_radians());
    near(spec.actuator.actuator().angle_limit_rad.unwrap(), 35_f64.to_radians());
    let bounds = spec.uncertainty.bounds();
    near(bounds.steering_ratio, 3.0 / 103.0);
    near(bounds.steering_offset_rad, 0.1_f64.to_radians());
    near(bounds.yaw_rate_bias_rad_per_s, 0.2_f64.to_radians());
    near(bounds.v_x_scale, 0.02);
    assert_eq!(bounds.friction, Some(0.3));
    near(bounds.load_transfer, 0.2);
    let endless = Spec::from_toml("uncertainty.friction = [10, 10]").unwrap();
    assert_eq!(endless.uncertainty.bounds().friction, None);
    // What nobody states is known, but for the transfer of load and tyres that end.
    let bounds = Spec::default().uncertainty.bounds();
    assert_eq!((bounds.friction, bounds.load_transfer), (Some(1.0), 0.1));
    assert_eq!((bounds.steering_ratio, bounds.v_x_scale), (0.0, 0.0));
    assert_eq!((bounds.steering_offset_rad, bounds.yaw_rate_bias_rad_per_s), (0.0, 0.0));
}

/// The message for a specification that shall be refused.
fn refusal(text: &str) -> String {
    Spec::from_toml(text).expect_err(text).to_string()
}

#[test]
fn mistakes_are_named_by_key_value_and_allowed_range() {
    let disturbance = "[[disturbance]]\nname = 'd'\n";
    let mut lacking = Vec::new();
    for (text, parts) in [
        // Keys.
        ("[vehicle", &["not valid TOML", "line 1"][..]),
        ("[vehicle]\nmass_g = 1", &["`vehicle.mass_g`", "did you mean `mass_kg`?", "unit"]),
        (
            "[vehicle]\ncornering_stiffness_n_per_deg = 1",
            &["`vehicle.cornering_stiffness_n_per_deg`", "cornering_stiffness_n_per_rad`?"],
        ),
        ("[vehicel]", &["unknown key `vehicel`", "did you mean `vehicle`?"]),
        ("[sampling]\nfrequency_hz = 100", &["`sampling.frequency_hz`", "known here are period_s"]),
        (
            "[evaluation.calibration]\nspeed = 3",
            &["`evaluation.calibration.speed`", "did you mean `speeds`?"],
        ),
        ("[noise]\nr = 1", &["`noise.r`"]),
        (
            "[noise.r]\nwhite_std = 1",
            &["`noise.r.white_std`", "did you mean `white_std_rad_per_s`"],
        ),
        (
            "noise.v_x.white_std_m_per_s = -1",
            &["`noise.v_x.white_std_m_per_s` = -1.0", "from 0 to 10"],
        ),
        ("noise.v_x.white_std_m_per_s = 100", &["`noise.v_x.white_std_m_per_s` = 100.0", "to 10"]),
        ("noise.r.bound_rad_per_s = 0", &["`noise.r.bound_rad_per_s` = 0.0", "above 0, up to 2"]),
        (
            "[[disturbance]]\nname = 'w'\nkind = 'side_wind'\nbound_m_per_s2 = 1e6\nband_hz = [0, 1]",
            &["`disturbance[0].bound_m_per_s2` = 1000000.0", "up to 100"],
        ),
        ("noise.v_x.band_hz = [0, 1.5]", &["`noise.v_x.band_hz`", "with a bound only"]),
        (
            "[noise.r]\nbound_rad_per_s = 0.001\nband_hz = [1, 2]",
            &["`noise.r.band_hz` = [1.0, 2.0]", "middle bands"],
        ),
        (
            "[[fault]]\nchannel = 'steering'\nsmallest_rad = 1",
            &["`fault[0].smallest_rad`", "did you mean `smallest_deg`?"],
        ),
        ("[[fault]]\nchannel = 'steering'\nsmallest_n_m = 1", &["`fault[0].smallest_n_m`"]),
        ("[[fault]]\nsmallest_deg = 1", &["`fault[0].channel` is missing"]),
        ("[[fault]]\nchannel = 'torque'", &["`fault[0].smallest_n_m` is missing"]),
        ("[[fault]]\nchannel = 'brake'", &["`fault[0]", "brake", "steering"]),
        // Types.
        ("vehicle.mass_kg = 'heavy'", &["`vehicle.mass_kg`", "heavy"]),
        ("operating_range.v_x_m_per_s = [5]", &["`operating_range.v_x_m_per_s"]),
        ("evaluation.window_samples = -1", &["`evaluation.window_samples`", "-1"]),
        ("design.V = \"G'\"", &["`design.V`", "three numbers"]),
        ("design.method = 'h2'", &["`design.method`", "h2", "gap", "paper"]),
        ("design.search_budget = 0", &["`design.search_budget` = 0", "from 1 to 10000"]),
        // Actuator.
        ("actuator.lag = 0.1", &["`actuator.lag`", "did you mean `lag_s`?", "unit"]),
        ("actuator.lag_s = -0.1", &["`actuator.lag_s` = -0.1", "from 0 to 5"]),
        ("actuator.lag_s = nan", &["`actuator.lag_s` = NaN"]),
        ("actuator.delay_s = 0.6", &["`actuator.delay_s` = 0.6", "from 0 to 0.5"]),
        (
            "sampling.period_s = 0.001\nactuator.delay_s = 0.3",
            &["`actuator.delay_s` = 0.3", "from 0 to 0.256"],
        ),
        (
            "actuator.rate_limit_rad_per_s = 0",
            &["`actuator.rate_limit_rad_per_s` = 0.0", "from 0.001 to 100"],
        ),
        (
            "evaluation.threshold = 'adaptativ'",
            &["`evaluation.threshold`", "calibrated", "adaptive"],
        ),
        ("actuator.angle_limit_deg = 0.5", &["`actuator.angle_limit_deg` = 0.5", "from 1 to 90"]),
        ("actuator.angle_limit_deg = 91", &["`actuator.angle_limit_deg` = 91.0", "from 1 to 90"]),
        ("actuator.angle_limit_rad = 0.6", &["did you mean `angle_limit_deg`?", "unit"]),
        (
            "actuator.angle_limit_deg = 15",
            &["`actuator.angle_limit_deg` = 15.0", "15.3 or more", "3 m/s^2 at 5.5 m/s"],
        ),
        // Sensors.
        ("sensors.steering_ratio = 0", &["`sensors.steering_ratio` = 0.0", "from 0.1 to 100"]),
        (
            "sensors.steering_offset_deg = 11",
            &["`sensors.steering_offset_deg` = 11.0", "from -10 to 10"],
        ),
        (
            "sensors.yaw_rate_bias_deg_per_s = -11",
            &["`sensors.yaw_rate_bias_deg_per_s` = -11.0", "from -10 to 10"],
        ),
        ("sensors.steering_offset = 1", &["did you mean `steering_offset_deg`?"]),
        // Vehicle.
        (
            "vehicle.centre_of_gravity_height_m = -0.1",
            &["`vehicle.centre_of_gravity_height_m` = -0.1", "from 0 to 3"],
        ),
        ("vehicle.centre_of_gravity_height_m = 3.1", &["= 3.1", "from 0 to 3"]),
        ("vehicle.mass_kg = 0", &["`vehicle.mass_kg` = 0.0", "> 0"]),
        ("vehicle.yaw_inertia_kg_m2 = -1", &["`vehicle.yaw_inertia_kg_m2` = -1.0"]),
        ("vehicle.front_axle_distance_m = nan", &["`vehicle.front_axle_distance_m` = NaN"]),
        ("vehicle.rear_cornering_stiffness_n_per_rad = inf", &["= inf", "finite"]),
        ("vehicle.lateral_drag_n_s2_per_m2 = -0.1", &["= -0.1", ">= 0"]),
        // Ranges.
        ("operating_range.v_x_m_per_s = [0, 30]", &["[0.0, 30.0]", "min > 0"]),
        ("operating_range.v_x_m_per_s = [30, 5]", &["[30.0, 5.0]", "min < max"]),
        ("operating_range.v_y_m_per_s = [0.1, 1]", &["[0.1, 1.0]", "min < 0 < max"]),
        ("operating_range.r_rad_per_s = [-1, nan]", &["`operating_range.r_rad_per_s`", "finite"]),
        (
            "operating_range.v_x_hysteresis_m_per_s = 12.5",
            &["v_x_hysteresis_m_per_s` = 12.5", "below half the range's width, 12.5"],
        ),
        ("operating_range.r_hysteresis_rad_per_s = -0.1", &["= -0.1"]),
        // Sampling.
        ("sampling.period_s = 0", &["`sampling.period_s` = 0.0", "from 0.0001 to 0.1"]),
        ("sampling.period_s = 0.05", &["v_x_m_per_s", "above 11.258", "sampling.period_s = 0.05"]),
        ("operating_range.v_x_m_per_s = [1, 30]", &["[1.0, 30.0]", "above 2.25"]),
        // Channels.
        ("fault = []", &["`fault` = 0", "from 1 to 8"]),
        ("[[fault]]\nchannel = 'steering'\nsmallest_deg = 0", &["`fault[0].smallest_deg` = 0.0"]),
        (
            "[[fault]]\nchannel = 'steering'\nsmallest_deg = 1e-9",
            &["`fault[0].smallest_deg` = 1e-9", "from 0.001 to 90"],
        ),
        (
            "[[fault]]\nchannel = 'steering'\nband_hz = [0, 51]",
            &["`fault[0].band_hz` = [0.0, 51.0]", "50 Hz, the Nyquist frequency"],
        ),
        (
            "[[fault]]\nchannel = 'steering'\nband_hz = [1, 2]",
            &["`fault[0].band_hz` = [1.0, 2.0]", "middle bands"],
        ),
        ("[[fault]]\nchannel = 'steering'\nband_hz = [2, 1]", &["[2.0, 1.0]", "from < to"]),
        ("disturbance = []", &["`disturbance` = 0", "from 1 to 8"]),
        (
            &format!("{disturbance}kind = 'side_wind'\nbound_m_per_s2 = -1"),
            &["`disturbance[0].bound_m_per_s2` = -1.0"],
        ),
        (
            &format!("{disturbance}kind = 'side_wind'\nbound_deg = 1"),
            &["`disturbance[0].bound_deg`"],
        ),
        (&format!("{disturbance}kind = 'hail'"), &["`disturbance[0]", "hail", "side_wind"]),
        (
            &format!("{disturbance}kind = 'direction'\ndirection = [0, 0, 0]\nbound = 1"),
            &["`disturbance[0].direction`", "not all zero"],
        ),
        (
            &format!(
                "{disturbance}kind = 'bank'\nbound_deg = 1\n{disturbance}kind = 'bank'\n\
                 bound_deg = 1\nband_hz = [1, 3]"
            ),
            &["`disturbance[1].band_hz` = [1.0, 3.0]", "middle bands"],
        ),
        // Design and evaluation.
        ("design.gamma = 0", &["`design.gamma` = 0.0"]),
        ("design.alpha_d = inf", &["`design.alpha_d` = inf"]),
        ("design.V = [0, 1, 0]", &["`design.V` = [0.0, 1.0, 0.0]", "||C V'||"]),
        ("design.decay = 1", &["`design.decay` = 1.0", "between 0 and 1"]),
        ("design.decay_per_s = 0", &["`design.decay_per_s` = 0.0", "a finite number > 0"]),
        (
            "design.decay = 0.97\ndesign.decay_per_s = 3",
            &["`design.decay_per_s` = 3.0", "nothing beside design.decay", "state one of them"],
        ),
        (
            "[[fault]]\nchannel = \"steering\"\nlargest_deg = 0.2",
            &["`fault[0].largest_deg` = 0.2", "from 0.5 to 90"],
        ),
        ("design.beta_fraction = 1.01", &["`design.beta_fraction` = 1.01"]),
        ("evaluation.window_samples = 257", &["= 257", "from 1 to 256"]),
        ("evaluation.window_samples = 0", &["= 0", "from 1 to 256"]),
        ("evaluation.window_s = 0", &["`evaluation.window_s` = 0.0", "> 0"]),
        (
            "evaluation.window_s = 2.57",
            &["`evaluation.window_s` = 2.57", "from 0.01 to 2.56, 1 to 256 samples"],
        ),
        (
            "sampling.period_s = 0.001\nevaluation.window_s = 0.4",
            &["`evaluation.window_s` = 0.4", "from 0.001 to 0.256, 1 to 256 samples"],
        ),
        (
            "evaluation.window_s = 0.4\nevaluation.window_samples = 40",
            &["`evaluation.window_samples` = 40", "nothing beside `window_s`", "one of the two"],
        ),
        ("evaluation.alarm_hold_s = -1", &["`evaluation.alarm_hold_s` = -1.0", "from 0 to 3600"]),
        ("evaluation.weights = [0, 0]", &["[0.0, 0.0]", "not both 0"]),
        ("evaluation.weights = [1e200, 1e-200]", &["1e200", "from 0.000001 to 1000000"]),
        ("evaluation.margin = 0.9", &["`evaluation.margin` = 0.9", "from 1 to 100"]),
        (
            "evaluation.calibration.search_drives = 399",
            &["`evaluation.calibration.search_drives` = 399", "0, or from 400 to 1000000 drives"],
        ),
        (
            "evaluation.covers = 'worst_case'\nevaluation.calibration.search_drives = 0",
            &["`evaluation.covers` = \"worst_case\"", "give the search drives, 500 for instance"],
        ),
        (
            "evaluation.covers = 'worst_case'\nevaluation.threshold = 'calibrated'",
            &["`evaluation.covers` = \"worst_case\"", "only the threshold \"adaptive\""],
        ),
        (
            "evaluation.threshold = 'constant'",
            &["`evaluation.constant` is missing", "another kind"],
        ),
        (
            "evaluation.threshold = 'constant'\nevaluation.constant = 0",
            &["`evaluation.constant` = 0.0", "from 0.000000001 to 1000"],
        ),
        (
            "evaluation.constant = 0.001",
            &["`evaluation.constant` = 0.001", "threshold = \"constant\""],
        ),
        (
            "evaluation.threshold = 'guaranteed'",
            &["`noise.v_x.bound_m_per_s` is missing", "4 standard deviations, 0.08"],
        ),
        (
            "uncertainty.mass_percent = [5, 10]",
            &["`uncertainty.mass_percent` = [5.0, 10.0]", "min <= 0 <= max"],
        ),
        (
            "uncertainty.steering_ratio_percent = [1, 2]",
            &["`uncertainty.steering_ratio_percent` = [1.0, 2.0]", "-50 <= min <= 0 <= max <= 100"],
        ),
        (
            "uncertainty.steering_offset_deg = -1",
            &["`uncertainty.steering_offset_deg` = -1.0", "from 0 to 10"],
        ),
        (
            "uncertainty.yaw_rate_bias_deg_per_s = 11",
            &["`uncertainty.yaw_rate_bias_deg_per_s` = 11.0", "from 0 to 10"],
        ),
        (
            "uncertainty.v_x_scale_percent = 51",
            &["`uncertainty.v_x_scale_percent` = 51.0", "from 0 to 50"],
        ),
        (
            "uncertainty.load_transfer_percent = 101",
            &["`uncertainty.load_transfer_percent` = 101.0", "from 0 to 100"],
        ),
        (
            "uncertainty.friction = [0.8, 0.7]",
            &["`uncertainty.friction` = [0.8, 0.7]", "0.05 <= min <= max <= 10", "wet 0.7"],
        ),
        ("uncertainty.friction = [0.01, 1]", &["`uncertainty.friction` = [0.01, 1.0]"]),
        ("uncertainty.friction = 0.7", &["`uncertainty.friction`"]),
        ("uncertainty.bank_deg = -1", &["`uncertainty.bank_deg` = -1.0", "from 0 to 45"]),
        ("uncertainty.gust_m_per_s = nan", &["`uncertainty.gust_m_per_s` = NaN"]),
        ("uncertainty.gust_speed_m_per_s = 10", &["did you mean `gust_m_per_s`"]),
        ("uncertainty.gust = 10", &["`uncertainty.gust`", "known here are mass_percent"]),
        (
            "actuator.delay_s = 0.4\nuncertainty.actuator_delay_s = 0.2",
            &["`uncertainty.actuator_delay_s` = 0.2", "from 0 to"],
        ),
        ("evaluation.debounce_samples = 0", &["`evaluation.debounce_samples` = 0"]),
        ("evaluation.debounce_samples = 1000000", &["= 1000000", "from 1 to 1000"]),
        ("evaluation.calibration.speeds = 0", &["calibration.speeds` = 0"]),
        ("evaluation.calibration.manoeuvres = []", &["calibration.manoeuvres` = 0"]),
        ("evaluation.calibration.manoeuvres = ['jump']", &["manoeuvres[0]", "jump", "weave"]),
        ("evaluation.calibration.initial_v_y_m_per_s = [5]", &["= 5.0", "from -4 to 4"]),
        ("evaluation.calibration.duration_s = 1", &["duration_s` = 1.0"]),
        (
            "[evaluation.calibration]\nspeeds = 100\ndisturbance_phases = 100",
            &["`evaluation.calibration` = 1170000 drives", "at most 100000"],
        ),
    ] {
        let message = refusal(text);
        let missing = parts.iter().filter(|part| !message.contains(**part));
        lacking.extend(missing.map(|part| format!("{text}\ngave: {message}\nwithout: {part}\n")));
    }
    assert!(lacking.is_empty(), "{}", lacking.join("\n"));
}

/// Neutral as specified, so that half of the vehicles within the uncertainty oversteer.
const NEUTRAL: &str = "
[vehicle]
front_axle_distance_m = 1.3
rear_axle_distance_m = 1.3
front_cornering_stiffness_n_per_rad = 40000
rear_cornering_stiffness_n_per_rad = 40000
";

/// The speed at which the linear single-track model with these stiffnesses has a real root at 0, by halving.
fn speed_of_a_root_at_zero(spec: &Spec, mass: f64, c_f: f64, c_r: f64) -> f64 {
    let v = &spec.vehicle;
    let (l_f, l_r) = (v.front_axle_distance_m, v.rear_axle_distance_m);
    let determinant = |v_x: f64| {
        let moment = 2.0 * (c_r * l_r - c_f * l_f);
        let lateral = [-2.0 * (c_f + c_r) / (mass * v_x), moment / (mass * v_x) - v_x];
        let i_z = v.yaw_inertia_kg_m2;
        let yaw = [moment / (i_z * v_x), -2.0 * (c_f * l_f * l_f + c_r * l_r * l_r) / (i_z * v_x)];
        lateral[0] * yaw[1] - lateral[1] * yaw[0]
    };
    let (mut stable, mut unstable) = (0.1, 1e4);
    if determinant(unstable) > 0.0 {
        return f64::INFINITY;
    }
    for _ in 0..100 {
        let middle = 0.5 * (stable + unstable);
        if determinant(middle) > 0.0 { stable = middle } else { unstable = middle }
    }
    stable
}

#[test]
fn the_critical_speed_is_the_lowest_of_all_vehicles_within_the_uncertainty() {
    let spec = Spec::from_toml(NEUTRAL).unwrap();
    let ends = |nominal: f64, [min, max]: [f64; 2]| {
        [nominal * (1.0 + min / 100.0), nominal * (1.0 + max / 100.0)]
    };
    let (v, u) = (&spec.vehicle, &spec.uncertainty);
    let mut lowest = f64::INFINITY;
    for mass in ends(v.mass_kg, u.mass_percent) {
        for c_f in ends(v.front_cornering_stiffness_n_per_rad, u.front_cornering_stiffness_percent)
        {
            for c_r in
                ends(v.rear_cornering_stiffness_n_per_rad, u.rear_cornering_stiffness_percent)
            {
                lowest = lowest.min(speed_of_a_root_at_zero(&spec, mass, c_f, c_r));
            }
        }
    }
    let critical = spec.lowest_critical_speed().unwrap();
    assert!((critical / lowest - 1.0).abs() < 1e-9, "{critical} and {lowest}");
    assert_eq!(Spec::default().lowest_critical_speed(), None);
}

#[test]
fn a_range_beyond_a_critical_speed_is_refused_by_that_name() {
    let with = |v_x: &str, further: &str| {
        format!("{NEUTRAL}[operating_range]\nv_x_m_per_s = {v_x}\n{further}")
    };
    let message = refusal(&with("[5, 60]", ""));
    for part in [
        "`operating_range.v_x_m_per_s` = [5.0, 60.0]",
        "with mass +10 %, front_cornering_stiffness +10 % and rear_cornering_stiffness -10 %",
        "critical speed of 35.6 m/s",
        "lower max",
    ] {
        assert!(message.contains(part), "{part} in {message}");
    }
    // What is named is possible, the next number is not.
    assert!(Spec::from_toml(&with("[5, 35.6]", "")).is_ok());
    refusal(&with("[5, 35.7]", ""));
    // The less is uncertain, the faster it may be; a vehicle that is known does not oversteer.
    let known = "[uncertainty]\nmass_percent = [-10, 0]\n\
                 front_cornering_stiffness_percent = [-10, 0]\n\
                 rear_cornering_stiffness_percent = [0, 10]\n";
    assert!(Spec::from_toml(&with("[5, 60]", known)).is_ok());
    let rear_heavy =
        with("[5, 60]", "").replace("front_axle_distance_m = 1.3", "front_axle_distance_m = 1.5");
    let message = refusal(&(rear_heavy + known));
    assert!(
        message.contains("the vehicle oversteers") && !message.contains("with mass"),
        "{message}"
    );
}

#[test]
fn errors_can_be_matched() {
    let error = Spec::from_toml("design.gama = 1").unwrap_err();
    let [mistake] = error.list() else { panic!("{error}") };
    assert_eq!(mistake.key, "design.gama");
    assert!(
        matches!(&mistake.kind, MistakeKind::UnknownKey { nearest: Some(x), .. } if x == "gamma")
    );
}
