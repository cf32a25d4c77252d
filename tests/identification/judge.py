"""What `identify` makes of recorded drives whose truth is known.

    judge.py --steerguard COMMAND FOLDER

FOLDER is one that record.py has filled. For each car and model: how many drives were identified and which parameters
were refused; for each parameter the largest error, in how many drives it is within its limit, how often the truth lay
within two standard errors and within the interval that is written, and the median standard error; for all of them
together how many drives are within every limit, and how often the truth lay within two standard errors.
"""

import argparse
import json
import subprocess
import tempfile
import tomllib
from collections import Counter, defaultdict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

# Of record.py.
RATIO, OFFSET_DEG, BIAS_DEG_PER_S, DELAY_S = 16.0, 3.0, 0.2, 0.02


def truth(vehicle):
    """By name of a parameter, in SI."""
    return {
        "steering ratio": RATIO,
        "steering offset": np.radians(OFFSET_DEG) / RATIO,
        "yaw-rate bias": np.radians(BIAS_DEG_PER_S),
        "front cornering stiffness": vehicle["front_cornering_stiffness_n_per_rad"],
        "rear cornering stiffness": vehicle["rear_cornering_stiffness_n_per_rad"],
        "yaw inertia": vehicle["yaw_inertia_kg_m2"],
        "height of the centre of gravity": vehicle["centre_of_gravity_height_m"],
    }


# What a drive of a car with linear tyres is to show, as relative errors or in SI.
LIMITS = {
    "steering ratio": 0.01,
    "steering offset": np.radians(0.05),
    "yaw-rate bias": np.radians(0.05),
    "delay and lag together": 0.01,
    "front cornering stiffness": 0.05,
    "rear cornering stiffness": 0.05,
}
RELATIVE = {"steering ratio", "front cornering stiffness", "rear cornering stiffness", "yaw inertia"}
DEGREES = {"steering offset", "yaw-rate bias"}


def identified(steerguard, drive, told):
    """The report of a drive, and what was said of one that is refused."""
    with tempfile.TemporaryDirectory() as folder:
        command = [steerguard, "identify", drive, "--known", told, "-o", Path(folder) / "car.toml", "--json"]
        run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode == 0:
        return json.loads(run.stdout), []
    return None, [of["message"] for of in json.loads(run.stderr)["diagnostics"]]


def judge(steerguard, name, drives, told, vehicle):
    with ThreadPoolExecutor(1) as pool:
        results = list(pool.map(lambda drive: identified(steerguard, drive, told), drives))
    reports = [report for report, _ in results if report]
    refused = Counter(message.split(":")[0] for _, messages in results for message in messages)
    used = sum(report["lateral_acceleration"] == "used" for report in reports)
    print(f"{name}: {len(reports)} of {len(drives)} identified, lateral acceleration used in {used}", flush=True)
    for message, count in refused.items():
        print(f"  {count} times: {message}")
    rows = defaultdict(list)
    expected = truth(vehicle)
    for report in reports:
        by_name = {row["name"]: row for row in report["parameters"]}
        sum_s = by_name["delay"]["value"] + by_name["actuator lag"]["value"]
        rows["delay and lag together"].append((abs(sum_s - DELAY_S), np.nan, np.nan, np.nan))
        for parameter, value in expected.items():
            row = by_name[parameter]
            error = abs(row["value"] - value) / (row["value"] if parameter in RELATIVE else 1)
            if row["origin"] == "fitted":
                rows[parameter].append((error, row["standard_error"], error <= 2 * row["standard_error"],
                                        error <= row["interval"]))  # fmt: skip
            elif row["interval"] > 0:
                rows[parameter].append((error, np.nan, np.nan, error <= row["interval"]))
    everywhere = np.full(len(reports), True)
    all_inside = []
    for parameter, values in rows.items():
        error, deviation, inside, within = np.array(values, dtype=float).T
        scale, unit = (100, "%") if parameter in RELATIVE else (1, "")
        if parameter in DEGREES:
            scale, unit = np.degrees(1), "deg, deg/s"
        limited = ""
        if parameter in LIMITS:
            of_limit = error <= LIMITS[parameter]
            everywhere &= of_limit
            limited = f"  within its limit {np.count_nonzero(of_limit)} of {len(of_limit)}"
        all_inside += inside[np.isfinite(inside)].tolist()
        print(f"  {parameter:32} largest error {scale * error.max():8.4f} {unit:10} median {scale * np.median(error):8.4f}"
              f"  standard error {scale * np.nanmedian(deviation) if np.isfinite(deviation).any() else np.nan:8.4f}"
              f"  within two of them {100 * np.nanmean(inside) if np.isfinite(inside).any() else np.nan:5.0f} %"
              f"  within the interval {100 * np.nanmean(within) if np.isfinite(within).any() else np.nan:5.0f} %"
              f"{limited}", flush=True)  # fmt: skip
    print(f"  within every limit {np.count_nonzero(everywhere)} of {len(drives)} drives; "
          f"truth within two standard errors {sum(all_inside):.0f} times of {len(all_inside)}", flush=True)  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steerguard", type=Path, required=True)
    parser.add_argument("folder", type=Path)
    a = parser.parse_args()
    steerguard = a.steerguard.resolve()
    groups = defaultdict(list)
    for drive in sorted(a.folder.glob("*.csv")):
        car, model, _ = drive.stem.split("_")
        groups[car, model].append(drive)
    for (car, model), drives in groups.items():
        vehicle = tomllib.loads((a.folder / f"{car}-truth.toml").read_text(encoding="utf-8"))["vehicle"]
        judge(steerguard, f"{car} {model}", drives, a.folder / f"{car}.toml", vehicle)


if __name__ == "__main__":
    main()
