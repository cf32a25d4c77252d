//! The cars: those of `tests/fleet/cars.toml` as they stand, their neutral-steer variants, and those drawn
//! from a grid of stiffnesses around some of them.

use std::error::Error;
use std::fs;
use std::path::Path;

use serde::Deserialize;
use steerguard_designer::Spec;
use steerguard_designer::document::Mistakes;
use steerguard_world::Stream;

/// A car of the file; stiffnesses are those of a tyre.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Car {
    /// What it is called.
    pub name: String,
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

    /// Its specification as one writes it, with default keys, but for a period where the default one is
    /// refused: then that which the refusal names.
    ///
    /// # Errors
    /// Where it is refused for anything else.
    pub fn spec(&self) -> Result<Spec, Box<dyn Error>> {
        let [min, max] = self.v_x_m_per_s;
        let vehicle: Spec = toml::from_str(&self.vehicle())?;
        let slowest = vehicle.lowest_critical_speed().unwrap_or(f64::INFINITY);
        let text = format!(
            "{}[operating_range]\nv_x_m_per_s = [{min:?}, {:?}]\n[actuator]\ndelay_s = {:?}\n",
            self.vehicle(),
            max.min(OF_CRITICAL_SPEED * slowest),
            self.actuator_delay_s
        );
        Ok(Spec::from_toml(&text).or_else(|refused| {
            let period_s = period_named(&refused).ok_or(refused)?;
            Spec::from_toml(&format!("{text}[sampling]\nperiod_s = {period_s:?}\n"))
        })?)
    }

    /// Its table `[vehicle]`.
    fn vehicle(&self) -> String {
        let numbers = [
            ("mass_kg", self.mass_kg),
            ("yaw_inertia_kg_m2", self.yaw_inertia_kg_m2),
            ("effective_longitudinal_inertia_kg_m", self.effective_longitudinal_inertia_kg_m),
            ("front_axle_distance_m", self.front_axle_distance_m),
            ("rear_axle_distance_m", self.rear_axle_distance_m),
            ("front_cornering_stiffness_n_per_rad", self.front_cornering_stiffness_n_per_rad),
            ("rear_cornering_stiffness_n_per_rad", self.rear_cornering_stiffness_n_per_rad),
        ];
        let lines = numbers.map(|(key, value)| format!("{key} = {value:?}\n"));
        format!("[vehicle]\n{}", lines.concat())
    }
}

/// The period that a refusal names, if it is one of the period.
fn period_named(mistakes: &Mistakes) -> Option<f64> {
    let text = mistakes.to_string();
    let (_, after) = text.split_once("set the period below ")?;
    after.split(' ').next()?.parse().ok()
}

/// The fleet; with those drawn if `all`.
///
/// # Errors
/// Where the file of the cars cannot be read.
pub fn fleet(all: bool) -> Result<Vec<Car>, Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fleet/cars.toml");
    let cars = toml::from_str::<Cars>(&fs::read_to_string(path)?)?.car;
    let mut fleet = cars.clone();
    fleet.extend(cars.iter().filter(|car| car.neutral).map(Car::neutral));
    if all {
        fleet.extend(drawn(&cars));
    }
    Ok(fleet)
}

/// Those drawn from the grid, without repetition.
fn drawn(cars: &[Car]) -> Vec<Car> {
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
        let drawn = number + (stream.unit(number as u64) * (grid.len() - number) as f64) as usize;
        grid.swap(number, drawn);
    }
    grid.truncate(DRAWN);
    grid
}
