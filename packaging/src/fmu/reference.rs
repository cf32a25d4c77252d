//! Reference results inside the FMUs: inputs for an importer to apply, and the outputs it has to get.
//!
//! # Conventions
//! - `extra/<model>_in.csv` and `extra/<model>_ref.csv`, the names and form of the FMI cross-check:
//!   a column `time` in s, then one for each input, or output, under its name and in its unit.
//! - Row k is at the communication point `k T`. Inputs are those to set there, constant until the
//!   next; outputs are those found there, before the inputs are set. All parameters have their
//!   start values.
//! - What is driven is the scenario of the paper's Fig. 1, up to 10 s, with the fault from 5 s on.
//! - Computed with the models in this command, not with the libraries; only `+ - * /`, square roots
//!   and the sine of `libm`, so the bytes are the same on every machine.

use std::fmt::Write as _;

use steerguard_detector::{
    Actuator, Configuration, ConfigurationError, Detector, FaultEstimate, Input, Output, Vehicle,
    VehicleState,
};
use steerguard_model_description::structure::Structure;
use steerguard_world::{Excitation, STEP_S, State, Steering, TrueVehicle, World};

use crate::drive::scenario::Scenario;

/// Length of the run, s.
const DURATION_S: f64 = 10.0;

/// Times are compared to this fraction of a step.
const SLACK: f64 = 1e-6;

const PLANT_INPUTS: [&str; 5] =
    ["u.T_eng", "u.delta", "fault", "disturbance.side_force", "disturbance.yaw_moment"];
const PLANT_OUTPUTS: [&str; 6] = ["v_x", "r", "true.v_x", "true.v_y", "true.r", "true.delta"];
const DETECTOR_INPUTS: [&str; 4] = ["v_x", "r", "u.T_eng", "u.delta"];
const DETECTOR_OUTPUTS: [&str; 8] = [
    "residual.v_x",
    "residual.r",
    "J_rms",
    "J_th",
    "alarm",
    "state",
    "fault_estimate",
    "fault_estimate_bound",
];

/// The two files, by what follows the model's name in theirs.
pub type Files = [(&'static str, String); 2];

/// A table with the names of FMI 3.0, where variables are elements of arrays: `residual[1]`.
pub fn with_arrays<V: Structure>(table: &str) -> String {
    let (names, rows) = table.split_once('\n').unwrap_or((table, ""));
    let renamed = |name: &str| {
        V::ARRAYS
            .iter()
            .find_map(|array| {
                let row = |element: &V| V::TABLE.get(element.value_reference() as usize);
                let index = array
                    .elements
                    .iter()
                    .position(|element| row(element).is_some_and(|row| row.name == name))?;
                Some(format!("{}[{}]", array.name, index + 1))
            })
            .unwrap_or_else(|| name.to_owned())
    };
    let names: Vec<String> = names.split(',').map(renamed).collect();
    names.join(",") + "\n" + rows
}

/// Speed in the middle of the design range, m/s: where a run of the design starts by default.
pub fn speed_m_per_s(design: &Configuration) -> f64 {
    let range = design.model.range.v_x;
    0.5 * (range.min + range.max)
}

/// The files of `SteeringFaultDetector.fmu`.
///
/// # Errors
/// [`ConfigurationError`] if the detector cannot run on these numbers.
pub fn detector(design: &Configuration) -> Result<Files, ConfigurationError> {
    let scenario = Scenario::default();
    let speed = speed_m_per_s(design);
    let initial = VehicleState {
        v_x_m_per_s: speed,
        v_y_m_per_s: scenario.initial_lateral_speed_m_per_s,
        r_rad_per_s: scenario.initial_yaw_rate_rad_per_s,
    };
    let model = &design.model;
    let rows = drive(&model.vehicle, &design.actuator, initial, model.sampling_period_s, &scenario);

    let mut detector = Detector::new(design)?;
    let mut output = *detector.output();
    let (mut inputs, mut outputs) = (table(&DETECTOR_INPUTS), table(&DETECTOR_OUTPUTS));
    for Row { time_s, motion, next, .. } in rows {
        let [v_x, r] = motion.measured().vector();
        push(&mut inputs, time_s, &[v_x, r, next.drive_torque_n_m, next.steering_rad]);
        push(&mut outputs, time_s, &results(&output));
        let u = Input { t_eng_n_m: next.drive_torque_n_m, delta_rad: next.steering_rad };
        output = *detector.sample(motion.measured(), u);
    }
    Ok([("_in.csv", inputs), ("_ref.csv", outputs)])
}

/// The files of `VehiclePlant.fmu`, for communication steps of `step_s`.
pub fn plant(vehicle: &Vehicle, speed_m_per_s: f64, step_s: f64) -> Files {
    let (mut inputs, mut outputs) = (table(&PLANT_INPUTS), table(&PLANT_OUTPUTS));
    let initial = VehicleState { v_x_m_per_s: speed_m_per_s, ..VehicleState::default() };
    for row in drive(vehicle, &Actuator::NONE, initial, step_s, &Scenario::default()) {
        let Row { time_s, motion, angle_rad, last, next } = row;
        let [v_x, v_y, r] = motion.vector();
        let Inputs { drive_torque_n_m, steering_rad, fault_rad, side_force_n, yaw_moment_n_m } =
            next;
        push(
            &mut inputs,
            time_s,
            &[drive_torque_n_m, steering_rad, fault_rad, side_force_n, yaw_moment_n_m],
        );
        push(&mut outputs, time_s, &[v_x, r, v_x, v_y, r, angle_rad + last.fault_rad]);
    }
    [("_in.csv", inputs), ("_ref.csv", outputs)]
}

/// A communication point.
struct Row {
    time_s: f64,
    motion: VehicleState,
    /// Of the actuator.
    angle_rad: f64,
    /// What acted until this point.
    last: Inputs,
    /// What acts from it on.
    next: Inputs,
}

/// Inputs of the plant.
#[derive(Clone, Copy)]
struct Inputs {
    drive_torque_n_m: f64,
    steering_rad: f64,
    fault_rad: f64,
    side_force_n: f64,
    yaw_moment_n_m: f64,
}

impl Inputs {
    /// Those of `scenario` at `time_s` for `vehicle` with the initial speed `speed`.
    fn at(scenario: &Scenario, vehicle: &Vehicle, speed: f64, time_s: f64) -> Self {
        let side_force_n = vehicle.mass_kg * scenario.side_wind_m_per_s2.at(time_s, speed);
        Self {
            drive_torque_n_m: vehicle.cruise_torque(speed)
                + scenario.drive_torque_n_m.at(time_s, speed),
            steering_rad: scenario.steering_angle_rad.at(time_s, speed),
            fault_rad: scenario.steering_fault_rad(time_s, speed),
            side_force_n,
            yaw_moment_n_m: side_force_n * scenario.side_wind_lever_arm_m,
        }
    }

    fn excitation(&self, vehicle: &TrueVehicle) -> Excitation {
        Excitation {
            drive_torque_n_m: self.drive_torque_n_m,
            command_rad: self.steering_rad,
            fault_rad: self.fault_rad,
            push: vehicle.push(self.side_force_n, self.yaw_moment_n_m),
        }
    }
}

/// The reference vehicle from `initial` through the scenario.
fn drive(
    vehicle: &Vehicle,
    actuator: &Actuator,
    initial: VehicleState,
    step_s: f64,
    scenario: &Scenario,
) -> Vec<Row> {
    let v_x = initial.v_x_m_per_s;
    let world = World::of(TrueVehicle::linear(*vehicle), Steering::of(*actuator));
    let inputs = |time_s| Inputs::at(scenario, vehicle, v_x, time_s);
    let mut last = inputs(0.0);
    let mut state = State::new(&world, STEP_S, initial, last.steering_rad);
    let mut rows = Vec::new();
    let (mut k, mut internal_steps) = (0_u32, 0.0);
    while f64::from(k) * step_s <= DURATION_S + SLACK * step_s {
        let time_s = f64::from(k) * step_s;
        let next = inputs(time_s);
        let State { motion, steering } = &state;
        rows.push(Row { time_s, motion: *motion, angle_rad: steering.angle_rad, last, next });
        k += 1;
        let excitation = next.excitation(&world.vehicle);
        while internal_steps * STEP_S < f64::from(k) * step_s - SLACK * STEP_S {
            state.step(&world, &excitation, STEP_S);
            internal_steps += 1.0;
        }
        last = next;
    }
    rows
}

fn results(output: &Output) -> [f64; 8] {
    let Output { residual, j_rms, j_th, alarm, monitor, estimate, .. } = *output;
    let [v_x, r] = residual.vector();
    let state = f64::from(steerguard_fmu::state(monitor).value());
    let FaultEstimate { fault_rad, bound_rad, .. } = estimate.unwrap_or_default();
    [v_x, r, j_rms, j_th, f64::from(u8::from(alarm)), state, fault_rad, bound_rad]
}

/// The first line of a table.
fn table(names: &[&str]) -> String {
    format!("time,{}\n", names.join(","))
}

/// Adds a line: the shortest decimals that read back to the same numbers.
fn push(table: &mut String, time_s: f64, values: &[f64]) {
    let _infallible = write!(table, "{time_s:?}");
    for value in values {
        let _infallible = write!(table, ",{value:?}");
    }
    table.push('\n');
}

#[cfg(test)]
mod tests {
    use steerguard_model_description::detector::DetectorVariable;
    use steerguard_model_description::plant::PlantVariable;
    use steerguard_model_description::{Causality, Variable, VariableSet};

    use super::*;

    fn names(table: &[Variable], causality: Causality) -> Vec<&str> {
        table.iter().filter(|row| row.role.causality == causality).map(|row| row.name).collect()
    }

    #[test]
    fn columns_are_the_inputs_and_outputs_of_the_models() {
        let plant = PlantVariable::TABLE;
        assert_eq!(names(plant, Causality::Input), PLANT_INPUTS);
        assert_eq!(names(plant, Causality::Output), PLANT_OUTPUTS);
        let detector = DetectorVariable::TABLE;
        // All but the switch, which keeps its start value.
        let inputs = names(detector, Causality::Input);
        let (switch, signals) = inputs.split_last().unwrap();
        assert_eq!((signals, *switch), (DETECTOR_INPUTS.as_slice(), "enabled"));
        assert_eq!(names(detector, Causality::Output), DETECTOR_OUTPUTS);
    }

    #[test]
    fn elements_of_arrays_are_called_so_in_fmi_3() {
        let names = DETECTOR_OUTPUTS.join(",");
        let renamed = with_arrays::<DetectorVariable>(&format!("time,{names}\n0.0,1.0\n"));
        let (head, rows) = renamed.split_once('\n').unwrap();
        assert!(head.starts_with("time,residual[1],residual[2],J_rms,J_th,alarm,"), "{head}");
        assert_eq!(rows, "0.0,1.0\n");
    }

    #[test]
    fn there_is_a_row_for_each_communication_point() {
        for (step_s, rows) in [(0.01, 1001), (0.005, 2001), (0.02, 501), (0.03, 334)] {
            for (_, table) in plant(&Vehicle::PAPER, 15.0, step_s) {
                assert_eq!(table.lines().count(), 1 + rows, "{step_s}");
                assert!(!table.contains("NaN"));
            }
        }
    }
}
