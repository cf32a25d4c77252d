"""examples/python: run as they stand."""

import csv
import os
import subprocess
import sys
from pathlib import Path

import pytest
import scenario
from signals import INPUTS

EXAMPLES = Path(__file__).parents[2] / "examples" / "python"


@pytest.fixture(scope="module")
def table(plant, detector, reference, tmp_path_factory):
    """A drive with a fault from `scenario.FAULT_ONSET_S` on, as `simulate` writes it."""
    record = scenario.drive(plant, detector, 15.0, reference.period)
    path = tmp_path_factory.mktemp("drive") / "run.csv"
    with path.open("w", encoding="utf-8", newline="") as file:
        write = csv.writer(file)
        write.writerow(["time", *INPUTS])
        write.writerows(zip(*(record[name].tolist() for name in ["time", *INPUTS]), strict=True))
    return path


def run(script, *arguments, cwd):
    return subprocess.run(
        [sys.executable, EXAMPLES / script, *arguments], cwd=cwd, capture_output=True, text=True, timeout=300,
        env=os.environ | {"MPLCONFIGDIR": str(cwd)},
    )  # fmt: skip


def test_detect_finds_the_fault_and_draws_it(fixtures, table, tmp_path):
    ran = run("detect.py", fixtures / "SteeringFaultDetector.fmu", table, "detection.png", cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    first = float(ran.stdout.split("first alarm at ")[1].split()[0])
    assert scenario.FAULT_ONSET_S < first < scenario.FAULT_ONSET_S + 0.2
    assert (tmp_path / "detection.png").read_bytes().startswith(b"\x89PNG")


def test_detect_names_a_column_that_is_not_there(fixtures, tmp_path):
    (tmp_path / "run.csv").write_text("time,v_x\n0.0,15.0\n1.0,15.0\n", encoding="utf-8")
    ran = run("detect.py", fixtures / "SteeringFaultDetector.fmu", "run.csv", "no.png", cwd=tmp_path)
    assert ran.returncode == 1 and "no column r;" in ran.stderr


def test_the_alarm_clock_ticks_at_the_sample(fixtures, table, tmp_path):
    ran = run("alarm_clock.py", fixtures / "SteeringFaultDetector.fmi3.fmu", table, cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    first = ran.stdout.splitlines()[0]
    when = float(first.split(" s: ")[0])
    assert "alarm" in first and scenario.FAULT_ONSET_S <= when < scenario.FAULT_ONSET_S + 0.2
