"""Records drives as a logger would: CSV of speed, yaw rate, hand wheel and lateral acceleration, for `identify`.

    record.py FOLDER --car {table1,1,2,3} [--model {linear,st,mb}] [--seeds FIRST LAST]

FOLDER/CAR_MODEL_SEED.csv: 120 s: a standstill, turns at 5 to 8 m/s, a sweep from 0.1 to 2 Hz to 4 m/s^2, braking.
FOLDER/CAR.toml: mass and axle distances, which are told; FOLDER/CAR-truth.toml: the whole vehicle.

Conventions
- Models: single-track with linear tyres and load transfer of our own (linear, for Table 1's car); CommonRoad's
  single-track (st) and multi-body (mb).
- Noise 0.02 m/s, 0.002 rad/s, 0.05 m/s^2; ratio 16; the hand wheel stands at 3 degrees straight ahead; bias
  0.2 deg/s; the wheel follows 20 ms after what is recorded.
"""

import argparse
import math
from pathlib import Path

import numpy as np
from scipy.integrate import odeint
from vehiclemodels import (
    init_mb,
    parameters_vehicle1,
    parameters_vehicle2,
    parameters_vehicle3,
    vehicle_dynamics_mb,
    vehicle_dynamics_st,
)

PERIOD_S = 0.01
GRAVITY_M_PER_S2 = 9.81
RATIO, OFFSET_DEG, BIAS_DEG_PER_S, DELAY_S = 16.0, 3.0, 0.2, 0.02
ROLLING_M_PER_S = 1.0  # Below, vehicles roll where their wheels point to.
NOISE = {"speed": 0.02, "yaw_rate": 0.002, "lateral_acceleration": 0.05}
CARS = {
    "1": parameters_vehicle1.parameters_vehicle1,
    "2": parameters_vehicle2.parameters_vehicle2,
    "3": parameters_vehicle3.parameters_vehicle3,
}
HEIGHTS_M = {"1": 0.558, "2": 0.575, "3": 0.748}


def vehicle(car):
    """mass, I_z, l_f, l_r, C_f, C_r (of one tyre), h of a car, by the keys of a specification."""
    if car == "table1":
        numbers = 1476.0, 1810.0, 1.13, 1.49, 57000.0, 59000.0, 0.55
    else:
        p = CARS[car]()
        stiffness = -p.tire.p_ky1 * p.m * GRAVITY_M_PER_S2 / (p.a + p.b) / 2
        numbers = p.m, p.I_z, p.a, p.b, stiffness * p.b, stiffness * p.a, HEIGHTS_M[car]
    keys = ["mass_kg", "yaw_inertia_kg_m2", "front_axle_distance_m", "rear_axle_distance_m",
            "front_cornering_stiffness_n_per_rad", "rear_cornering_stiffness_n_per_rad",
            "centre_of_gravity_height_m"]  # fmt: skip
    return dict(zip(keys, numbers, strict=True))


def plan(seed, wheelbase):
    """Time, speed and road-wheel angle of a drive of 120 s."""
    draw = np.random.default_rng(seed)
    t = np.arange(0, 120, PERIOD_S)
    slow, fast = draw.uniform(5, 8), draw.uniform(15, 22)
    # Standstill to 10 s, slow to 45 s, faster by 65 s, the sweep to 105 s, braking to slow again.
    speed = np.interp(t, [0, 10, 15, 45, 62, 105, 113, 120], [0, 0, slow, slow, fast, fast, slow, slow])
    speed = np.convolve(np.pad(speed, 50, mode="edge"), np.ones(101) / 101, mode="valid")
    lateral = np.zeros(len(t))
    steering = np.zeros(len(t))
    # Slow turns: where the wheels point to.
    turns = np.clip((t - 15) / 1.5, 0, 1) * np.clip((46 - t) / 1.5, 0, 1)
    steering += np.radians(draw.uniform(4, 7)) * turns * np.sin(2 * np.pi * (t - 15) / draw.uniform(12, 18))
    sweep = (t >= 65) & (t < 105)
    tau = t[sweep] - 65
    frequency = draw.uniform(0.08, 0.15)
    rise = (draw.uniform(1.6, 2.2) / frequency) ** (1 / 40)
    phase = 2 * np.pi * frequency * (rise**tau - 1) / math.log(rise)
    lateral[sweep] = draw.uniform(3, 4) * np.sin(phase) * np.clip(tau / 2, 0, 1) * np.clip((40 - tau) / 1, 0, 1)
    braked = (t >= 107) & (t < 116)
    lateral[braked] = draw.uniform(1, 2) * np.sin(2 * np.pi * (t[braked] - 107) / 4.5)
    steering += lateral * (wheelbase / np.square(np.maximum(speed, 3.0)) + draw.uniform(0.0, 0.002))
    return t, speed, steering


def linear(v, t, speed, steering):
    """v_x, r, a_y of a single-track vehicle with linear tyres and load transfer; it rolls below 1 m/s."""
    m, i_z, l_f, l_r, c_f, c_r, h = v.values()
    acceleration = np.gradient(speed, PERIOD_S)
    out = np.zeros((len(t), 3))
    y, substeps = np.zeros(2), 4
    step = PERIOD_S / substeps

    def slope(y, v_x, delta, a_x):
        shift = a_x * h / GRAVITY_M_PER_S2
        front = 2 * c_f * (1 - shift / l_r) * (delta - (y[0] + l_f * y[1]) / v_x)
        rear = 2 * c_r * (1 + shift / l_f) * (l_r * y[1] - y[0]) / v_x
        return np.array([(front + rear) / m - v_x * y[1], (l_f * front - l_r * rear) / i_z])

    for k in range(len(t)):
        v_x = speed[k]
        if v_x < ROLLING_M_PER_S:
            y = np.array([v_x * steering[k] * l_r / (l_f + l_r), v_x * steering[k] / (l_f + l_r)])
            out[k] = v_x, y[1], v_x * y[1]
        else:
            out[k] = v_x, y[1], slope(y, v_x, steering[k], acceleration[k])[0] + v_x * y[1]
        if v_x >= ROLLING_M_PER_S and k + 1 < len(t):
            for j in range(substeps):
                part = (j + 0.5) / substeps
                now = (speed[k] + part * (speed[k + 1] - speed[k]), steering[k] + part * (steering[k + 1] - steering[k]))
                half = y + step / 2 * slope(y, *now, acceleration[k])
                y = y + step * slope(half, *now, acceleration[k])
    return out


def commonroad(model, car, t, speed, steering):
    """v_x, r, a_y of CommonRoad's vehicle; it rolls below 1 m/s."""
    p = CARS[car]()
    acceleration = np.gradient(speed, PERIOD_S)
    turning = np.gradient(steering, PERIOD_S)
    dynamics = {"st": vehicle_dynamics_st.vehicle_dynamics_st, "mb": vehicle_dynamics_mb.vehicle_dynamics_mb}[model]
    out = np.zeros((len(t), 3))
    x = None
    for k in range(len(t)):
        if speed[k] < ROLLING_M_PER_S:
            r = speed[k] * math.tan(steering[k]) / (p.a + p.b)
            out[k] = speed[k], r, speed[k] * r
            x = None
            continue
        if x is None:
            core = [0.0, 0.0, steering[k], speed[k], 0.0, out[k - 1, 1], 0.0]
            x = np.array(core if model == "st" else init_mb.init_mb(core, p), dtype=float)
        x[2] = steering[k]
        v_x = x[3] if model == "mb" else x[3] * math.cos(x[6])
        asked = acceleration[k] + (speed[k] - v_x)
        slopes = dynamics(x, [turning[k], asked], p)
        # In st the speed is along the path.
        v_y_slope = slopes[10] if model == "mb" else slopes[3] * math.sin(x[6]) + x[3] * math.cos(x[6]) * slopes[6]
        out[k] = v_x, x[5], v_y_slope + v_x * x[5]
        x = odeint(lambda x, _: dynamics(x, [turning[k], asked], p), x, [0.0, PERIOD_S], rtol=1e-7, atol=1e-8)[-1]
    return out


def record(path, car, model, seed):
    v = vehicle(car)
    t, speed, steering = plan(seed, v["front_axle_distance_m"] + v["rear_axle_distance_m"])
    motion = linear(v, t, speed, steering) if model == "linear" else commonroad(model, car, t, speed, steering)
    v_x, r, a_y = motion.T
    draw = np.random.default_rng([seed, 1])

    def noisy(values, name):
        return values + NOISE[name] * draw.standard_normal(len(values))

    # What is recorded is ahead of the wheel.
    recorded = np.interp(t + DELAY_S, t, steering)
    columns = {
        "time [s]": t,
        "v [m/s]": noisy(v_x, "speed"),
        "yaw_rate [deg/s]": np.degrees(noisy(r, "yaw_rate")) + BIAS_DEG_PER_S,
        "hand_wheel [deg]": RATIO * np.degrees(recorded) + OFFSET_DEG,
        "a_y [m/s^2]": noisy(a_y, "lateral_acceleration"),
    }
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns),
               comments="", fmt="%.6f")  # fmt: skip


def table(values):
    return "[vehicle]\n" + "".join(f"{key} = {value}\n" for key, value in values.items())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--car", choices=["table1", *CARS], required=True)
    parser.add_argument("--model", choices=["linear", "st", "mb"], default="linear")
    parser.add_argument("--seeds", type=int, nargs=2, default=[1, 1])
    a = parser.parse_args()
    a.folder.mkdir(parents=True, exist_ok=True)
    v = vehicle(a.car)
    told = {key: v[key] for key in ["mass_kg", "front_axle_distance_m", "rear_axle_distance_m"]}
    (a.folder / f"{a.car}.toml").write_text(table(told), encoding="utf-8")
    (a.folder / f"{a.car}-truth.toml").write_text(table(v), encoding="utf-8")
    for seed in range(a.seeds[0], a.seeds[1] + 1):
        path = a.folder / f"{a.car}_{a.model}_{seed}.csv"
        record(path, a.car, a.model, seed)
        print(path, flush=True)


if __name__ == "__main__":
    main()
