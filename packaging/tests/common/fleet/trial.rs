//! A car's trial: designed, proven, packaged and checked, then driven with biases and without a fault.
//!
//! # Conventions
//! - Everything is asked of the command `steerguard`, and kept until specification or command change.
//! - Biases are from b = max(1 deg, 3 F) to 2 b, F being what bank and wind look like (method 12).
//! - Drives are those of the command's campaigns: 60 s, vehicle, road and air within `[uncertainty]`.
//! - Where the smallest fault of interest is not seen, and bank and wind hide as much, the car is tried once
//!   more with 3 F as its smallest fault of interest.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Instant;

use serde::Deserialize;
use serde_json::Value;
use steerguard_designer::spec::Fault;
use steerguard_designer::{Design, DesignStatus, Spec};
use steerguard_test_support::once::made_by;

/// Smallest bias that is driven, deg, and as a multiple of F.
const SMALLEST_DEG: f64 = 1.0;
const OF_BANK_AND_WIND: f64 = 3.0;

/// What is asked of every car.
#[derive(Clone, Debug)]
pub struct Trials {
    /// The command `steerguard`.
    pub steerguard: PathBuf,
    /// Drives with biases, and as many without a fault.
    pub drives: u64,
    /// Seed of the drives.
    pub seed: u64,
}

/// What came of a specification.
#[derive(Debug)]
pub struct Trial {
    /// What was asked for.
    pub spec: Spec,
    /// How long the design took, s.
    pub seconds: f64,
    /// The design, or why there is none.
    pub made: Result<Made, String>,
}

/// A design and what it is worth.
#[derive(Debug)]
pub struct Made {
    /// The design.
    pub design: Design,
    /// Whether `verify` proves it.
    pub proven: bool,
    /// Number of findings of `check` in its package.
    pub findings: usize,
    /// Size of the biases, deg.
    pub bias_deg: [f64; 2],
    /// What became of the biases.
    pub biases: Biases,
    /// What the drives without a fault show.
    pub fault_free: FaultFree,
}

/// Biases of a campaign.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
pub struct Biases {
    /// Their number.
    pub faults: u64,
    /// Those detected.
    pub detected: u64,
    /// Those missed.
    pub missed: u64,
    /// Those behind a false alarm.
    pub masked: u64,
    /// Those that never acted while the detector monitored.
    pub not_exposed: u64,
}

/// Drives without a fault.
#[derive(Clone, Copy, Debug)]
pub struct FaultFree {
    /// Their number.
    pub drives: u64,
    /// Those with an alarm.
    pub with_alarm: u64,
    /// Largest J/J_th.
    pub largest_ratio: f64,
    /// Time monitored, as a share of the time that the speed was in range.
    pub monitored: f64,
}

/// The report of a campaign, as far as it is read.
#[derive(Deserialize)]
struct Report {
    driven_h: f64,
    monitored_h: f64,
    out_of_range_by_cause: [f64; 3],
    false_alarms: Vec<FalseAlarms>,
    detections: Vec<Biases>,
}

#[derive(Deserialize)]
struct FalseAlarms {
    drives_with_episodes: u64,
    largest_ratio: Option<f64>,
}

impl Made {
    /// F, deg.
    pub fn bank_and_wind_deg(&self) -> f64 {
        self.design.performance.sight.as_ref().map_or(0.0, |sight| sight.bank_and_wind_deg)
    }

    /// Whether it misses its smallest fault of interest.
    pub fn is_blind(&self) -> bool {
        self.design.synthesis.status == DesignStatus::Blind
    }
}

impl Trials {
    /// The trial of `spec`, and that with 3 F as its smallest fault where it is called for.
    ///
    /// # Errors
    /// Where the command does not do what it must whatever the car.
    pub fn of(&self, spec: Spec) -> Result<Vec<Trial>, Box<dyn Error>> {
        let mut trials = vec![self.one(spec)?];
        if let Some(spec) = trials[0].seen_spec() {
            trials.push(self.one(spec)?);
        }
        Ok(trials)
    }

    fn one(&self, spec: Spec) -> Result<Trial, Box<dyn Error>> {
        let text = toml::to_string(&spec)?;
        let key = format!("design, FMU and verdicts of {text}");
        let folder = made_by(&key, &[&self.steerguard], |folder| {
            fs::write(folder.join("spec.toml"), &text)?;
            let start = Instant::now();
            let designed = self.run(folder, &["design", "spec.toml"])?;
            if designed.status.code().is_none() {
                return Err(format!("design: {}", designed.status).into());
            }
            fs::write(folder.join("seconds"), start.elapsed().as_secs_f64().to_string())?;
            fs::write(folder.join("said"), designed.stderr)?;
            if folder.join("design.json").is_file() {
                let verified = self.json(folder, &["verify", "design.json"])?;
                fs::write(folder.join("verified.json"), verified.to_string())?;
                let allow = ["--allow", "uncertified,blind"];
                self.json(folder, &[&["package", "design.json"], &allow[..]].concat())?;
                let checked = self.json(folder, &["check", "SteeringFaultDetector.fmu"])?;
                fs::write(folder.join("checked.json"), checked.to_string())?;
            }
            Ok::<_, Box<dyn Error>>(())
        })?;
        let read = |name: &str| fs::read_to_string(folder.join(name));
        let seconds = read("seconds")?.parse()?;
        let made = match read("design.json") {
            Ok(design) => Ok(self.made(&folder, Design::from_json(&design)?)?),
            Err(_) => Err(read("said")?),
        };
        Ok(Trial { spec, seconds, made })
    }

    /// Drives the `design` in `folder`.
    fn made(&self, folder: &Path, design: Design) -> Result<Made, Box<dyn Error>> {
        let value = |name: &str| -> Result<Value, Box<dyn Error>> {
            Ok(serde_json::from_str(&fs::read_to_string(folder.join(name))?)?)
        };
        let sight = design.performance.sight.as_ref();
        let from_deg = sight.map_or(SMALLEST_DEG, |sight| {
            SMALLEST_DEG.max(OF_BANK_AND_WIND * sight.bank_and_wind_deg)
        });
        let bias_deg = [from_deg, 2.0 * from_deg];
        let sizes = format!("{}..{}", bias_deg[0], bias_deg[1]);
        let biases = self.campaign(folder, &["--faults", "bias", "--fault-deg", &sizes])?;
        let fault_free = self.campaign(folder, &["--faults", "none"])?;
        let [out_for_v_x, ..] = fault_free.out_of_range_by_cause;
        let of_all = fault_free.false_alarms.first();
        Ok(Made {
            proven: value("verified.json")?["holds"] == Value::Bool(true),
            findings: value("checked.json")?["findings"].as_array().map_or(1, Vec::len),
            bias_deg,
            biases: biases.detections.first().copied().unwrap_or_default(),
            fault_free: FaultFree {
                drives: self.drives,
                with_alarm: of_all.map_or(0, |group| group.drives_with_episodes),
                largest_ratio: of_all.and_then(|group| group.largest_ratio).unwrap_or(0.0),
                monitored: fault_free.monitored_h / (fault_free.driven_h * (1.0 - out_for_v_x)),
            },
            design,
        })
    }

    /// The report of a campaign with the design in `designed` and these `arguments`.
    fn campaign(&self, designed: &Path, arguments: &[&str]) -> Result<Report, Box<dyn Error>> {
        let design = fs::canonicalize(designed.join("design.json"))?;
        let (design, drives, seed) =
            (design.display().to_string(), self.drives.to_string(), self.seed.to_string());
        let campaign = ["campaign", &design, "--allow", "uncertified,blind", "-o", "campaign"];
        let numbers = ["--drives", &drives, "--seed", &seed];
        let command = [&campaign[..], &numbers, arguments].concat();
        let folder = made_by(&command.join(" "), &[&self.steerguard], |folder| {
            self.json(folder, &command).map(|_| ())
        })?;
        Ok(serde_json::from_str(&fs::read_to_string(folder.join("campaign/report.json"))?)?)
    }

    /// What the command says, for machines; that the answer is no is an answer.
    fn json(&self, folder: &Path, arguments: &[&str]) -> Result<Value, Box<dyn Error>> {
        let output = self.run(folder, &[arguments, &["--json"]].concat())?;
        serde_json::from_slice(&output.stdout).map_err(|_| {
            let said = String::from_utf8_lossy(&output.stderr);
            format!("steerguard {}: {}: {said}", arguments.join(" "), output.status).into()
        })
    }

    fn run(&self, folder: &Path, arguments: &[&str]) -> std::io::Result<Output> {
        Command::new(&self.steerguard).current_dir(folder).args(arguments).output()
    }
}

impl Trial {
    /// The smallest steering fault of interest, deg.
    pub fn smallest_deg(&self) -> f64 {
        match self.spec.fault[0] {
            Fault::Steering { smallest_deg, .. } => smallest_deg,
            Fault::Torque { .. } => 0.0,
        }
    }

    /// The same with 3 F as the smallest fault, where that is missed and bank and wind hide it.
    fn seen_spec(&self) -> Option<Spec> {
        let made = self.made.as_ref().ok().filter(|made| made.is_blind())?;
        let told_deg = made.bank_and_wind_deg();
        let mut spec = self.spec.clone();
        let Fault::Steering { smallest_deg, .. } = &mut spec.fault[0] else { return None };
        if 2.0 * told_deg <= *smallest_deg {
            return None;
        }
        *smallest_deg = OF_BANK_AND_WIND * told_deg;
        Some(spec)
    }
}
