"""The second test of the packaged detector against its statement in numpy, on recorded drives."""

from pathlib import Path

import numpy as np
import pytest
from reference import SECOND_TEST
from second_test import NOT_KNOWN, STEERING, UNDECIDED, YAW_RATE_SENSOR
from signals import INPUTS, OUTPUTS, assert_agree, expected

RECORDED = Path(__file__).parents[1] / "replay" / "recorded" / "default"


def drive(name):
    table = np.loadtxt(RECORDED / f"{name}.inputs.csv", delimiter=",", skiprows=1)
    return dict(zip(INPUTS, table.T, strict=True))


@pytest.mark.parametrize("name", ["fault", "edges"])
def test_recorded_drives(request, with_second_test, name):
    detector, reference = with_second_test
    inputs = drive(name)
    causes, hypotheses, largest = set(), set(), 0.0
    for factor in [1.0, 0.5]:
        with detector.instance() as instance:
            instance.initialise({"threshold_factor": factor})
            found = instance.record(inputs, OUTPUTS, reference.period)
        results = expected(reference, inputs, threshold_factor=factor)
        assert_agree(found, results, inputs, reference.weights)
        assert results["second_ratio"].max() > 0.5
        causes.update(results["alarm_cause"])
        hypotheses.update(results["fault_hypothesis"])
        largest = max(largest, np.abs(results["fault_estimate"]).max())
    # It finds what the residual does not, or not yet, and says what; told that everything may be, it stays undecided.
    told = request.node.callspec.params["with_second_test"]
    assert SECOND_TEST in causes and (STEERING if told == "few" else UNDECIDED) in hypotheses
    assert hypotheses <= {NOT_KNOWN, STEERING, UNDECIDED}, "no sensor has stepped"
    assert largest > 1e-3


@pytest.mark.parametrize("with_second_test", ["few"], indirect=True)
def test_a_step_of_the_yaw_rate_sensor_is_named(with_second_test):
    detector, reference = with_second_test
    inputs = {name: column[:700].copy() for name, column in drive("fault").items()}
    inputs["r"][600:] += 0.1
    with detector.instance() as instance:
        instance.initialise({})
        found = instance.record(inputs, OUTPUTS, reference.period)
    assert_agree(found, expected(reference, inputs), inputs, reference.weights)
    assert set(found["fault_hypothesis"][:600]) == {NOT_KNOWN}
    assert set(found["fault_hypothesis"][605:640]) == {YAW_RATE_SENSOR}
