//! The N-TS model against the nonlinear vehicle it rewrites.

use proptest::prelude::*;
use steerguard_detector::{Input, Measurement, TsModel, Vehicle, VehicleState};
use steerguard_test_support::cases::ReferenceCase;
use steerguard_test_support::integration::rk4;

const PAPER: TsModel = TsModel::PAPER;

fn membership(v_x_m_per_s: f64, r_rad_per_s: f64) -> [f64; 4] {
    PAPER.membership(Measurement { v_x_m_per_s, r_rad_per_s })
}

#[test]
fn vertices_have_the_reference_entries() {
    let reference = ReferenceCase::read("model");
    let [slow, _, fast, _] = PAPER.vertices();
    reference.check("a_22_at_5_m_per_s", slow[1][1]);
    reference.check("a_22_at_30_m_per_s", fast[1][1]);
    reference.check("a_32_at_5_m_per_s", slow[2][1]);
    reference.check("a_32_at_30_m_per_s", fast[2][1]);
    let b = PAPER.b();
    reference.check("f_2_per_rad", b[1][1]);
    reference.check("f_3_per_rad", b[2][1]);
}

#[test]
fn each_rule_stands_alone_at_its_vertex() {
    let corners = [(5.0, -0.55), (5.0, 0.55), (30.0, -0.55), (30.0, 0.55)];
    for (rule, (v_x, r)) in corners.into_iter().enumerate() {
        for (i, h) in membership(v_x, r).into_iter().enumerate() {
            assert!((h - f64::from(u8::from(i == rule))).abs() < 1e-15);
        }
    }
}

#[test]
fn runge_kutta_has_order_four() {
    let x = [12.0, 0.8, 0.3];
    let f = |x: [f64; 3]| {
        Vehicle::PAPER.derivative(x.into(), Input { t_eng_n_m: 60.0, delta_rad: 0.05 })
    };
    let run = |steps: u32| (0..steps).fold(x, |x, _| rk4(f, x, 0.2 / f64::from(steps)));
    let exact = run(4096);
    let error =
        |steps| run(steps).iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let order = (error(16) / error(32)).log2();
    assert!((3.7..4.3).contains(&order), "observed order {order}");
}

proptest! {
    #[test]
    fn membership_is_convex(v_x in 5.0..=30.0, r in -0.55..=0.55) {
        let h = membership(v_x, r);
        prop_assert!(h.iter().all(|h| (-1e-15..=1.0 + 1e-15).contains(h)));
        prop_assert!((h.iter().sum::<f64>() - 1.0).abs() < 1e-14);
    }

    /// (7) is (3) by Euler's rule, rewritten: method 2.
    #[test]
    fn blend_equals_the_nonlinear_euler_step(
        v_x in 5.0..=30.0, v_y in -1.5..=1.5, r in -0.55..=0.55,
        t_eng in -2000.0..2000.0, delta in -0.5..0.5,
    ) {
        let (x, u) = (VehicleState::from([v_x, v_y, r]), Input { t_eng_n_m: t_eng, delta_rad: delta });
        let slope = PAPER.vehicle.derivative(x, u);
        for ((blend, x), slope) in PAPER.step(x, u).vector().into_iter().zip(x.vector()).zip(slope) {
            let euler = x + PAPER.sampling_period_s * slope;
            prop_assert!((blend - euler).abs() < 1e-12, "{blend} against {euler}");
        }
    }
}
