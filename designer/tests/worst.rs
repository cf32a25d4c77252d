//! The search for the worst fault-free drive: what it may drive, and what it must find.

#![allow(clippy::unwrap_used)]

use rayon::ThreadPoolBuilder;
use steerguard_designer::spec::UncertaintyTable;
use steerguard_designer::worst::{Family, FamilyWorst, Objective, Search, drive::Drive, worst};
use steerguard_designer::{Design, Spec};
use steerguard_detector::{Configuration, Interval};
use steerguard_world::{Steering, Stream, Tyres, steady_angle};

#[path = "common/fixtures.rs"]
mod fixtures;

const SEARCH: Search = Search { objective: Objective::Residual, budget: 400, seed: 7 };

/// A design with an adaptive threshold.
fn design() -> Design {
    let fixture = fixtures::all().into_iter().find(|fixture| fixture.name == "gap").unwrap();
    Design::from_json(&std::fs::read_to_string(fixture.design).unwrap()).unwrap()
}

fn found(spec: &Spec, configuration: &Configuration, families: &[Family]) -> Vec<FamilyWorst> {
    worst(spec, configuration, families, SEARCH, &|_| ()).unwrap()
}

/// Drives of random points of `family`.
fn drives(family: Family, spec: &Spec) -> impl Iterator<Item = Drive> {
    let dimension = family.dimension(spec) as u64;
    (0..200).map(move |index| {
        let numbers = Stream::new(index, 0);
        let point: Vec<f64> = (0..dimension).map(|i| numbers.within(i, 4.0)).collect();
        family.drive(spec, &point, 1)
    })
}

/// Everything of `[uncertainty]` stated.
fn every_key() -> Spec {
    let uncertainty = UncertaintyTable {
        actuator_lag_s: 0.02,
        actuator_delay_s: 0.03,
        steering_ratio_percent: [-5.0, 10.0],
        steering_offset_deg: 0.2,
        yaw_rate_bias_deg_per_s: 0.3,
        v_x_scale_percent: 2.0,
        friction: [0.8, 1.0],
        ..UncertaintyTable::DEFAULT
    };
    Spec { uncertainty, ..Spec::default() }
}

#[test]
fn results_do_not_depend_on_the_number_of_processors() {
    let design = design();
    let families = Family::of(&design.spec);
    let on = |processors: usize| {
        let workers = ThreadPoolBuilder::new().num_threads(processors).build().unwrap();
        workers.install(|| found(&design.spec, &design.configuration(), &families))
    };
    let one = on(1);
    assert_eq!(one.iter().map(|found| found.family).collect::<Vec<_>>(), families);
    assert_eq!(one, on(2));
    assert_eq!(one, on(5));
    let search = Search { seed: 8, ..SEARCH };
    let other = worst(&design.spec, &design.configuration(), &families, search, &|_| ()).unwrap();
    assert_ne!(one, other);
}

#[test]
fn a_search_finds_more_than_drives_at_random_do() {
    let design = design();
    let search = Search { budget: 1000, ..SEARCH };
    let families = Family::of(&design.spec);
    let found = worst(&design.spec, &design.configuration(), &families, search, &|_| ()).unwrap();
    for found in found {
        assert!(found.drives <= search.budget);
        let (ratio, at_random) = (found.ratio().unwrap(), found.ratio_at_random.unwrap());
        println!("{}: {ratio:.4}, at random {at_random:.4}", found.family.name());
        assert!(ratio.is_finite() && ratio > 1.1 * at_random, "{}", found.family.name());
        // The largest of the calibration's drives is 1 over the margin, by the threshold's choice.
        assert!(ratio > 1.0 / design.spec.evaluation.margin, "{}", found.family.name());
        // What is kept is what was driven.
        let (drive, worst) = found.worst.unwrap();
        let judge = Objective::Residual.judge(&design.configuration()).unwrap();
        assert_eq!(drive.worst(&design.spec, judge), Some(worst));
    }
}

#[test]
fn drives_stay_within_what_is_stated() {
    let spec = every_key();
    let (u, v) = (&spec.uncertainty, &spec.vehicle);
    let period_s = spec.sampling.period_s;
    let near = |value: f64, [min, max]: [f64; 2]| {
        let slack = 1e-12 * (1.0 + min.abs().max(max.abs()));
        (min - slack..=max + slack).contains(&value)
    };
    let slopes = |values: &[f64]| -> f64 {
        let slope = |pair: &[f64]| (pair[1] - pair[0]).abs() / period_s;
        values.windows(2).map(slope).fold(0.0, f64::max)
    };
    for family in Family::of(&spec) {
        for drive in drives(family, &spec) {
            let vehicle = &drive.vehicle;
            for (value, nominal, interval) in [
                (vehicle.mass_kg, v.mass_kg, u.mass_percent),
                (vehicle.yaw_inertia_kg_m2, v.yaw_inertia_kg_m2, u.yaw_inertia_percent),
                (
                    vehicle.front_cornering_stiffness_n_per_rad,
                    v.front_cornering_stiffness_n_per_rad,
                    u.front_cornering_stiffness_percent,
                ),
                (
                    vehicle.rear_cornering_stiffness_n_per_rad,
                    v.rear_cornering_stiffness_n_per_rad,
                    u.rear_cornering_stiffness_percent,
                ),
                (
                    vehicle.centre_of_gravity_height_m,
                    v.centre_of_gravity_height_m,
                    [-u.load_transfer_percent, u.load_transfer_percent],
                ),
            ] {
                assert!(near(100.0 * (value / nominal - 1.0), interval), "{value} {nominal}");
            }
            let courses = &drive.courses;
            let speeds = &courses.speed_m_per_s;
            assert!(speeds.iter().all(|&speed| near(speed, spec.operating_range.v_x_m_per_s)));
            assert!(slopes(speeds) <= 3.0 + 1e-9);
            assert!(slopes(&courses.steering_rad) <= 0.3 + 1e-9);
            for (angle, speed) in courses.steering_rad.iter().zip(speeds) {
                // A speed that rises takes the limit down faster than the steering may follow.
                let most = steady_angle(v, (speed - 3.0).max(5.3), 3.0);
                assert!(angle.abs() <= most + 1e-12, "{angle} at {speed} m/s");
            }
            assert!(courses.bank_deg.iter().all(|&bank| near(bank, [-3.0, 3.0])));
            assert!(courses.wind_m_per_s.iter().all(|&wind| near(wind, [-10.0, 10.0])));
            match family {
                Family::Constant => assert_eq!(slopes(&courses.bank_deg), 0.0),
                Family::SlowBank => assert!(slopes(&courses.bank_deg) <= 1.0 + 1e-9),
                _ => {}
            }
            if matches!(family, Family::Constant | Family::SlowBank) {
                // The steepest 1-cosine gust.
                assert!(slopes(&courses.wind_m_per_s) <= 10.0 * std::f64::consts::PI / 0.5);
            }
        }
    }
}

#[test]
fn each_key_has_its_family_and_varies_in_that_alone() {
    let spec = every_key();
    let names: Vec<&str> = Family::of(&spec).into_iter().map(Family::name).collect();
    assert_eq!(
        names,
        [
            "constant",
            "slow_bank",
            "any_course",
            "friction",
            "actuator_lag_s",
            "actuator_delay_s",
            "steering_ratio_percent",
            "steering_offset_deg",
            "yaw_rate_bias_deg_per_s",
            "v_x_scale_percent",
            "load_transfer_percent",
            "all",
            "friction_beyond",
        ]
    );
    let varies = |family: Family| -> Vec<&str> {
        let mut varied = Vec::new();
        for drive in drives(family, &spec) {
            let Steering { actuator, ratio, offset_rad } = drive.steering;
            let height = drive.vehicle.centre_of_gravity_height_m;
            for (name, differs) in [
                ("friction", drive.tyres != Tyres::Linear),
                ("actuator_lag_s", actuator.lag_s != 0.0),
                ("actuator_delay_s", actuator.delay_s != 0.0),
                ("steering_ratio_percent", ratio != 1.0),
                ("steering_offset_deg", offset_rad != 0.0),
                ("yaw_rate_bias_deg_per_s", drive.yaw_rate_bias_rad_per_s != 0.0),
                ("v_x_scale_percent", drive.v_x_scale != 0.0),
                ("load_transfer_percent", height != spec.vehicle.centre_of_gravity_height_m),
            ] {
                if differs && !varied.contains(&name) {
                    varied.push(name);
                }
            }
        }
        varied
    };
    for family in [Family::Constant, Family::SlowBank, Family::AnyCourse] {
        assert_eq!(varies(family), [""; 0]);
    }
    for family in &Family::of(&spec)[3..11] {
        assert_eq!(varies(*family), [family.name()]);
    }
    let mut all = varies(Family::All);
    all.sort_unstable();
    let mut keys = names[3..11].to_vec();
    keys.sort_unstable();
    assert_eq!(all, keys);
    let friction = |family| {
        drives(family, &spec).map(|drive| match drive.tyres {
            Tyres::Saturating { friction } => friction,
            Tyres::Linear => f64::INFINITY,
        })
    };
    assert!(friction(Family::Friction).all(|mu| (0.8..=1.0).contains(&mu)));
    assert!(friction(Family::BeyondFriction).all(|mu| (mu - 0.56).abs() < 1e-12));
    assert!(Family::of(&spec).iter().all(|f| f.is_stated() == (*f != Family::BeyondFriction)));
}

#[test]
fn what_is_known_does_not_vary() {
    let design = design();
    let spec = Spec {
        uncertainty: UncertaintyTable { friction: [10.0, 10.0], ..UncertaintyTable::NONE },
        ..design.spec.clone()
    };
    let families = Family::of(&spec);
    assert_eq!(
        families,
        [Family::Constant, Family::SlowBank, Family::AnyCourse, Family::BeyondFriction]
    );
    for found in found(&spec, &design.configuration(), &families[..3]) {
        let (drive, worst) = found.worst.unwrap();
        assert!(worst.ratio.is_finite());
        assert_eq!(drive.vehicle, spec.vehicle);
        assert_eq!(drive.tyres, Tyres::Linear);
        assert_eq!(drive.steering, Steering::DIRECT);
        let courses = drive.courses;
        assert!(courses.bank_deg.iter().chain(&courses.wind_m_per_s).all(|&x| x == 0.0));
        assert!(courses.steering_rad.iter().any(|&angle| angle != 0.0));
    }
}

#[test]
fn a_detector_that_never_monitors_has_no_ratio_and_a_broken_one_is_refused() {
    let design = design();
    let mut elsewhere = design.configuration();
    elsewhere.model.range.v_x = Interval::new(100.0, 110.0);
    for found in found(&design.spec, &elsewhere, &[Family::Constant, Family::AnyCourse]) {
        assert_eq!((found.ratio(), found.ratio_at_random), (None, None));
    }
    let mut broken = design.configuration();
    broken.evaluation.threshold = f64::NAN;
    let error = worst(&design.spec, &broken, &[Family::Constant], SEARCH, &|_| ()).unwrap_err();
    assert_eq!(error.field, "threshold");
}

#[test]
fn every_budget_is_kept() {
    let design = design();
    for budget in [1, 4, 17, 100] {
        let search = Search { budget, seed: 1, ..SEARCH };
        let families = [Family::Constant];
        let done = std::sync::atomic::AtomicU64::new(0);
        let count = |drives| {
            done.fetch_add(drives, std::sync::atomic::Ordering::Relaxed);
        };
        let found =
            worst(&design.spec, &design.configuration(), &families, search, &count).unwrap();
        let drives = found[0].drives;
        // A drive at random, and one like the worst so far twice.
        assert!(drives <= budget.max(4), "{drives} of {budget}");
        assert_eq!(done.into_inner(), drives);
        assert!(found[0].ratio().is_some());
    }
}

/// What is tried first is what its words say, in every family.
#[test]
fn suspects_are_heavy_vehicles_at_the_ends_braked_in_a_turn() {
    let spec = every_key();
    let (u, v) = (&spec.uncertainty, &spec.vehicle);
    let percent = |of: f64, nominal: f64| (100.0 * (of / nominal - 1.0)).round();
    for family in Family::of(&spec) {
        let drives: Vec<Drive> =
            family.suspects(&spec).iter().map(|point| family.drive(&spec, point, 1)).collect();
        let mut met = Vec::new();
        for Drive { vehicle, start, courses, .. } in &drives {
            assert_eq!(percent(vehicle.mass_kg, v.mass_kg), u.mass_percent[1]);
            assert_eq!(percent(vehicle.yaw_inertia_kg_m2, v.yaw_inertia_kg_m2), 0.0);
            let front = percent(
                vehicle.front_cornering_stiffness_n_per_rad,
                v.front_cornering_stiffness_n_per_rad,
            );
            let rear = percent(
                vehicle.rear_cornering_stiffness_n_per_rad,
                v.rear_cornering_stiffness_n_per_rad,
            );
            assert!(front == -rear && u.front_cornering_stiffness_percent.contains(&front));
            let speeds = &courses.speed_m_per_s;
            assert!(speeds.windows(2).all(|pair| pair[1] <= pair[0]), "braked");
            assert!(courses.steering_rad.iter().all(|&angle| angle >= 0.0), "to the left");
            let aside = courses.wind_m_per_s.iter().sum::<f64>();
            met.push((front > 0.0, start.v_x_m_per_s > 10.0, aside > 0.0));
        }
        met.sort_unstable();
        met.dedup();
        assert_eq!(met.len(), 8, "{}", family.name());
    }
}

#[test]
fn the_second_test_has_worst_drives_of_its_own() {
    let design = design();
    let configuration = design.configuration();
    let search = Search { objective: Objective::Second, ..SEARCH };
    let families = [Family::AnyCourse, Family::All];
    let found = worst(&design.spec, &configuration, &families, search, &|_| ()).unwrap();
    let judge = Objective::Second.judge(&configuration).unwrap();
    for found in found {
        let (ratio, at_random) = (found.ratio().unwrap(), found.ratio_at_random.unwrap());
        println!("{}: {ratio:.4}, at random {at_random:.4}", found.family.name());
        assert!(ratio > at_random);
        let (drive, worst) = found.worst.unwrap();
        assert_eq!(drive.worst(&design.spec, judge), Some(worst));
    }
    // Of a detector without the second test there is nothing to find.
    let without = Configuration { estimator: None, ..configuration };
    let found = worst(&design.spec, &without, &families[..1], search, &|_| ()).unwrap();
    assert_eq!(found[0].ratio(), Some(0.0));
}
