//! Windowed RMS and start-up term against their definitions.

use proptest::prelude::*;
use steerguard_detector::{Evaluation, MAX_WINDOW, Rms, StartUp};

fn evaluation(window: usize, amplitude: f64, decay: f64) -> Evaluation {
    Evaluation {
        window,
        weights: [1.0, 1.0],
        threshold: 1.0,
        uncertainty_share: 1.0,
        start_up_amplitude: amplitude,
        start_up_decay: decay,
        debounce_samples: 1,
        alarm_hold_s: 0.0,
    }
}

#[test]
fn a_large_sample_leaves_no_trace_once_it_has_left_the_window() {
    let mut rms = Rms::EMPTY;
    let mut fresh = Rms::EMPTY;
    rms.push(1e30, 40);
    fresh.push(0.0, 40);
    for k in 0..100_000_u32 {
        let square = f64::from(k % 97) * 1e-6;
        let j = rms.push(square, 40);
        let reference = fresh.push(square, 40);
        if k >= 39 {
            assert_eq!(j.to_bits(), reference.to_bits());
        }
    }
    // Twice the window: the ring has forgotten it too.
    assert_eq!(rms, fresh);
}

proptest! {
    /// Every sum of n not negative numbers, whatever its order, is within n - 1 roundings of the exact
    /// one: Higham (2002), 4.2. The quotient and the root add one each, and the root halves the others.
    #[test]
    fn rms_is_that_of_the_last_samples_over_the_whole_window(
        residuals in prop::collection::vec(-10.0..10.0_f64, 1..700), window in 1..=MAX_WINDOW,
    ) {
        let mut rms = Rms::EMPTY;
        for k in 0..residuals.len() {
            let j = rms.push(residuals[k] * residuals[k], window);
            let last = &residuals[(k + 1).saturating_sub(window)..=k];
            let sum: f64 = last.iter().fold(0.0, |sum, r| sum + r * r);
            let reference = (sum / window as f64).sqrt();
            // Both are rounded.
            let tolerance = (window as f64 + 2.0) * f64::EPSILON * reference;
            prop_assert!((j - reference).abs() <= tolerance, "{j} instead of {reference}");
        }
    }

    /// Of whole numbers the sums are exact, whatever their order.
    #[test]
    fn rms_of_whole_squares_is_exact(
        squares in prop::collection::vec(0..1_000_000_u32, 1..700), window in 1..=MAX_WINDOW,
    ) {
        let mut rms = Rms::EMPTY;
        for k in 0..squares.len() {
            let j = rms.push(f64::from(squares[k]), window);
            let last = &squares[(k + 1).saturating_sub(window)..=k];
            let sum: f64 = last.iter().copied().map(f64::from).sum();
            prop_assert_eq!(j.to_bits(), (sum / window as f64).sqrt().to_bits());
        }
    }

    #[test]
    fn start_up_term_is_the_rms_of_its_bound(
        window in 1..=MAX_WINDOW, amplitude in 0.0..1.0, decay in 0.0..0.999,
    ) {
        let evaluation = evaluation(window, amplitude, decay);
        let (mut start_up, mut rms) = (StartUp::RESTARTED, Rms::EMPTY);
        for j in 0..600 {
            let bound = amplitude * decay.powi(j);
            let reference = rms.push(bound * bound, window);
            let term = start_up.next(&evaluation);
            prop_assert!((term - reference).abs() <= 1e-11 * amplitude, "{term} against {reference}");
        }
    }
}
