//! Tries the fleet of `tests/fleet/cars.toml` with default keys, a table of what came out:
//!
//! ```text
//! tests/fleet/run [--all] [--seed S] [NAME...]
//! ```
//!
//! Each car is designed, proven, packaged and checked, and driven by 100 biases and 100 fault-free drives
//! of 60 s. The cars as they stand and their neutral-steer variants; `--all` adds those drawn from a grid of
//! stiffnesses. With names, those alone whose names hold one of them. What was made is kept until the
//! specification or the command changes: a run that was ended goes on where it was.

use std::error::Error;
use std::fmt;

#[path = "../tests/common/fleet/mod.rs"]
mod fleet;

use fleet::cars::fleet;
use fleet::trial::{Made, Trial, Trials};

/// Drives with biases of a car, and as many without a fault.
const DRIVES: u64 = 100;
/// More than there are cars.
const CARS: u64 = 1000;

/// A row of the table.
struct Row<'a> {
    car: &'a str,
    trial: &'a Trial,
}

impl Row<'_> {
    const HEAD: &'static str = "\
| car | from deg | period s | v_x to | decay | ratio | gap | F deg | status | check | biases deg | detected \
| missed | masked | not exposed | drives with alarm | J/J_th | monitored % | design s |
|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|";
}

impl fmt::Display for Row<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { car, trial } = self;
        let (period_s, [_, v_x_max]) =
            (trial.spec.sampling.period_s, trial.spec.operating_range.v_x_m_per_s);
        write!(f, "| {car} | {:.2} | {period_s} | {v_x_max:.1} | ", trial.smallest_deg())?;
        match &trial.made {
            Ok(made) => {
                let performance = &made.design.performance;
                let [from_deg, to_deg] = made.bias_deg;
                write!(
                    f,
                    "{:.4} | {:.2} | {:.2} | {:.3} | {} | {} | {from_deg:.2}..{to_deg:.2}",
                    performance.decay,
                    performance.detection_ratio,
                    performance.certified.map_or(0.0, |x| x.gap),
                    made.bank_and_wind_deg(),
                    status(made),
                    if made.findings == 0 { "clean".into() } else { made.findings.to_string() },
                )?;
                let (biases, free) = (made.biases, made.fault_free);
                write!(
                    f,
                    " | {} | {} | {} | {} | {} | {:.3} | {:.1}",
                    biases.detected,
                    biases.missed,
                    biases.masked,
                    biases.not_exposed,
                    free.with_alarm,
                    free.largest_ratio,
                    100.0 * free.monitored
                )
            }
            Err(said) => {
                let line = said.split_whitespace().collect::<Vec<_>>().join(" ");
                write!(f, " | | | | {line} | | | | | | | | |")
            }
        }?;
        write!(f, " | {:.1} |", trial.seconds)
    }
}

/// What a design may be called, once `verify` has said so too.
fn status(made: &Made) -> String {
    let status = format!("{:?}", made.design.synthesis.status).to_lowercase();
    match &made.design.synthesis.unproven {
        Some(missed) => format!("{status}: {missed}"),
        None if !made.proven => format!("{status}, not proven"),
        None => status,
    }
}

/// The sum over the fleet: a car counts by its last trial, its time by the first.
fn summary(trials: &[Vec<Trial>]) -> String {
    let count = |what: &dyn Fn(&Made) -> bool| {
        let last = trials.iter().filter_map(|trials| trials.last()?.made.as_ref().ok());
        last.filter(|made| what(made)).count()
    };
    let made: Vec<&Made> =
        trials.iter().filter_map(|trials| trials.last()?.made.as_ref().ok()).collect();
    let again = trials.iter().filter(|trials| trials.len() > 1).count();
    let sum = |of: &dyn Fn(&Made) -> u64| made.iter().map(|made| of(made)).sum::<u64>();
    let percent = |part: u64, of: u64| 100.0 * part as f64 / of.max(1) as f64;
    let least = |of: &dyn Fn(&Made) -> f64| made.iter().map(|x| of(x)).fold(100.0, f64::min);
    let most = |of: &dyn Fn(&Made) -> u64| made.iter().map(|x| of(x)).max().unwrap_or(0);
    let biases = sum(&|made| made.biases.faults);
    let detected = sum(&|made| made.biases.detected);
    let drives = sum(&|made| made.fault_free.drives);
    let with_alarm = sum(&|made| made.fault_free.with_alarm);
    let mut seconds: Vec<f64> = trials.iter().map(|trials| trials[0].seconds).collect();
    seconds.sort_by(f64::total_cmp);
    format!(
        "{} cars: {} designed, {} proven, {} checked clean, {} see their smallest fault ({again} of them \
         with 3 F as the smallest)\n\
         biases: {detected} of {biases} detected, {:.2} %; least of a car {:.1} %\n\
         fault free: {with_alarm} of {drives} drives with an alarm; most of a car {}\n\
         monitored while the speed was in range: least of a car {:.1} %\n\
         design: median {:.1} s, worst {:.1} s",
        trials.len(),
        made.len(),
        count(&|made| made.proven),
        count(&|made| made.findings == 0),
        count(&|made| !made.is_blind()),
        percent(detected, biases),
        least(&|made| percent(made.biases.detected, made.biases.faults)),
        most(&|made| made.fault_free.with_alarm),
        least(&|made| 100.0 * made.fault_free.monitored),
        seconds.get(seconds.len() / 2).copied().unwrap_or(0.0),
        seconds.last().copied().unwrap_or(0.0),
    )
}

const USAGE: &str = "tests/fleet/run [--all] [--seed S] [NAME...]";

fn main() -> Result<(), Box<dyn Error>> {
    let (mut all, mut seed, mut names) = (false, 1, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--all" => all = true,
            "--seed" => seed = arguments.next().ok_or(USAGE)?.parse().map_err(|_| USAGE)?,
            option if option.starts_with("--") => {
                return Err(format!("{option}: not an option; {USAGE}").into());
            }
            name => names.push(name.to_owned()),
        }
    }
    // target/PROFILE/examples/fleet
    let this = std::env::current_exe()?;
    let profile = this.ancestors().nth(2).ok_or("no folder of executables")?;
    let steerguard = profile.join("steerguard");

    println!("{}", Row::HEAD);
    let mut tried = Vec::new();
    for (place, car) in fleet(all)?.into_iter().enumerate() {
        if names.is_empty() || names.iter().any(|name| car.name.contains(name.as_str())) {
            // Each car is driven its own drives, with or without the others.
            let seed = CARS * seed + place as u64;
            let trials = Trials { steerguard: steerguard.clone(), drives: DRIVES, seed };
            let of_car = trials.of(car.spec()?)?;
            for trial in &of_car {
                println!("{}", Row { car: &car.name, trial });
            }
            tried.push(of_car);
        }
    }
    println!("\n{}", summary(&tried));
    Ok(())
}
