//! The world against formulas that stand beside it: steady turns, tyre limits, axle loads, symmetry.

use proptest::prelude::*;
use steerguard_detector::{Actuator, StateVector, Vehicle};
use steerguard_world::{
    Excitation, GRAVITY_M_PER_S2, STEP_S, State, Steering, TrueVehicle, Tyres, World,
    bank_m_per_s2, steady_angle,
};

const LINEAR: World = World::of(TrueVehicle::linear(Vehicle::PAPER), Steering::DIRECT);

/// `[v_x, v_y, r]` from `start` after `steps` steps of 1 ms in `world`.
fn run(world: &World, start: StateVector, excitation: &Excitation, steps: u32) -> StateVector {
    let mut state = State::new(world, STEP_S, start.into(), excitation.command_rad);
    for _ in 0..steps {
        state.step(world, excitation, STEP_S);
    }
    state.motion.vector()
}

/// Holds `v_x` on a straight road under the command `command_rad`.
fn cruise(v_x: f64, command_rad: f64) -> Excitation {
    Excitation {
        drive_torque_n_m: Vehicle::PAPER.cruise_torque(v_x),
        command_rad,
        ..Excitation::default()
    }
}

/// Vehicle data by factors of Table 1's: mass, yaw inertia, front and rear stiffness.
fn scaled([mass, yaw_inertia, front, rear]: [f64; 4]) -> Vehicle {
    let v = Vehicle::PAPER;
    Vehicle {
        mass_kg: mass * v.mass_kg,
        effective_longitudinal_inertia_kg_m: mass * v.effective_longitudinal_inertia_kg_m,
        yaw_inertia_kg_m2: yaw_inertia * v.yaw_inertia_kg_m2,
        front_cornering_stiffness_n_per_rad: front * v.front_cornering_stiffness_n_per_rad,
        rear_cornering_stiffness_n_per_rad: rear * v.rear_cornering_stiffness_n_per_rad,
        ..v
    }
}

#[test]
fn a_fault_acts_as_the_same_commanded_angle() {
    let faulty = Excitation { fault_rad: 0.01, ..cruise(15.0, 0.0) };
    let start = [15.0, 0.0, 0.0];
    assert_eq!(run(&LINEAR, start, &cruise(15.0, 0.01), 5000), run(&LINEAR, start, &faulty, 5000));
}

/// r = v delta / (L + K v^2), K = M (l_r C_r - l_f C_f) / (2 L C_f C_r): Rajamani (2012), 3.3.
#[test]
fn steady_turns_have_the_single_track_models_yaw_rate_and_slip() {
    let v = Vehicle::PAPER;
    let (l_f, l_r) = (v.front_axle_distance_m, v.rear_axle_distance_m);
    let (c_f, c_r) = (v.front_cornering_stiffness_n_per_rad, v.rear_cornering_stiffness_n_per_rad);
    let wheelbase = l_f + l_r;
    let gradient = v.mass_kg * (l_r * c_r - l_f * c_f) / (2.0 * wheelbase * c_f * c_r);
    for speed in [6.0, 15.0, 28.0] {
        for delta in [0.01, -0.01] {
            let [v_x, v_y, r] = run(&LINEAR, [speed, 0.0, 0.0], &cruise(speed, delta), 5000);
            let expected = v_x * delta / (wheelbase + gradient * v_x * v_x);
            assert!((r / expected - 1.0).abs() < 1e-3, "{r} rad/s instead of {expected}");
            let slip = l_r * r / v_x - v.mass_kg * l_f * v_x * r / (2.0 * c_r * wheelbase);
            assert!((v_y / v_x - slip).abs() < 1e-3 * slip.abs().max(delta.abs()), "{v_y} m/s");
            let angle = steady_angle(&v, v_x, v_x * r);
            assert!((angle / delta.abs() - 1.0).abs() < 1e-3, "{angle} rad");
        }
    }
}

#[test]
fn a_bank_with_the_left_side_raised_pulls_to_the_right() {
    let world = World { bank_rad: 0.05, ..LINEAR };
    assert!((bank_m_per_s2(0.05) + 9.80665 * 0.05_f64.sin()).abs() < 1e-15);
    let [_, v_y, _] = run(&world, [15.0, 0.0, 0.0], &cruise(15.0, 0.0), 10);
    assert!(v_y < 0.0, "{v_y} m/s");
    // Held straight by f = K g sin b, whatever the speed.
    let v = Vehicle::PAPER;
    let (l_f, l_r) = (v.front_axle_distance_m, v.rear_axle_distance_m);
    let (c_f, c_r) = (v.front_cornering_stiffness_n_per_rad, v.rear_cornering_stiffness_n_per_rad);
    let gradient = v.mass_kg * (l_r * c_r - l_f * c_f) / (2.0 * (l_f + l_r) * c_f * c_r);
    for speed in [6.0, 29.0] {
        let command = gradient * GRAVITY_M_PER_S2 * 0.05_f64.sin();
        let [_, _, r] = run(&world, [speed, 0.0, 0.0], &cruise(speed, command), 5000);
        assert!(r.abs() < 1e-5, "{r} rad/s at {speed} m/s");
    }
}

#[test]
fn saturation_vanishes_at_small_slip_and_bounds_large() {
    let slick = Tyres::Saturating { friction: 0.3 };
    assert!((slick.force_n(10.0, 5000.0) - 10.0).abs() < 1e-3);
    for force in [1e6, -1e6, f64::MAX, f64::MIN] {
        assert_eq!(slick.force_n(force, 5000.0), 1500_f64.copysign(force));
        assert_eq!(slick.force_n(force, 0.0), 0.0);
        assert_eq!(Tyres::Linear.force_n(force, 5000.0), force);
    }
    // Both axles at their limits: mu M g in all, whatever the steering.
    let vehicle = TrueVehicle { tyres: slick, ..LINEAR.vehicle };
    let [front, rear] = vehicle.axle_forces_n([20.0, -100.0, 0.0].into(), 0.0, 0.0);
    let weight = Vehicle::PAPER.mass_kg * GRAVITY_M_PER_S2;
    assert!((front + rear - 0.3 * weight).abs() < 1e-9 * weight);
}

#[test]
fn braking_loads_the_front_axle() {
    let v = Vehicle { centre_of_gravity_height_m: 0.57, ..Vehicle::PAPER };
    let vehicle = TrueVehicle::linear(v);
    let wheelbase = v.front_axle_distance_m + v.rear_axle_distance_m;
    let [still_front, still_rear] = v.axle_loads_n(0.0);
    for a_x in [-8.0, -2.5, 0.0, 3.0] {
        let [front, rear] = v.axle_loads_n(a_x);
        let shift = v.mass_kg * a_x * 0.57 / wheelbase;
        assert!((front - (still_front - shift)).abs() < 1e-9);
        assert!((rear - (still_rear + shift)).abs() < 1e-9);
        // Moments about the centre of gravity, of loads and inertia force.
        let moment = v.front_axle_distance_m * front - v.rear_axle_distance_m * rear
            + v.mass_kg * a_x * 0.57;
        assert!(moment.abs() < 1e-8, "{moment} N m");
        // Cornering stiffness goes with the load.
        let x = [20.0, 0.2, 0.1].into();
        let [still, braked] = [0.0, a_x].map(|a_x| vehicle.axle_forces_n(x, 0.01, a_x));
        assert!((braked[0] / still[0] - front / still_front).abs() < 1e-12);
        assert!((braked[1] / still[1] - rear / still_rear).abs() < 1e-12);
    }
    // A lifted axle carries nothing.
    assert_eq!(v.axle_loads_n(1e3)[0], 0.0);
    assert_eq!(v.axle_loads_n(-1e3)[1], 0.0);
    // Without height nothing shifts.
    assert_eq!(LINEAR.vehicle.data.axle_loads_n(-8.0), LINEAR.vehicle.data.axle_loads_n(0.0));
}

/// Coasting without steering, drag or wind, tyres only take energy.
#[test]
fn tyres_dissipate() {
    let data = Vehicle {
        longitudinal_drag_n_m_s2_per_m2: 0.0,
        lateral_drag_n_s2_per_m2: 0.0,
        ..Vehicle::PAPER
    };
    for tyres in [Tyres::Linear, Tyres::Saturating { friction: 0.8 }] {
        let world = World::of(TrueVehicle { tyres, ..TrueVehicle::linear(data) }, Steering::DIRECT);
        let energy = |[v_x, v_y, r]: StateVector| {
            0.5 * data.mass_kg * (v_x * v_x + v_y * v_y) + 0.5 * data.yaw_inertia_kg_m2 * r * r
        };
        let mut state = State::new(&world, STEP_S, [20.0, 2.0, -0.5].into(), 0.0);
        let mut before = energy(state.motion.vector());
        for _ in 0..3000 {
            state.step(&world, &Excitation::default(), STEP_S);
            let now = energy(state.motion.vector());
            // Rounding: a few ulps a step.
            assert!(now <= before * (1.0 + 8.0 * f64::EPSILON), "{now} J after {before} J");
            before = now;
        }
        let [v_x, v_y, r] = state.motion.vector();
        assert!(v_y.abs() < 1e-3 && r.abs() < 1e-3 && v_x > 19.0, "{:?}", state.motion);
    }
}

/// Half the step is much nearer to a quarter of it: the method's fourth order.
#[test]
fn steps_converge_to_fourth_order() {
    let steering = Steering::of(Actuator { lag_s: 0.1, ..Actuator::NONE });
    let world = World::of(LINEAR.vehicle, steering);
    let after = |steps: u32| {
        let h = 0.8 / f64::from(steps);
        let mut state = State::new(&world, h, [10.0, 1.0, -0.2].into(), 0.0);
        let excitation = cruise(10.0, 0.05);
        for _ in 0..steps {
            state.step(&world, &excitation, h);
        }
        state.motion.vector()
    };
    let [coarse, middle, fine] = [20, 40, 80].map(after);
    let distance = |a: StateVector, b: StateVector| (a[1] - b[1]).hypot(a[2] - b[2]);
    let order = (distance(coarse, middle) / distance(middle, fine)).log2();
    assert!((3.7..4.5).contains(&order), "order {order}");
}

fn world() -> impl Strategy<Value = World> {
    let factor = || 0.8..1.2_f64;
    (
        [factor(), factor(), factor(), factor()],
        prop::option::of(0.2..1.0_f64),
        (0.0..0.7_f64, -0.1..0.1_f64),
        (0.0..0.2_f64, 0.0..0.1_f64, prop::option::of(0.1..1.0_f64)),
        (prop::option::of(0.01..0.6_f64), 0.8..1.2_f64, -0.02..0.02_f64),
    )
        .prop_map(
            |(factors, friction, (height, bank_rad), actuator, (limit, ratio, offset_rad))| {
                let (lag_s, delay_s, rate_limit_rad_per_s) = actuator;
                World {
                    vehicle: TrueVehicle {
                        data: Vehicle { centre_of_gravity_height_m: height, ..scaled(factors) },
                        tyres: friction
                            .map_or(Tyres::Linear, |friction| Tyres::Saturating { friction }),
                    },
                    steering: Steering {
                        actuator: Actuator {
                            lag_s,
                            delay_s,
                            rate_limit_rad_per_s,
                            angle_limit_rad: limit,
                        },
                        ratio,
                        offset_rad,
                    },
                    bank_rad,
                }
            },
        )
}

fn excitation() -> impl Strategy<Value = Excitation> {
    let p = || -2.0..2.0_f64;
    (-3000.0..2000.0_f64, -0.2..0.2_f64, -0.05..0.05_f64, [p(), p(), p()]).prop_map(
        |(drive_torque_n_m, command_rad, fault_rad, push)| Excitation {
            drive_torque_n_m,
            command_rad,
            fault_rad,
            push,
        },
    )
}

proptest! {
    /// Mirrored left and right, everything in the world gives the mirrored drive, to the last bit.
    #[test]
    fn the_world_is_symmetric(
        world in world(),
        excitations in prop::collection::vec(excitation(), 20),
        v_x in 5.0..30.0_f64,
        v_y in -3.0..3.0_f64,
        r in -0.6..0.6_f64,
    ) {
        let mirrored_world = World {
            bank_rad: -world.bank_rad,
            steering: Steering { offset_rad: -world.steering.offset_rad, ..world.steering },
            ..world
        };
        let mirror = |e: &Excitation| Excitation {
            command_rad: -e.command_rad,
            fault_rad: -e.fault_rad,
            push: [e.push[0], -e.push[1], -e.push[2]],
            ..*e
        };
        let mut state = State::new(&world, STEP_S, [v_x, v_y, r].into(), 0.0);
        let mut mirrored = State::new(&mirrored_world, STEP_S, [v_x, -v_y, -r].into(), 0.0);
        for excitation in &excitations {
            for _ in 0..50 {
                state.step(&world, excitation, STEP_S);
                mirrored.step(&mirrored_world, &mirror(excitation), STEP_S);
            }
            let [v_x, v_y, r] = state.motion.vector();
            prop_assert_eq!(mirrored.motion.vector(), [v_x, -v_y, -r]);
            prop_assert_eq!(mirrored.steering.angle_rad, -state.steering.angle_rad);
            prop_assert!(state.motion.vector().iter().all(|x| x.is_finite()));
        }
    }

    /// The wheel keeps to its limits, whatever is commanded.
    #[test]
    fn the_steering_keeps_to_its_limits(
        world in world(),
        commands in prop::collection::vec(-1e4..1e4_f64, 20),
    ) {
        let steering = world.steering;
        let mut state = State::new(&world, STEP_S, [15.0, 0.0, 0.0].into(), 0.0).steering;
        for command in commands {
            for _ in 0..30 {
                let [begin, middle, end] = state.step(&steering, STEP_S, command);
                if let Some(limit) = steering.actuator.angle_limit_rad {
                    prop_assert!(end.abs() <= limit + 1e-12);
                }
                if let Some(limit) = steering.actuator.rate_limit_rad_per_s {
                    let most = limit * STEP_S * (1.0 + 1e-12) + 1e-15;
                    prop_assert!((end - begin).abs() <= most);
                    prop_assert!((end - middle).abs() <= 0.5 * most + 1e-15);
                }
            }
        }
    }
}
