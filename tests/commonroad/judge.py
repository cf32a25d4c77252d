"""Drives the packaged FMU with recordings of CommonRoad's vehicles: varied driving, and sines with a bias of the wheel.

    judge.py --steerguard COMMAND [--second-test] RECORDINGS

RECORDINGS is a folder that record.py has filled. For each car in it three designs: as specified, with C_f -5 % and C_r +5 % in
the specification, and the reverse. Varied driving: alarms, share of the time monitored, largest J/J_th. Sines: the worst
delay by size of the bias and lateral acceleration, over speeds, signs and models, and how many of them were missed.

Conventions: noise 0.02 m/s and 0.002 rad/s, white, seed 1; delays are sample times.
"""

import argparse
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq

sys.path.append(str(Path(__file__).parents[1] / "python"))
from fmu import Fmu

PERIOD_S = 0.01
MONITORING = 2
SIGNALS = ["v_x", "r", "u.T_eng", "u.delta"]
NOISE = {"v_x": 0.02, "r": 0.002}
SINE_S, ONSET_S = 10.0, 6.0
# C_f, C_r of the specification over those of the car.
ERRORS = {"as specified": (1.0, 1.0), "C_f -5 %, C_r +5 %": (0.95, 1.05), "C_f +5 %, C_r -5 %": (1.05, 0.95)}


def detector(steerguard, specification, folder, front=1.0, rear=1.0, second_test=False):
    """The packaged detector of a car whose specification is wrong by factors in C_f and C_r."""
    vehicle = tomllib.loads(specification.read_text(encoding="utf-8"))["vehicle"]
    vehicle["front_cornering_stiffness_n_per_rad"] *= front
    vehicle["rear_cornering_stiffness_n_per_rad"] *= rear
    text = "".join(f"vehicle.{key} = {value}\n" for key, value in vehicle.items())
    if second_test:
        text += "estimator.enabled = true\n"
    folder.mkdir()
    (folder / "car.toml").write_text(text, encoding="utf-8")
    for command in (["design", "car.toml", "-o", "design.json"], ["package", "design.json", "-o", "detector.fmu"]):
        subprocess.run([steerguard, *command], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return Fmu(folder / "detector.fmu", folder / "unzipped")


def read(path):
    """Columns of a recording, by name."""
    table = pq.read_table(path)
    return {name: table[name].to_numpy().astype(float) for name in table.column_names}


def watch(fmu, columns, seed=1):
    """Alarm, state and J/J_th in every sample of a drive, to which noise is added."""
    draw = np.random.default_rng(seed)
    inputs = {name: columns[name] + NOISE.get(name, 0.0) * draw.standard_normal(len(columns[name])) for name in SIGNALS}
    with fmu.instance() as instance:
        instance.initialise()
        return instance.record(
            {n: values.tolist() for n, values in inputs.items()}, ["alarm", "state", "J_ratio"], PERIOD_S
        )


def episodes(alarm):
    return np.count_nonzero(np.diff(alarm.astype(int), prepend=0) > 0)


def sines(columns):
    """The drives of a recording of sines, one after the other: columns of each."""
    samples = round(SINE_S / PERIOD_S)
    for start in range(0, len(columns["v_x"]), samples):
        yield {name: values[start : start + samples] for name, values in columns.items()}


def delay(fmu, columns):
    """From onset to alarm in a sine, s; None if missed; negative for a false alarm."""
    alarms = np.flatnonzero(watch(fmu, columns)["alarm"])
    return None if len(alarms) == 0 else (alarms[0] - round(ONSET_S / PERIOD_S)) * PERIOD_S


def judge_drive(fmu, path, title):
    """Prints what the detector makes of varied driving."""
    seen = watch(fmu, read(path))
    monitored = seen["state"] == MONITORING
    print(f"{title}: {len(monitored) * PERIOD_S / 60:.1f} min, {episodes(seen['alarm'])} alarms, "
          f"monitored {100 * monitored.mean():.1f} %, largest J/J_th {seen['J_ratio'][monitored].max():.2f}",
          flush=True)  # fmt: skip


def judge_sines(fmu, paths, title):
    """Prints the worst delay by size and lateral acceleration."""
    delays = {}
    for path in paths:
        for sine in sines(read(path)):
            kind = abs(sine["degrees"][0]), sine["lateral"][0]
            delays.setdefault(kind, []).append(delay(fmu, sine))
    for (degrees, lateral), seen in sorted(delays.items(), key=lambda item: (-item[0][0], item[0][1])):
        found = [x for x in seen if x is not None and x >= 0]
        missed, false = seen.count(None), len(seen) - seen.count(None) - len(found)
        worst = f"{max(found):.2f} s" if found else "-"
        print(f"{title}: {degrees} deg, {lateral:.1f} m/s^2: worst delay {worst}, missed {missed}, false {false}, "
              f"of {len(seen)}", flush=True)  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steerguard", type=Path, required=True)
    parser.add_argument("--second-test", action="store_true", help="designs with the second test")
    parser.add_argument("recordings", type=Path)
    a = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for specification in sorted(a.recordings.glob("car*.toml")):
            car = specification.stem
            paths = sorted(a.recordings.glob(f"{car}_*.parquet"))
            of_sines = [path for path in paths if path.stem.endswith("sines")]
            for error, factors in ERRORS.items():
                place = Path(folder) / f"{car}-{factors[0]}"
                fmu = detector(a.steerguard.resolve(), specification, place, *factors, a.second_test)
                for path in paths:
                    if path not in of_sines:
                        judge_drive(fmu, path, f"{path.stem}, {error}")
                judge_sines(fmu, of_sines, f"{car}, {error}")


if __name__ == "__main__":
    main()
