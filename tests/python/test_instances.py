"""Life of an instance: refusal, independence, reset, saved states."""

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from signals import OUTPUTS, random_drive

N = 600


def rows(inputs, chosen):
    return {name: values[chosen] for name, values in inputs.items()}


def assert_equal(found, expected):
    for name in OUTPUTS:
        np.testing.assert_array_equal(found[name], expected[name], err_msg=name)


@pytest.fixture(scope="module")
def inputs(reference):
    drive = random_drive(21, N, reference.period, v_x=(8.0, 28.0), r=(-0.3, 0.3))
    drive["v_x"][100:110] = np.nan
    return drive


@pytest.fixture(scope="module")
def record(detector, reference, inputs):
    """What a single undisturbed instance gives."""
    with detector.instance() as instance:
        instance.initialise()
        record = instance.record(inputs, OUTPUTS, reference.period)
    assert record["alarm"].any(), "the comparison needs something to compare"
    return record


@pytest.mark.parametrize("fmu", ["detector", "plant"])
def test_wrong_guid_is_refused(request, fmu):
    fmu = request.getfixturevalue(fmu)
    with pytest.raises(Exception, match="Failed to instantiate"), fmu.instance(guid="{0}"):
        pass
    with fmu.instance():
        pass


def test_instances_do_not_know_of_each_other(detector, reference, inputs, record):
    with (
        detector.instance(name="one") as one,
        detector.instance(name="two") as two,
        detector.instance(name="idle"),
    ):
        one.initialise()
        two.initialise({"threshold_factor": 3.0})
        outputs = {name: [] for name in OUTPUTS}
        for k in range(N):
            one.set({name: values[k] for name, values in inputs.items()})
            two.set({name: values[N - 1 - k] for name, values in inputs.items()})
            for instance in (two, one):
                instance.doStep(k * reference.period, reference.period)
            for name, value in one.get(OUTPUTS).items():
                outputs[name].append(value)
    assert_equal(outputs, record)


@pytest.mark.parametrize("terminated", [False, True])
def test_reset_is_a_fresh_instance(detector, reference, inputs, record, terminated):
    with detector.instance() as instance:
        instance.initialise({"threshold_factor": 5.0, "debounce_samples": 9}, start_time=7.0)
        instance.record(rows(inputs, slice(0, 150)), OUTPUTS, reference.period, 7.0)
        if terminated:
            instance.terminate()
        instance.reset()
        instance.initialise()
        assert_equal(instance.record(inputs, OUTPUTS, reference.period), record)


@pytest.mark.parametrize("saved_at", [0, 37, 105, 400])
def test_a_restored_state_continues_bit_for_bit(detector, reference, inputs, record, saved_at):
    period = reference.period
    head, tail = slice(0, saved_at), slice(saved_at, N)
    rest = {name: values[tail] for name, values in record.items()}
    with detector.instance() as instance:
        instance.initialise()
        if saved_at:
            instance.record(rows(inputs, head), OUTPUTS, period)
        state = instance.getFMUstate()
        for _ in range(2):  # away and back, more than once
            found = instance.record(rows(inputs, tail), OUTPUTS, period, saved_at * period)
            assert_equal(found, rest)
            instance.setFMUstate(state)
        blob = instance.serializeFMUstate(state)
        instance.freeFMUstate(state)

    with detector.instance(name="elsewhere") as other:
        other.initialise({"threshold_factor": 2.0})
        state = other.deSerializeFMUstate(blob)
        other.setFMUstate(state)
        other.freeFMUstate(state)
        found = other.record(rows(inputs, tail), OUTPUTS, period, saved_at * period)
        assert_equal(found, rest)


def test_a_damaged_state_is_refused_and_changes_nothing(detector, reference, inputs, record):
    with detector.instance() as instance:
        instance.initialise()
        half = N // 2
        instance.record(rows(inputs, slice(0, half)), OUTPUTS, reference.period)
        state = instance.getFMUstate()
        blob = instance.serializeFMUstate(state)
        instance.freeFMUstate(state)
        flipped = bytearray(blob)
        flipped[len(flipped) // 2] ^= 1
        for damaged in (bytes(flipped), blob[:-1], blob + b"\0", b""):
            with pytest.raises(FMICallException):
                instance.deSerializeFMUstate(damaged)
        found = instance.record(
            rows(inputs, slice(half, N)), OUTPUTS, reference.period, half * reference.period
        )
        assert_equal(found, {name: values[half:] for name, values in record.items()})


def test_one_warning_for_an_episode_of_invalid_input(detector, reference, inputs):
    with detector.instance() as instance:
        instance.initialise()
        instance.record(inputs, OUTPUTS, reference.period)
        complaints = instance.complaints()
    assert len(complaints) == 1 and "not finite" in complaints[0], complaints
