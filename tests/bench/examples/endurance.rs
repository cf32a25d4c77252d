//! What a long time does to the packaged detector: 1e8 samples of a drive that repeats itself.
//!
//! `cargo run --release -p steerguard-bench --example endurance [SAMPLES]` prints time, memory before and after, and how
//! far the outputs of the last repetition are from those of an early one, of the default design and with its second
//! test. At 0.01 s a sample, 1e8 are 11.6 days, and the time ends at 1e6 s.

use std::time::Instant;

use steerguard_bench::{Detector, Error, designs, fmu, with_second_test};
use steerguard_fmu::BakedDesign;

/// Samples after which the drive repeats itself, and repetitions before the one that is compared with.
const PERIOD: u64 = 2000;
const SETTLED: u64 = 50;
const SAMPLES: u64 = 100_000_000;

/// A weave at a speed that swings, without a fault.
fn inputs(k: u64) -> [f64; 4] {
    let phase = (k % PERIOD) as f64 / PERIOD as f64 * std::f64::consts::TAU;
    let delta = 0.01 * (3.0 * phase).sin();
    // Yaw rate of the steady turn, near enough for the threshold.
    [15.0 + 0.1 * phase.sin(), 4.3 * delta, 78.75, delta]
}

/// Outputs of a repetition, one sample after the other.
fn repetition(detector: &mut Detector) -> Vec<[f64; 5]> {
    let sample = |k| {
        detector.set(&inputs(k));
        detector.step();
        let [residual_v_x, residual_r, j_rms, j_th] = detector.get();
        [residual_v_x, residual_r, j_rms, j_th, detector.detectability()]
    };
    (0..PERIOD).map(sample).collect()
}

/// Resident memory of this process, kB; 0 where the system does not say.
fn memory_kb() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}

fn endure(name: &str, design: &BakedDesign, samples: u64) -> Result<(), Error> {
    let step_s = design.configuration.model.sampling_period_s;
    let mut detector = Detector::packaged(&fmu(design)?, step_s)?;
    for _ in 0..SETTLED {
        repetition(&mut detector);
    }
    let (early, before_kb, start) = (repetition(&mut detector), memory_kb(), Instant::now());
    let mut late = early.clone();
    for _ in SETTLED + 1..samples / PERIOD {
        late = repetition(&mut detector);
    }
    // Each output on the scale of its largest value.
    let largest = |of: &[[f64; 5]], i: usize| of.iter().map(|x| x[i].abs()).fold(0.0, f64::max);
    let deviation = (0..5).map(|i| {
        let differences = early.iter().zip(&late).map(|(a, b)| (a[i] - b[i]).abs());
        differences.fold(0.0, f64::max) / largest(&early, i)
    });
    println!(
        "{name}: {:.0e} samples, to {:.0} s, in {:.0} s; {before_kb} kB before, {} kB after; largest deviation of \
         an output {:.1e} of its largest value",
        samples as f64,
        samples as f64 * step_s,
        start.elapsed().as_secs_f64(),
        memory_kb(),
        deviation.fold(0.0, f64::max)
    );
    Ok(())
}

fn main() -> Result<(), Error> {
    let samples = std::env::args().nth(1).map_or(Ok(SAMPLES), |text| text.parse())?;
    let [_, (_, default)] = designs()?;
    endure("default design", &default, samples)?;
    endure("with the second test", &with_second_test()?, samples / 10)
}
