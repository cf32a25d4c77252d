"""fmpy left to itself: no step given, it doubles the detector's own until at most 1000 points."""

import subprocess
import sys

import fmpy
import numpy as np
import pytest
import scenario
from signals import INPUTS

SPEED = 15.0


@pytest.fixture(scope="module", params=[20.0, 60.0])
def drive(request, plant, detector, reference):
    """A drive with a steering fault, recorded at every sample, as fmpy takes inputs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scenario, "DURATION_S", request.param)
        record = scenario.drive(plant, detector, SPEED, reference.period)
    table = np.zeros(len(record["time"]), dtype=[(name, float) for name in ["time", *INPUTS]])
    for name in table.dtype.names:
        table[name] = record[name]
    return request.param, table


def assert_detected(result, stop_time, period):
    """The alarm is raised after the onset and not before, at one point after another."""
    step = np.diff(result["time"])
    doubled = 2.0 ** np.ceil(np.log2(stop_time / period / 1000))
    assert len(result) <= 1001 and np.allclose(step, doubled * period)
    assert result["time"][-1] == pytest.approx(stop_time)
    alarm_times = result["time"][result["alarm"].astype(bool)]
    assert alarm_times.size, "no alarm"
    assert scenario.FAULT_ONSET_S < alarm_times[0] <= scenario.FAULT_ONSET_S + 0.1 + 2 * step[0]


def test_simulate_fmu(fixtures, reference, drive):
    stop_time, inputs = drive
    result = fmpy.simulate_fmu(
        str(fixtures / "SteeringFaultDetector.fmu"), stop_time=stop_time, input=inputs
    )
    assert_detected(result, stop_time, reference.period)


def test_command(fixtures, tmp_path, reference, drive):
    stop_time, inputs = drive
    table, output = tmp_path / "inputs.csv", tmp_path / "results.csv"
    header = ",".join(f'"{name}"' for name in inputs.dtype.names)
    np.savetxt(table, inputs.tolist(), delimiter=",", header=header, comments="", fmt="%.17g")
    subprocess.run(
        [sys.executable, "-m", "fmpy", "simulate", fixtures / "SteeringFaultDetector.fmu",
         "--stop-time", str(stop_time), "--input-file", table, "--output-file", output],
        check=True, capture_output=True, timeout=300,
    )  # fmt: skip
    result = np.genfromtxt(output, delimiter=",", names=True, dtype=None, deletechars="")
    assert_detected(result, stop_time, reference.period)
