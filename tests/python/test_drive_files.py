"""The recipes of docs/drive-files.md on files that are made here, and what `replay` reads of them."""

import json
import re
import subprocess
from pathlib import Path

import asammdf
import numpy as np
import pytest
from scipy.io import savemat

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/drive-files.md").read_text(encoding="utf-8")


def recipe(heading):
    """The Python code below a heading of the page."""
    section = PAGE.split(f"\n## {heading}\n")[1].split("\n## ")[0]
    return re.search(r"```python\n(.*?)```", section, re.DOTALL)[1]


def run(code, folder, monkeypatch):
    monkeypatch.chdir(folder)
    exec(compile(code, "recipe", "exec"), {})


def replayed(steerguard, fixtures, folder):
    """The drive in the summary of `replay` on drive.csv."""
    command = [steerguard, "replay", fixtures / "design.json", "drive.csv", "--allow", "uncertified,blind", "--json"]
    done = subprocess.run(command, cwd=folder, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)["drives"][0]


def course(t):
    """Speed in m/s, yaw rate in rad/s and steering in rad of a gentle drive."""
    return 15.0 + np.sin(0.2 * t), 0.05 * np.sin(0.5 * t), 0.3 * np.sin(0.5 * t)


def test_mdf4(steerguard, fixtures, tmp_path, monkeypatch):
    slow, fast = np.arange(0.0, 20.0, 0.02), np.arange(0.003, 20.0, 0.01)
    speed, yaw_rate, steering = course(slow)[0], course(fast)[1], course(fast)[2]
    log = asammdf.MDF(version="4.10")
    for group in [
        [asammdf.Signal(3.6 * speed, slow, name="VehicleSpeed", unit="km/h")],
        [
            asammdf.Signal(np.degrees(yaw_rate), fast, name="YawRate", unit="deg/s"),
            asammdf.Signal(np.degrees(steering), fast, name="SteeringWheelAngle", unit="deg"),
        ],
    ]:
        log.append(group)
    log.save(tmp_path / "log.mf4")
    log.close()
    run(recipe("MDF4 to CSV"), tmp_path, monkeypatch)
    drive = replayed(steerguard, fixtures, tmp_path)
    assert drive["columns"][:4] == [
        'time: column "time [s]", s -> s (guessed)',
        'speed: column "VehicleSpeed [km/h]", km/h -> m/s (guessed)',
        'yaw rate: column "YawRate [deg/s]", deg/s -> rad/s (guessed)',
        'steering: column "SteeringWheelAngle [deg]", deg -> rad (guessed)',
    ]
    assert (drive["rows"], drive["pieces"]) == (len(slow) + len(fast), 1)
    assert drive["driven_s"] == pytest.approx(20.0, abs=0.05)


def test_mat(steerguard, fixtures, tmp_path, monkeypatch):
    t = np.arange(0.0, 20.0, 0.01)
    v, r, delta = course(t)
    savemat(tmp_path / "log.mat", {"t": t, "v": v, "r": r, "delta": delta})
    run(recipe("MAT to CSV"), tmp_path, monkeypatch)
    drive = replayed(steerguard, fixtures, tmp_path)
    assert drive["columns"][3] == 'steering: column "steering [rad]", rad -> rad (guessed)'
    assert (drive["rows"], drive["pieces"]) == (len(t), 1)
    # Its numbers to the last digit: the first speed of the trace is the one that was saved.
    trace = (tmp_path / "steerguard-replay/drive.trace.csv").read_text(encoding="utf-8").splitlines()
    place = trace[0].split(",").index("v_x")
    assert [float(line.split(",")[place]) for line in trace[1:]] == v.tolist()
