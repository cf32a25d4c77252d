"""What the layer below both models promises an importer: times, refusals, callbacks, messages.

Conventions: times in s. Texts of refusals begin with the name of the function that refuses.
"""

import itertools
from ctypes import byref

import numpy as np
import pytest
from fmpy import fmi2
from fmpy.fmi1 import FMICallException

MOST_SAMPLES = 1_000_000  # in a step
SAMPLE_S = {"detector": 0.01, "plant": 0.001}  # the plant's is that of its integration
CRUISE = {
    "detector": {"v_x": 15.0, "r": 0.0, "u.T_eng": 78.75, "u.delta": 0.0},
    "plant": {"u.T_eng": 78.75, "u.delta": 0.001},
}


@pytest.fixture(params=["detector", "plant"])
def model(request):
    """Name of the model."""
    return request.param


@pytest.fixture
def fmu(request, model):
    return request.getfixturevalue(model)


def outputs(instance):
    """Values of all variables but the inputs and the Strings, by name."""
    names = [n for n, v in instance.variables.items() if v.causality != "input" and v.type != "String"]
    return instance.get(names)


def serialised(instance):
    state = instance.getFMUstate()
    try:
        return instance.serializeFMUstate(state)
    finally:
        instance.freeFMUstate(state)


def refused(instance, call):
    """Calls what must be refused with fmi2Error; the one text logged."""
    before = len(instance.messages)
    with pytest.raises(FMICallException) as failure:
        call()
    assert failure.value.status == fmi2.fmi2Error
    ((status, category, text),) = instance.messages[before:]
    assert (status, category) == (fmi2.fmi2Error, "logStatusError")
    return text


@pytest.mark.parametrize("start", [0.0, 3.0, -5.0, 1.7e9])
def test_a_stop_time_equal_to_the_start_time_is_none(fmu, model, start):
    step = 50 * SAMPLE_S[model]
    with fmu.instance() as instance:
        instance.initialise(CRUISE[model], start_time=start, stop_time=start)
        before = outputs(instance)
        for k in range(4):
            instance.doStep(start + k * step, step)
        assert outputs(instance) != before
        assert not instance.complaints()


def test_a_later_stop_time_is_one(fmu, model):
    step = SAMPLE_S[model]
    with fmu.instance() as instance:
        instance.initialise(start_time=3.0, stop_time=3.0 + step)
        instance.doStep(3.0, step)
        text = refused(instance, lambda: instance.doStep(3.0 + step, step))
    assert text.endswith(f"s from {3.0 + step!r} s ends after the stop time {3.0 + step!r} s")


def test_a_step_of_more_than_a_million_samples_changes_nothing(fmu, model):
    period = SAMPLE_S[model]
    most, more = MOST_SAMPLES * period, (MOST_SAMPLES + 1) * period
    with fmu.instance() as instance:
        instance.initialise(CRUISE[model])
        for k in range(10):
            instance.doStep(k * period, period)
        point = 10 * period
        before, values = serialised(instance), outputs(instance)
        text = refused(instance, lambda: instance.doStep(point, more))
        for part in [f"a step of {more} s from {point} s", f"more than {MOST_SAMPLES} samples"]:
            assert part in text, text
        assert serialised(instance) == before and outputs(instance) == values
        instance.doStep(point, most)
        assert serialised(instance) != before
        instance.doStep(point + most, period)
        assert len(instance.complaints()) == 1


@pytest.mark.parametrize("start", [1e17, -1e17, 1e300])
def test_a_start_where_time_cannot_advance_is_refused(fmu, model, start):
    period = SAMPLE_S[model]
    with fmu.instance() as instance:
        fresh = serialised(instance)
        text = refused(instance, lambda: instance.setupExperiment(startTime=start))
        written = np.format_float_scientific(start, trim="-", exp_digits=1).replace("e+", "e")
        assert text.startswith(f"fmi2SetupExperiment: time cannot advance from {written} s"), text
        assert text.endswith(f"samples {period} s")
        assert serialised(instance) == fresh
        instance.initialise(CRUISE[model], start_time=1.7e9)
        instance.doStep(1.7e9, period)
        assert len(instance.complaints()) == 1


@pytest.mark.parametrize("start", [np.nan, np.inf, -np.inf])
def test_a_start_that_is_no_time_is_refused(fmu, start):
    with fmu.instance() as instance:
        text = refused(instance, lambda: instance.setupExperiment(startTime=start))
        assert "no run can last from" in text


CALLBACKS = ["logger", "allocateMemory", "freeMemory", "stepFinished"]


@pytest.fixture
def whole_life(fmu, model):
    """What an instance gives that has all callbacks. It is over: fmpy has one logger at a time."""
    with fmu.instance() as instance:
        record = life(instance, model)
        assert instance.messages, "something was to be logged"
    return record


@pytest.mark.parametrize(
    "missing",
    [["logger"], ["allocateMemory"], ["freeMemory"], ["allocateMemory", "freeMemory"], CALLBACKS],
    ids="+".join,
)
def test_callbacks_may_be_missing(fmu, model, whole_life, missing):
    """All of a life gives what it gives with callbacks, and what is logged needs the logger alone.

    fmpy's component environment is NULL.
    """
    with fmu.instance(missing=missing) as instance:
        assert not instance.callbacks.componentEnvironment
        assert not any(getattr(instance.callbacks, callback) for callback in missing)
        assert life(instance, model) == whole_life
        assert bool(instance.messages) == ("logger" not in missing)


def test_the_callbacks_may_be_missing_altogether(fmu, model, whole_life):
    with fmu.instance() as instance:
        instance.fmi2FreeInstance(instance.component)
        instance.component = instantiated(instance, None)
        assert life(instance, model) == whole_life
        assert not instance.messages


def test_an_instance_that_is_refused_needs_no_callbacks(fmu):
    nothing = fmi2.fmi2CallbackFunctions()
    with fmu.instance() as instance:
        for callbacks in [None, byref(nothing)]:
            assert instantiated(instance, callbacks, guid=b"{another}") is None


def instantiated(instance, callbacks, guid=None):
    """A component of the library of `instance`, its resource location NULL too."""
    return instance.fmi2Instantiate(
        b"bare", fmi2.fmi2CoSimulation, guid or instance.guid.encode(), None, callbacks, 0, 1
    )


def life(instance, model):
    """From instantiated on: values after some steps, a refusal, a state restored, and a reset."""
    period = SAMPLE_S[model]
    instance.initialise(CRUISE[model])
    for k in range(20):
        instance.doStep(k * period, period)
    record = [outputs(instance)]
    state = instance.getFMUstate()
    with pytest.raises(FMICallException):
        instance.doStep(20 * period, -period)
    instance.doStep(20 * period, 30 * period)
    record.append(outputs(instance))
    record.append(instance.serializeFMUstate(state))
    instance.setFMUstate(state)
    instance.freeFMUstate(state)
    record.append(outputs(instance))
    instance.reset()
    record.append(serialised(instance))
    return record


def test_times_in_messages_have_all_their_digits(fmu, model):
    period, start = SAMPLE_S[model], 0.1 + 0.2
    with fmu.instance() as instance:
        instance.initialise(start_time=start)
        text = refused(instance, lambda: instance.doStep(1.7, period))
        assert f"from 1.7 s does not begin where the last one ended, at {start!r} s" in text
        text = refused(instance, lambda: instance.doStep(start, -period))
        assert text.endswith(f"-{period} s from {start!r} s is not a positive, finite span of time")
    with fmu.instance() as instance:
        instance.initialise()
        text = refused(instance, lambda: instance.doStep(start, period))
        assert f"a step of {period} s from {start!r} s does not begin where" in text


def test_times_of_events_have_all_their_digits(detector):
    start = 0.1 + 0.2
    with detector.instance() as instance:
        instance.initialise(CRUISE["detector"], start_time=start)
        instance.doStep(start, 0.01)
        instance.set({"v_x": np.nan})
        instance.doStep(start + 0.01, 0.01)
        monitoring, invalid = [text for _, _, text in instance.messages]
        assert monitoring == f"monitoring from {start!r} s"
        assert f"at {start + 0.01!r} s" in invalid


def test_refusals_of_parameters_name_them_and_their_bounds(fmu):
    """Every parameter with bounds, once below and once above them."""

    def written(bound):
        """As the FMU writes it: positional or with an exponent; the description says it as text."""
        number = float(bound)
        exponent = np.format_float_scientific(number, trim="-", exp_digits=1).replace("e+", "e")
        return {np.format_float_positional(number, trim="-"), exponent}

    tried = 0
    with fmu.instance() as instance:
        parameters = [v for v in instance.variables.values() if v.causality == "parameter"]
        for variable in parameters:
            if variable.type not in ("Real", "Integer"):
                continue
            fresh = serialised(instance)
            for bound, beyond in [(variable.min, -1.0), (variable.max, 1.0)]:
                if bound is None:
                    continue
                value = float(bound) + beyond * max(1.0, abs(float(bound)))
                if variable.type == "Integer":
                    value = int(np.clip(value, -(2**31), 2**31 - 1))
                    if value == int(bound):
                        continue  # no number beyond
                text = refused(instance, lambda: instance.set({variable.name: value}))
                assert f'variable "{variable.name}" cannot be' in text
                assert any(form in text for form in written(bound)), (bound, text)
                tried += 1
            assert serialised(instance) == fresh
    assert tried > 0


def test_refusals_of_items_name_them_all(detector):
    items = {i.name: int(i.value) for i in items_of(detector, "initialisation")}
    listed = ", ".join(f"{value} {name}" for name, value in items.items())
    with detector.instance() as instance:
        for value in [0, -1, max(items.values()) + 1]:
            text = refused(instance, lambda: instance.set({"initialisation": value}))
            expected = f'variable "initialisation" cannot be {value}: its items are {listed}'
            assert text.endswith(expected), text


def test_refusals_by_role_name_the_variable(fmu):
    with fmu.instance() as instance:
        instance.initialise()
        for variable in instance.variables.values():
            if variable.causality in ("input", "parameter") or variable.type == "String":
                continue
            value = instance.get([variable.name])
            text = refused(instance, lambda: instance.set(value))
            assert f'variable "{variable.name}" is a' in text and "cannot be set" in text


def items_of(fmu, name):
    """The items of an enumeration variable."""
    (variable,) = (v for v in fmu.description.modelVariables if v.name == name)
    return variable.declaredType.items


def test_integer_twins_follow_their_enumerations(detector):
    """Through all states that there are."""
    inputs = {
        "Starting": None,
        "Monitoring": {},
        "OutOfRange": {"v_x": 2.0},
        "InvalidInput": {"r": np.nan},
        "Disabled": {"enabled": False},
    }
    items = {i.name: int(i.value) for i in items_of(detector, "state")}
    # StaleInput needs time: test_against_reference.py.
    assert set(inputs) == set(items) - {"StaleInput"}, "a state more needs inputs that lead to it"
    names = ["state", "state_index", "initialisation", "initialisation_index"]
    for item in items_of(detector, "initialisation"):
        for order in itertools.permutations(list(inputs)[1:]):
            with detector.instance() as instance:
                chosen = int(item.value)
                instance.set({"initialisation": chosen, "z_0[1]": 15.0})

                def assert_state(name, instance=instance, chosen=chosen):
                    found = instance.get(names)
                    assert [found[n] for n in names] == [items[name]] * 2 + [chosen] * 2

                assert_state("Starting")
                instance.setupExperiment()
                instance.enterInitializationMode()
                assert_state("Starting")
                instance.exitInitializationMode()
                assert_state("Starting")
                for k, name in enumerate(order):
                    instance.set(CRUISE["detector"] | {"enabled": True} | inputs[name])
                    try:
                        instance.doStep(k * 0.01, 0.01)
                    except FMICallException as warning:
                        assert warning.status == fmi2.fmi2Warning
                    assert_state(name)


def test_the_threshold_obeys_its_factor_before_the_first_sample(detector, design):
    threshold = design["detector"]["evaluation"]["threshold"]
    with detector.instance() as instance:

        def threshold_with(factor):
            instance.set({"threshold_factor": factor})
            return instance.get(["J_th"])["J_th"]

        assert instance.get(["J_th"])["J_th"] == threshold
        assert threshold_with(2.0) == 2.0 * threshold
        instance.setupExperiment()
        assert threshold_with(0.5) == 0.5 * threshold
        instance.enterInitializationMode()
        assert threshold_with(3.0) == 3.0 * threshold
        instance.exitInitializationMode()
        assert threshold_with(4.0) == 4.0 * threshold
        assert instance.get(["J_ratio"])["J_ratio"] == 0.0
        instance.reset()
        assert instance.get(["J_th"])["J_th"] == threshold
