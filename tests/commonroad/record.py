"""Records drives of CommonRoad's vehicles, which nobody here has written.

    record.py FOLDER [--minutes M] [--seed S] [--cars 1 2 3] [--models st std mb]
                     [--degrees D...] [--speeds V...] [--laterals A...]

Parquet files for each car and model: speed v_x, yaw rate r, drive torque u.T_eng and road-wheel angle u.delta every
10 ms, without sensor noise. Models: single-track with linear tyres and load transfer (st), with tyres that saturate and
wheels that slip (std), and 29 states of a multi-body (mb).

- carC.toml: the car as steerguard's specification.
- carC_MODEL.parquet: M minutes of varied driving without a fault, with braking in turns.
- carC_MODEL_sines.parquet: sines of 0.3 Hz, 10 s each, one after the other: at every speed and lateral acceleration a
  bias of either sign of every size from 6 s on. The columns `degrees` (actual less commanded angle), `speed` and
  `lateral` say which.

Conventions
- Steering and speed are planned open loop; the speed alone is controlled. The lateral acceleration is that of the
  neutral car, v^2 delta / L, which all three are.
- Drive torque is that of the specification's vehicle, whose I_e is the mass: the wheels' radius is 1 m there.
"""

import argparse
import itertools
import math
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from scipy.integrate import odeint
from vehiclemodels import (
    init_mb,
    init_std,
    parameters_vehicle1,
    parameters_vehicle2,
    parameters_vehicle3,
    vehicle_dynamics_mb,
    vehicle_dynamics_st,
    vehicle_dynamics_std,
)

PERIOD_S = 0.01
DRAG_N_M_S2_PER_M2 = 0.35  # C_x of the specification
CARS = {
    1: parameters_vehicle1.parameters_vehicle1,
    2: parameters_vehicle2.parameters_vehicle2,
    3: parameters_vehicle3.parameters_vehicle3,
}


MODELS = ["st", "std", "mb"]
GRAVITY_M_PER_S2 = 9.81  # CommonRoad's
HEIGHTS_M = {1: 0.558, 2: 0.575, 3: 0.748}  # of the centre of gravity
SIGNALS = ["v_x", "r", "u.T_eng", "u.delta"]
SINE_S, ONSET_S = 10.0, 6.0


class Sine:
    """Speed and steering of a sine of 0.3 Hz, which grows within the first second."""

    def __init__(self, speed, lateral, wheelbase):
        t = np.arange(0, SINE_S, PERIOD_S)
        self.speed = np.full(len(t), speed)
        self.steering = lateral * wheelbase / speed**2 * np.sin(2 * np.pi * 0.3 * t) * np.clip(t, 0, 1)


class Plan:
    """Speed and steering of a drive: segments of 6 to 12 s, each of one manoeuvre and one acceleration."""

    SPEEDS_M_PER_S = (7.0, 27.0)
    LATERAL_M_PER_S2 = (0.5, 3.0)
    BRAKING_M_PER_S2 = 2.5
    ACCELERATION_M_PER_S2 = 1.5

    def __init__(self, minutes, wheelbase, seed):
        draw = np.random.default_rng(seed)
        samples = int(minutes * 60 / PERIOD_S)
        self.speed = np.empty(samples)
        lateral = np.empty(samples)
        speed, k = 15.0, 0
        while k < samples:
            n = min(int(draw.uniform(6, 12) / PERIOD_S), samples - k)
            t = np.arange(n) * PERIOD_S
            target = draw.uniform(*self.SPEEDS_M_PER_S)
            slope = -draw.uniform(0.5, self.BRAKING_M_PER_S2)
            if target > speed:
                slope = draw.uniform(0.3, self.ACCELERATION_M_PER_S2)
            change = slope * np.clip(t - 1.5, 0, None)
            bound = target - speed
            change = np.minimum(change, bound) if bound > 0 else np.maximum(change, bound)
            self.speed[k : k + n] = speed + change
            speed = self.speed[k + n - 1]

            size = draw.uniform(*self.LATERAL_M_PER_S2) * draw.choice([-1, 1])
            kind = draw.integers(4)
            if kind == 0:  # a turn, entered and left within a second
                shape = np.clip(np.minimum(t, t[-1] - t), 0, 1)
            elif kind == 1:  # a weave that ends where it began
                periods = max(1, round(draw.uniform(0.1, 0.5) * t[-1]))
                shape = np.sin(2 * np.pi * periods * t / max(t[-1], PERIOD_S))
            elif kind == 2:  # a lane change
                shape = np.where(t < 3, np.sin(2 * np.pi * t / 3), 0)
            else:
                shape = np.zeros(n)
            lateral[k : k + n] = size * shape
            k += n
        # Rates of a driver: a filter of a tenth of a second.
        smooth = np.ones(10) / 10
        lateral = np.convolve(lateral, smooth, mode="same")
        self.speed = np.convolve(np.pad(self.speed, 20, mode="edge"), np.ones(41) / 41, mode="valid")
        self.steering = lateral * wheelbase / np.square(self.speed)


def drive(model, parameters, plan, fault_rad=None):
    """v_x, r and the applied (T_eng, delta), each n; `fault_rad` is added to the wheel's angle, n."""
    p = parameters
    core = [0.0, 0.0, 0.0, plan.speed[0], 0.0, 0.0, 0.0]
    start, dynamics = {
        "st": (core, vehicle_dynamics_st.vehicle_dynamics_st),
        "std": (init_std.init_std(core, p), vehicle_dynamics_std.vehicle_dynamics_std),
        "mb": (init_mb.init_mb(core, p), vehicle_dynamics_mb.vehicle_dynamics_mb),
    }[model]
    x = np.array(start)
    n = len(plan.speed)
    fault = np.zeros(n) if fault_rad is None else fault_rad
    slope = np.gradient(plan.speed, PERIOD_S)
    out = np.empty((n, 4))
    for k in range(n):
        slip = 0.0 if model == "mb" else x[6]
        v_x = x[3] * math.cos(slip)
        acceleration = slope[k] + (plan.speed[k] - v_x)
        torque = p.m * acceleration + DRAG_N_M_S2_PER_M2 * v_x**2
        out[k] = v_x, x[5], torque, plan.steering[k]
        # The wheel stands where it is told to within the sample, and is held.
        x[2] = plan.steering[k] + fault[k]
        x = odeint(lambda x, _: dynamics(x, [0.0, acceleration], p), x, [0.0, PERIOD_S], rtol=1e-7, atol=1e-8)[-1]
    return out


def specification(car):
    """The TOML text of a car: C = mu C_S F_z / 2 of a tyre at the static load, F_z = M g l / L of the other axle's l."""
    p = CARS[car]()
    stiffness = -p.tire.p_ky1 * p.m * GRAVITY_M_PER_S2 / (p.a + p.b) / 2  # mu C_S = -p_ky1
    return f"""[vehicle]
mass_kg = {p.m}
yaw_inertia_kg_m2 = {p.I_z}
effective_longitudinal_inertia_kg_m = {p.m}
front_axle_distance_m = {p.a}
rear_axle_distance_m = {p.b}
front_cornering_stiffness_n_per_rad = {stiffness * p.b}
rear_cornering_stiffness_n_per_rad = {stiffness * p.a}
centre_of_gravity_height_m = {HEIGHTS_M[car]}
"""


def write(path, columns):
    """Single precision is a thousandth of the sensors' noise."""
    table = pa.table({name: np.asarray(column, dtype=np.float32) for name, column in columns.items()})
    pq.write_table(table, path, compression="zstd", use_dictionary=["degrees", "speed", "lateral"])
    print(path, flush=True)


def record(car, model, minutes, seed, path):
    """Varied driving without a fault."""
    parameters = CARS[car]()
    plan = Plan(minutes, parameters.a + parameters.b, [seed, car, MODELS.index(model)])
    write(path, dict(zip(SIGNALS, drive(model, parameters, plan).T, strict=True)))


def record_sines(car, model, sizes, speeds, laterals, path):
    """Sines at every speed and lateral acceleration, with a bias of every size and sign."""
    parameters = CARS[car]()
    rows = []
    for degrees, lateral, speed, sign in itertools.product(sizes, laterals, speeds, (1, -1)):
        plan = Sine(speed, lateral, parameters.a + parameters.b)
        fault = np.zeros(len(plan.speed))
        fault[round(ONSET_S / PERIOD_S) :] = np.radians(sign * degrees)
        labels = np.full((len(fault), 3), [sign * degrees, speed, lateral])
        rows.append(np.hstack([drive(model, parameters, plan, fault), labels]))
    write(path, dict(zip([*SIGNALS, "degrees", "speed", "lateral"], np.vstack(rows).T, strict=True)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--minutes", type=float, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cars", type=int, nargs="+", default=[1, 2, 3], choices=CARS)
    parser.add_argument("--models", nargs="+", default=MODELS, choices=MODELS)
    parser.add_argument("--degrees", type=float, nargs="+", default=[1, 0.5, 0.25])
    parser.add_argument("--speeds", type=float, nargs="+", default=[8, 13, 18, 23, 28], help="m/s")
    parser.add_argument("--laterals", type=float, nargs="+", default=[0.5, 1, 2, 3, 4], help="m/s^2")
    a = parser.parse_args()
    a.folder.mkdir(parents=True, exist_ok=True)
    for car in a.cars:
        (a.folder / f"car{car}.toml").write_text(specification(car), encoding="utf-8")
        for model in a.models:
            if a.minutes > 0:
                record(car, model, a.minutes, a.seed, a.folder / f"car{car}_{model}.parquet")
            sines = a.folder / f"car{car}_{model}_sines.parquet"
            record_sines(car, model, a.degrees, a.speeds, a.laterals, sines)


if __name__ == "__main__":
    main()
