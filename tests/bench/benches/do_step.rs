//! doStep of the packaged library through the C interface, against the same mathematics in plain C.
//!
//! For the paper's design and the default one. Criterion reports both; the ratio is that of medians over
//! batches measured in turn, so that whatever else the machine does meets both alike. Last, the cost of a
//! sample against the length of the window, and with and without the second test.
#![allow(missing_docs, reason = "made by criterion's macro")]

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use steerguard_bench::{Detector, Error, designs, fmu, inputs, with_second_test};
use steerguard_fmu::BakedDesign;

const BATCHES: usize = 401;
const STEPS: u64 = 5000;

/// What a batch repeats.
type Work = fn(&mut Detector, u64);

const WORKS: [(&str, Work); 2] = [("doStep", step), ("set, doStep, get", cycle)];

fn step(detector: &mut Detector, _k: u64) {
    black_box(detector.step());
}

fn cycle(detector: &mut Detector, k: u64) {
    black_box(detector.set(&inputs_of(k)));
    black_box(detector.step());
    black_box(detector.get());
}

/// Inputs without the cost of their sines.
fn inputs_of(k: u64) -> [f64; 4] {
    let weave = (k % 64) as f64 * 1e-4;
    [15.0 + weave, weave, 78.75, weave]
}

/// Lengths of the window that are compared, samples.
const WINDOWS: [usize; 6] = [10, 20, 40, 80, 160, 256];

fn pair(design: &BakedDesign) -> Result<[(&'static str, Detector); 2], Error> {
    let configuration = &design.configuration;
    let step_s = configuration.model.sampling_period_s;
    let mut pair = [
        ("packaged FMU", Detector::packaged(&fmu(design)?, step_s)?),
        ("plain C", Detector::plain_c(configuration, step_s)?),
    ];
    // Both are in their steady state, with the same outputs.
    for k in 0..1000 {
        let outputs = pair.each_mut().map(|(_, detector)| {
            detector.set(&inputs(k));
            detector.step();
            detector.get().map(f64::to_bits)
        });
        let [ours, theirs] = outputs;
        assert_eq!(ours, theirs, "outputs at sample {k}");
    }
    Ok(pair)
}

fn batch(detector: &mut Detector, work: Work) -> Duration {
    let start = Instant::now();
    for k in 0..STEPS {
        work(detector, k);
    }
    start.elapsed()
}

fn median(mut times: Vec<Duration>) -> f64 {
    times.sort_unstable();
    times.get(times.len() / 2).map_or(f64::NAN, Duration::as_secs_f64)
}

/// Medians in ns of a step of both, measured in turn.
fn in_turn(pair: &mut [(&str, Detector); 2], work: Work) -> [f64; 2] {
    let [(_, packaged), (_, plain)] = pair;
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    for _ in 0..BATCHES {
        ours.push(batch(packaged, work));
        theirs.push(batch(plain, work));
    }
    [ours, theirs].map(|times| median(times) / STEPS as f64 * 1e9)
}

fn compare(criterion: &mut Criterion) {
    if let Err(error) = designs().and_then(|designs| {
        for (name, design) in &designs {
            of_design(criterion, name, design)?;
        }
        let [_, (_, default)] = &designs;
        of_windows(default)?;
        of_second_test(default)
    }) {
        eprintln!("error: {error}");
    }
}

fn of_design(criterion: &mut Criterion, name: &str, design: &BakedDesign) -> Result<(), Error> {
    let mut pair = pair(design)?;
    for (work_name, work) in WORKS {
        let mut group = criterion.benchmark_group(format!("{name} design: {work_name}"));
        for (who, detector) in &mut pair {
            let mut k = 0;
            group.bench_function(*who, |bencher| {
                bencher.iter(|| {
                    k += 1;
                    work(detector, k);
                });
            });
        }
        group.finish();
        let [ours, theirs] = in_turn(&mut pair, work);
        println!(
            "{name} design: {work_name}: packaged FMU {ours:.1} ns, plain C {theirs:.1} ns, ratio {:.2}\n",
            ours / theirs
        );
    }
    Ok(())
}

/// Draws the cost of a sample of `design` against the length of the window.
fn of_windows(design: &BakedDesign) -> Result<(), Error> {
    println!("default design: doStep against the window's length");
    for window in WINDOWS {
        let mut design = *design;
        design.configuration.evaluation.window = window;
        let [ours, _] = in_turn(&mut pair(&design)?, step);
        println!("{window:>5} samples {ours:>7.1} ns  {}", "#".repeat((ours / 5.0) as usize));
    }
    Ok(())
}

/// What the second test costs beside the `default` design.
fn of_second_test(default: &BakedDesign) -> Result<(), Error> {
    let packaged = |name, design: &BakedDesign| -> Result<_, Error> {
        let step_s = design.configuration.model.sampling_period_s;
        let mut detector = Detector::packaged(&fmu(design)?, step_s)?;
        for k in 0..1000 {
            detector.set(&inputs(k));
            detector.step();
        }
        Ok((name, detector))
    };
    let mut pair = [packaged("without", default)?, packaged("with", &with_second_test()?)?];
    let bytes = [pair[0].1.state_bytes()?, pair[1].1.state_bytes()?];
    let [lean, rich] = in_turn(&mut pair, cycle);
    println!(
        "default design, second test: set, doStep, get {lean:.1} ns without, {rich:.1} ns with; \
         state {} and {} bytes",
        bytes[0], bytes[1]
    );
    Ok(())
}

criterion_group!(benches, compare);
criterion_main!(benches);
