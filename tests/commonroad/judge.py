"""Drives the packaged FMU with recordings of CommonRoad's vehicles, and with sines in which the wheel slips.

    judge.py --steerguard COMMAND --recordings FOLDER [--cars 1 2 3] [--sines]

For each car three designs: as specified, with C_f -5 % and C_r +5 % in the specification, and the reverse. Fault-free
drives: alarms, share of the time monitored, largest J/J_th. Sines of 0.3 Hz at 8 to 28 m/s and 0.5 to 4 m/s^2: delay of
a bias of 1, 0.5 and 0.25 degrees, which comes at 6 s and stays for 4 s.

Conventions: noise 0.02 m/s and 0.002 rad/s, white, seed 1; delays are sample times.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq

sys.path.append(str(Path(__file__).parents[1] / "python"))
from fmu import Fmu  # noqa: E402
from record import CARS, PERIOD_S, drive  # noqa: E402

MONITORING = 2
MODELS = ["st", "std", "mb"]
NOISE = np.array([0.02, 0.002])
GRAVITY_M_PER_S2 = 9.81  # CommonRoad's
ONSET_S, END_S = 6.0, 10.0
# C_f, C_r of the specification over those of the car.
ERRORS = {"as specified": (1.0, 1.0), "C_f -5 %, C_r +5 %": (0.95, 1.05), "C_f +5 %, C_r -5 %": (1.05, 0.95)}
# Heights of the centre of gravity, m.
HEIGHTS_M = {1: 0.558, 2: 0.575, 3: 0.748}


def specification(car, front=1.0, rear=1.0):
    """The TOML text of a car: stiffness mu C_S F_z / 2 of a tyre at the static load."""
    p = CARS[car]()
    # mu C_S = -p_ky1 for one tyre of an axle that carries M g l / L.
    stiffness = -p.tire.p_ky1 * p.m * GRAVITY_M_PER_S2 / (p.a + p.b) / 2
    return f"""
[vehicle]
mass_kg = {p.m}
yaw_inertia_kg_m2 = {p.I_z}
effective_longitudinal_inertia_kg_m = {p.m}
front_axle_distance_m = {p.a}
rear_axle_distance_m = {p.b}
front_cornering_stiffness_n_per_rad = {front * stiffness * p.b}
rear_cornering_stiffness_n_per_rad = {rear * stiffness * p.a}
centre_of_gravity_height_m = {HEIGHTS_M[car]}
"""


def detector(steerguard, text, folder):
    """The packaged detector of a specification."""
    folder.mkdir()
    (folder / "car.toml").write_text(text, encoding="utf-8")
    for command in (["design", "car.toml", "-o", "design.json"], ["package", "design.json", "-o", "detector.fmu"]):
        subprocess.run([steerguard, *command], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return Fmu(folder / "detector.fmu", folder / "unzipped")


def watch(fmu, signals, seed=1):
    """Alarm, state and J/J_th over the samples of `signals`, n x 4: v_x, r, T_eng, delta without noise."""
    measured = signals[:, :2] + NOISE * np.random.default_rng(seed).standard_normal((len(signals), 2))
    inputs = dict(zip(["v_x", "r", "u.T_eng", "u.delta"], np.hstack([measured, signals[:, 2:]]).T.tolist(), strict=True))
    with fmu.instance() as instance:
        instance.initialise()
        return instance.record(inputs, ["alarm", "state", "J_ratio"], PERIOD_S)


class Sine:
    """A plan of a sine of 0.3 Hz at one speed and lateral acceleration."""

    def __init__(self, speed, lateral, wheelbase):
        t = np.arange(0, END_S, PERIOD_S)
        self.speed = np.full(len(t), speed)
        self.steering = lateral * wheelbase / speed**2 * np.sin(2 * np.pi * 0.3 * t) * np.clip(t, 0, 1)


def delay(fmu, model, parameters, plan, degrees):
    """From onset to alarm, s; None if missed; negative for a false alarm."""
    t = np.arange(len(plan.speed)) * PERIOD_S
    signals = drive(model, parameters, plan, np.radians(degrees) * (t >= ONSET_S))
    alarms = np.flatnonzero(watch(fmu, signals)["alarm"])
    return None if len(alarms) == 0 else t[alarms[0]] - ONSET_S


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steerguard", type=Path, required=True)
    parser.add_argument("--recordings", type=Path, required=True)
    parser.add_argument("--cars", type=int, nargs="+", default=[1, 2, 3], choices=CARS)
    parser.add_argument("--sines", action="store_true")
    a = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for car in a.cars:
            for error, factors in ERRORS.items():
                place = Path(folder) / f"{car}-{factors[0]}"
                fmu = detector(a.steerguard.resolve(), specification(car, *factors), place)
                for model in MODELS:
                    table = pq.read_table(a.recordings / f"car{car}_{model}.parquet")
                    signals = np.stack([column.to_numpy().astype(float) for column in table.columns], axis=1)
                    seen = watch(fmu, signals)
                    monitored = seen["state"] == MONITORING
                    episodes = np.count_nonzero(np.diff(seen["alarm"].astype(int), prepend=0) > 0)
                    print(f"car {car}, {error}, {model}: {len(signals) * PERIOD_S / 60:.1f} min, {episodes} alarms, "
                          f"monitored {100 * monitored.mean():.1f} %, "
                          f"largest J/J_th {seen['J_ratio'][monitored].max():.2f}", flush=True)  # fmt: skip
                if a.sines and factors == (1.0, 1.0):
                    judge_sines(fmu, car)


def judge_sines(fmu, car):
    """Prints the worst delay by size and lateral acceleration, over speeds, signs and models."""
    parameters = CARS[car]()
    for degrees in (1.0, 0.5, 0.25):
        for lateral in (0.5, 1.0, 2.0, 3.0, 4.0):
            delays = [
                delay(fmu, model, parameters, Sine(speed, lateral, parameters.a + parameters.b), sign * degrees)
                for speed in (8.0, 13.0, 18.0, 23.0, 28.0)
                for sign in (1, -1)
                for model in ("st", "std")
            ]
            missed = sum(x is None for x in delays)
            false = sum(x is not None and x < 0 for x in delays)
            found = [x for x in delays if x is not None and x >= 0]
            worst = f"{max(found):.2f} s" if found else "-"
            print(f"car {car}, {degrees} deg, {lateral} m/s^2: worst delay {worst}, missed {missed}, false {false}, "
                  f"of {len(delays)}", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
