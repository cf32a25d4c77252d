//! Designs the fleet of `tests/fleet/cars.toml` with default keys, a table of what came out:
//!
//! ```text
//! tests/fleet/run [--all] [NAME...]
//! ```
//!
//! The cars as they stand and their neutral-steer variants; `--all` adds those drawn from a grid of
//! stiffnesses. With names, those alone whose names hold one of them. What is designed is kept until
//! the specification or the program changes: a run that was ended goes on where it was.

use std::error::Error;
use std::fmt;
use std::fs;
use std::path::Path;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use steerguard_designer::document::Mistakes;
use steerguard_designer::problem::inputs::Inputs;
use steerguard_designer::{Design, Spec, design};
use steerguard_test_support::once::made_once;
use steerguard_world::Stream;

/// A car of the file; stiffnesses are those of a tyre.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Car {
    name: String,
    mass_kg: f64,
    yaw_inertia_kg_m2: f64,
    effective_longitudinal_inertia_kg_m: f64,
    front_axle_distance_m: f64,
    rear_axle_distance_m: f64,
    front_cornering_stiffness_n_per_rad: f64,
    rear_cornering_stiffness_n_per_rad: f64,
    v_x_m_per_s: [f64; 2],
    #[serde(default)]
    actuator_delay_s: f64,
    /// Whether there is a neutral variant.
    #[serde(default)]
    neutral: bool,
    /// Whether cars are drawn around it.
    #[serde(default)]
    drawn: Option<Drawn>,
}

/// What is drawn around.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
enum Drawn {
    #[serde(rename = "neutral")]
    Neutral,
    #[serde(rename = "as it is")]
    AsItIs,
}

#[derive(Deserialize)]
struct Cars {
    car: Vec<Car>,
}

/// Factors of the stiffnesses that cars are drawn from.
const FACTORS: [f64; 5] = [0.8, 0.9, 1.0, 1.1, 1.2];
/// Cars drawn.
const DRAWN: usize = 80;
/// Seed of the drawing.
const SEED: u64 = 1;
/// Share of the lowest critical speed that a range of speeds may reach.
const OF_CRITICAL_SPEED: f64 = 0.8;

impl Car {
    /// The same with l_r C_r = l_f C_f.
    fn neutral(&self) -> Self {
        let product =
            self.front_cornering_stiffness_n_per_rad * self.rear_cornering_stiffness_n_per_rad;
        let ratio = self.rear_axle_distance_m / self.front_axle_distance_m;
        Self {
            name: format!("{}, neutral", self.name),
            front_cornering_stiffness_n_per_rad: (product * ratio).sqrt(),
            rear_cornering_stiffness_n_per_rad: (product / ratio).sqrt(),
            ..self.clone()
        }
    }

    /// The same with other tyres.
    fn with_stiffnesses(&self, [front, rear]: [f64; 2]) -> Self {
        Self {
            name: format!("{}, C_f x {front}, C_r x {rear}", self.name),
            front_cornering_stiffness_n_per_rad: self.front_cornering_stiffness_n_per_rad * front,
            rear_cornering_stiffness_n_per_rad: self.rear_cornering_stiffness_n_per_rad * rear,
            ..self.clone()
        }
    }

    /// Its specification, with default keys.
    fn spec(&self) -> Spec {
        let mut spec = Spec::default();
        spec.vehicle.mass_kg = self.mass_kg;
        spec.vehicle.yaw_inertia_kg_m2 = self.yaw_inertia_kg_m2;
        spec.vehicle.effective_longitudinal_inertia_kg_m = self.effective_longitudinal_inertia_kg_m;
        spec.vehicle.front_axle_distance_m = self.front_axle_distance_m;
        spec.vehicle.rear_axle_distance_m = self.rear_axle_distance_m;
        spec.vehicle.front_cornering_stiffness_n_per_rad = self.front_cornering_stiffness_n_per_rad;
        spec.vehicle.rear_cornering_stiffness_n_per_rad = self.rear_cornering_stiffness_n_per_rad;
        let [min, max] = self.v_x_m_per_s;
        let slowest = self.lowest_critical_speed(&spec).unwrap_or(f64::INFINITY);
        spec.operating_range.v_x_m_per_s = [min, max.min(OF_CRITICAL_SPEED * slowest)];
        spec.actuator.delay_s = self.actuator_delay_s;
        spec
    }

    /// The lowest critical speed of a vehicle inside the uncertainties, m/s; none where all of them
    /// understeer. Mass and front stiffness lower it, rear stiffness raises it.
    fn lowest_critical_speed(&self, spec: &Spec) -> Option<f64> {
        let worst = |value: f64, percent: f64| value * (1.0 + percent / 100.0);
        let u = &spec.uncertainty;
        let mass = worst(self.mass_kg, u.mass_percent[1]);
        let c_f =
            worst(self.front_cornering_stiffness_n_per_rad, u.front_cornering_stiffness_percent[1]);
        let c_r =
            worst(self.rear_cornering_stiffness_n_per_rad, u.rear_cornering_stiffness_percent[0]);
        let (l_f, l_r) = (self.front_axle_distance_m, self.rear_axle_distance_m);
        let oversteer = c_f * l_f - c_r * l_r;
        let squared = 2.0 * c_f * c_r * (l_f + l_r) * (l_f + l_r) / (mass * oversteer);
        (oversteer > 0.0).then(|| squared.sqrt())
    }
}

/// The fleet; with those drawn if `all`.
fn fleet(cars: &[Car], all: bool) -> Vec<Car> {
    let mut fleet = cars.to_vec();
    fleet.extend(cars.iter().filter(|car| car.neutral).map(Car::neutral));
    if all {
        let around: Vec<Car> = cars
            .iter()
            .filter_map(|car| match car.drawn? {
                Drawn::Neutral => Some(car.neutral()),
                Drawn::AsItIs => Some(car.clone()),
            })
            .collect();
        let mut grid: Vec<Car> = around
            .iter()
            .flat_map(|car| FACTORS.map(|front| FACTORS.map(|rear| (car, [front, rear]))))
            .flatten()
            .map(|(car, factors)| car.with_stiffnesses(factors))
            .collect();
        let stream = Stream::new(SEED, 0);
        for number in 0..DRAWN.min(grid.len()) {
            let drawn =
                number + (stream.unit(number as u64) * (grid.len() - number) as f64) as usize;
            grid.swap(number, drawn);
        }
        grid.truncate(DRAWN);
        fleet.extend(grid);
    }
    fleet
}

/// What came of a car.
#[derive(Debug, Serialize, Deserialize)]
struct Outcome {
    car: String,
    /// The design's, or why there is none.
    status: String,
    period_s: f64,
    v_x_max_m_per_s: f64,
    seconds: f64,
    figures: Option<Figures>,
}

/// What a design is worth.
#[derive(Debug, Serialize, Deserialize)]
struct Figures {
    decay: f64,
    detection_ratio: f64,
    certified_ratio: f64,
    certified_gap: f64,
    e_2_m_per_s_per_deg: f64,
    leaves_range_from_deg: f64,
}

impl Outcome {
    const HEAD: &str = "| car | period s | v_x to | decay | ratio | certified | gap | e_2 m/s per deg \
                        | leaves S_x from deg | s | status |\n\
                        |---|---|---|---|---|---|---|---|---|---|---|";
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { car, status, period_s, v_x_max_m_per_s, seconds, figures } = self;
        write!(f, "| {car} | {period_s} | {v_x_max_m_per_s:.1} | ")?;
        match figures {
            Some(x) => write!(
                f,
                "{:.4} | {:.2} | {:.2} | {:.2} | {:.3} | {:.1}",
                x.decay,
                x.detection_ratio,
                x.certified_ratio,
                x.certified_gap,
                x.e_2_m_per_s_per_deg,
                x.leaves_range_from_deg,
            ),
            None => write!(f, "| | | | |"),
        }?;
        write!(f, " | {seconds:.1} | {status} |")
    }
}

/// The period that the refusal of `spec` names, if it is one of its period.
fn period_named(mistakes: &Mistakes) -> Option<f64> {
    let text = mistakes.to_string();
    let (_, after) = text.split_once("set the period below ")?;
    after.split(' ').next()?.parse().ok()
}

/// `spec`, where its period is refused with the one that the refusal names.
fn possible(mut spec: Spec) -> Spec {
    if let Some(period_s) = spec.check().err().as_ref().and_then(period_named) {
        spec.sampling.period_s = period_s;
    }
    spec
}

fn outcome(car: &Car) -> Outcome {
    let spec = possible(car.spec());
    let start = Instant::now();
    let made = design(&spec, &mut |_| {});
    let seconds = start.elapsed().as_secs_f64();
    let (status, figures) = match made.and_then(|design| Ok((Inputs::of(&spec)?, design))) {
        Ok((inputs, design)) => (
            format!(
                "{:?}{}",
                design.synthesis.status,
                design.synthesis.unproven.as_ref().map_or(String::new(), |x| format!(": {x}"))
            ),
            Some(Figures::of(&design, &inputs)),
        ),
        Err(error) => (error.to_string(), None),
    };
    Outcome {
        car: car.name.clone(),
        status,
        period_s: spec.sampling.period_s,
        v_x_max_m_per_s: spec.operating_range.v_x_m_per_s[1],
        seconds,
        figures,
    }
}

impl Figures {
    fn of(design: &Design, inputs: &Inputs) -> Self {
        let performance = &design.performance;
        let (certified, estimate) = (performance.certified, performance.estimate);
        let ratio = |beta: f64, gamma: f64| {
            beta * inputs.smallest_fault / (gamma * inputs.bound).hypot(performance.noise_rms)
        };
        Self {
            decay: performance.decay,
            detection_ratio: performance.detection_ratio,
            certified_ratio: certified.map_or(0.0, |x| ratio(x.beta, x.gamma)),
            certified_gap: certified.map_or(0.0, |x| x.gap),
            e_2_m_per_s_per_deg: estimate.map_or(0.0, |x| x.peak_m_per_s_per_deg),
            leaves_range_from_deg: estimate.map_or(0.0, |x| x.leaves_range_from_deg),
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (options, names): (Vec<String>, Vec<String>) =
        arguments.into_iter().partition(|argument| argument.starts_with("--"));
    let all = options.iter().any(|option| option == "--all");
    if let Some(option) = options.iter().find(|option| *option != "--all") {
        return Err(format!("{option}: not an option; tests/fleet/run [--all] [NAME...]").into());
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fleet/cars.toml");
    let cars: Cars = toml::from_str(&fs::read_to_string(path)?)?;
    let fleet = fleet(&cars.car, all);
    let chosen = fleet.iter().filter(|car| {
        names.is_empty() || names.iter().any(|name| car.name.contains(name.as_str()))
    });

    println!("{}", Outcome::HEAD);
    let mut outcomes = Vec::new();
    for car in chosen {
        let key = format!("{} {}", car.name, serde_json::to_string(&car.spec())?);
        let folder = made_once::<Box<dyn Error>>(&key, &[], |folder| {
            let outcome = serde_json::to_string(&outcome(car))?;
            Ok(fs::write(folder.join("outcome.json"), outcome)?)
        })?;
        let outcome: Outcome =
            serde_json::from_str(&fs::read_to_string(folder.join("outcome.json"))?)?;
        println!("{outcome}");
        outcomes.push(outcome);
    }
    Ok(())
}
