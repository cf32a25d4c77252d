"""The scenario of method 7: plant and detector as two FMUs, driven by fmpy."""

import functools

import numpy as np
import pytest
import scenario
from cases import Case
from reference import MONITORING, OUT_OF_RANGE, windowed_rms
from signals import assert_agree, expected

REFERENCE = Case("well_posed")


@pytest.fixture(scope="module")
def run(plant, detector, reference):
    """Record of the scenario at a speed."""
    return functools.cache(
        lambda speed: scenario.drive(plant, detector, speed, reference.period)
    )


@pytest.mark.parametrize("speed", [6.0, 15.0, 25.0])
def test_fault_is_detected_and_nothing_else(run, speed):
    record = run(speed)
    before = record["time"] < scenario.FAULT_ONSET_S - 1e-9
    assert (record["state"] == MONITORING).all()
    assert not record["alarm"][before].any()
    onset_to_alarm_s = record["first_alarm_time"][-1] - scenario.FAULT_ONSET_S
    assert record["alarm_latched"][-1] and 0.0 <= onset_to_alarm_s
    REFERENCE.check("delay_s", onset_to_alarm_s - 1e-9)
    later = record["time"] > scenario.FAULT_ONSET_S + 0.5
    assert record["alarm"][later].all(), "the fault stays, and so does the alarm"


def test_edge_of_the_range(run, reference):
    """The paper's 5 m/s is where the design range ends: no detector there, and it says so."""
    assert 5.0 < reference.bounds[0, 0] + reference.hysteresis[0], "arms above the edge only"
    record = run(5.0)
    assert (record["state"] == OUT_OF_RANGE).all()
    assert not record["alarm_latched"].any()


@pytest.mark.parametrize("speed", [5.0, 6.0, 15.0, 25.0])
def test_results_are_the_references(run, reference, speed):
    record = run(speed)
    assert_agree(record, expected(reference, record), record, reference.weights)


@pytest.mark.parametrize("speed", [6.0, 15.0, 25.0])
def test_level_of_the_residual(run, reference, speed):
    """J with W_r = I over 40 samples, as computed independently of this project."""
    record = run(speed)
    t = record["time"]
    j = windowed_rms(np.hypot(record["residual.v_x"], record["residual.r"]), 40)
    REFERENCE.check("start_up_peak", j[t < 2.0].max())
    REFERENCE.check("fault_free_j_after_2_s", j[(t >= 2.0) & (t < 5.0 - 1e-9)].max())
    for at_s, figure in [(5.1, "j_at_5_1_s"), (5.5, "j_at_5_5_s"), (19.99, "j_at_20_s")]:
        REFERENCE.check(figure, np.interp(at_s, t, j))
