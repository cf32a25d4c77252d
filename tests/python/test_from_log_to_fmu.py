"""docs/from-log-to-fmu.md: its five commands on a log of the packaged reference vehicle, as a logger would write it."""

import csv
import json
import re
import shlex
import subprocess
import tomllib
from pathlib import Path

import numpy as np
import pytest

PERIOD_S = 0.01
TUTORIAL = Path(__file__).parents[2] / "docs" / "from-log-to-fmu.md"
# What the log's makers did not say.
RATIO, OFFSET_DEG, BIAS_DEG_PER_S = 16.0, 3.0, 0.2
TOLD = """[vehicle]
mass_kg = 1476
yaw_inertia_kg_m2 = 1810
front_axle_distance_m = 1.13
rear_axle_distance_m = 1.49
"""


def speed(t):
    return float(np.interp(t, [0, 38, 52, 92, 98, 110], [6, 6, 19, 19, 8, 8]))


def angle(t, v):
    """Road-wheel angle, rad: slow turns, a sweep from 0.1 to 1.6 Hz, a weave while braking."""
    if t < 38:
        return 0.09 * np.sin(2 * np.pi * t / 12.67)
    per_lateral = 2.62 / v**2 + 0.0017
    if 52 <= t < 90:
        phase = 2 * np.pi * (0.1 * (t - 52) + 0.5 * 1.5 / 38 * (t - 52) ** 2)
        return 3.2 * per_lateral * np.sin(phase) * min(1.0, (t - 52) / 2, 90 - t)
    if 92 <= t < 104:
        return 1.5 * per_lateral * np.sin(2 * np.pi * (t - 92) / 4)
    return 0.0


def log(plant, path, seed, duration):
    """Drives the plant and writes what a logger would."""
    columns = ["time [s]", "v [km/h]", "yaw_rate [deg/s]", "hand_wheel [deg]"]
    with plant.instance() as car, path.open("w", encoding="utf-8", newline="") as file:
        noise = {"noise.v_x": 0.02, "noise.r": 0.002, "noise.seed": seed, "noise.sample_period": PERIOD_S}
        car.initialise({"initial.v_x": speed(0.0)} | noise)
        data = car.get(["vehicle.I_e", "vehicle.C_x"])
        write = csv.writer(file)
        write.writerow(columns)
        for k in range(round(duration / PERIOD_S)):
            t = k * PERIOD_S
            y = car.get(["v_x", "r"])
            v, next_v = speed(t), speed(t + PERIOD_S)
            slope = (next_v - v) / PERIOD_S + (v - y["v_x"])
            delta = angle(t, v)
            write.writerow([
                f"{t:.3f}",
                f"{3.6 * y['v_x']:.3f}",
                f"{np.degrees(y['r']) + BIAS_DEG_PER_S:.3f}",
                f"{RATIO * np.degrees(delta) + OFFSET_DEG:.3f}",
            ])  # fmt: skip
            car.set({"u.T_eng": data["vehicle.C_x"] * v**2 + data["vehicle.I_e"] * slope, "u.delta": delta})
            car.doStep(t, PERIOD_S)


@pytest.fixture(scope="module")
def folder(plant, tmp_path_factory):
    folder = tmp_path_factory.mktemp("log")
    (folder / "told.toml").write_text(TOLD, encoding="utf-8")
    log(plant, folder / "log.csv", seed=1, duration=110)
    log(plant, folder / "another-day.csv", seed=2, duration=110)
    return folder


def commands():
    """The commands of the tutorial, in order."""
    blocks = re.findall(r"```console\n(.*?)```", TUTORIAL.read_text(encoding="utf-8"), flags=re.DOTALL)
    lines = [line for block in blocks for line in block.splitlines()]
    return [line.removeprefix("$ ") for line in lines if line.startswith("$ steerguard ")]


def test_the_tutorial_leads_from_a_log_to_a_detector_that_sees(folder, steerguard):
    lines = commands()
    assert [shlex.split(line)[1] for line in lines] == ["identify", "design", "replay", "replay", "package"]
    printed = []
    for line in lines:
        run = subprocess.run([steerguard, *shlex.split(line)[1:]], cwd=folder, capture_output=True, text=True)
        assert run.returncode == 0, f"{line}\n{run.stdout}{run.stderr}"
        printed.append(run.stdout)

    car = tomllib.loads((folder / "car.toml").read_text(encoding="utf-8"))
    assert car["sensors"]["steering_ratio"] == pytest.approx(RATIO, rel=0.01)
    assert car["sensors"]["steering_offset_deg"] == pytest.approx(OFFSET_DEG / RATIO, abs=0.02)
    assert car["sensors"]["yaw_rate_bias_deg_per_s"] == pytest.approx(BIAS_DEG_PER_S, abs=0.03)
    for axle, stiffness in [("front", 57000), ("rear", 59000)]:
        found = car["vehicle"][f"{axle}_cornering_stiffness_n_per_rad"]
        low, high = car["uncertainty"][f"{axle}_cornering_stiffness_percent"]
        assert found * (1 + low / 100) < stiffness < found * (1 + high / 100)
    assert (folder / "SteeringFaultDetector.fmu").exists()
    assert (folder / "car.fit.svg").read_text(encoding="utf-8").startswith("<svg")


def test_what_is_missing_is_named_with_the_manoeuvre_and_nothing_is_written(folder, steerguard, tmp_path):
    lines = (folder / "log.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    fast = tmp_path / "fast.csv"
    # 12 s at one speed: straight on but for the beginning of the sweep.
    fast.write_text("".join(lines[:1] + lines[5200:6400]), encoding="utf-8")
    run = subprocess.run(
        [steerguard, "identify", "fast.csv", "--known", folder / "told.toml", "--json"],
        cwd=tmp_path, capture_output=True, text=True,
    )  # fmt: skip
    assert run.returncode == 1, run.stdout + run.stderr
    diagnostics = json.loads(run.stderr)["diagnostics"]
    assert any("steering ratio" in of["message"] or "stiffness" in of["message"] for of in diagnostics), diagnostics
    assert all(of["help"][0].startswith("drive ") for of in diagnostics)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["fast.csv"]
