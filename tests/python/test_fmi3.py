"""The detector in FMI 3.0, in the hands of fmpy: the same numbers as in FMI 2.0, and the alarm as an event.

Conventions: times in s; a record is a mapping of names to lists with an entry for each communication point.
"""

import struct
import subprocess
import sys
import zipfile
from ctypes import byref, c_bool
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu
from fmu import Fmu
from lxml import etree

PERIOD = 0.01
ARRAYS = {"residual": ["residual.v_x", "residual.r"], "z_0": ["z_0[1]", "z_0[2]", "z_0[3]"]}
# What FMI 3.0 alone has.
OWN = ["alarm_change", "alarm_change_time", "time"]
GETTERS = {
    "Float64": "getFloat64", "Int32": "getInt32", "Enumeration": "getInt64", "Boolean": "getBoolean",
    "String": "getString",
}  # fmt: skip
SETTERS = {"Float64": "setFloat64", "Int32": "setInt32", "Boolean": "setBoolean"}


class Detector3(FMU3Slave):
    """A Co-Simulation instance whose variables have names."""

    def __init__(self, description, folder, **options):
        super().__init__(
            guid=description.instantiationToken,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="detector",
        )
        self.variables = {v.name: v for v in description.modelVariables}
        self.messages = []

        def log(environment, status, category, message):
            self.messages.append((status, category.decode(), message.decode()))

        self.instantiate(loggingOn=True, logMessage=log, **options)

    def set(self, values):
        for name, value in values.items():
            variable = self.variables[name]
            values = value if isinstance(value, list) else [value]
            getattr(self, SETTERS[variable.type])([variable.valueReference], values)

    def get(self, name):
        """A value, or the list of an array's."""
        variable = self.variables[name]
        count = int(np.prod(variable.shape)) if variable.dimensions else 1
        got = getattr(self, GETTERS[variable.type])([variable.valueReference], nValues=count)
        return list(got) if variable.dimensions else got[0]

    def clock(self):
        (active,) = self.getClock([self.variables["alarm_change"].valueReference])
        return bool(active)

    def initialise(self, event_mode=False):
        self.enterInitializationMode(startTime=0.0)
        self.exitInitializationMode()
        if event_mode:
            self.handle_event()

    def handle_event(self):
        """From Event Mode to Step Mode."""
        again, terminate, *_ = self.updateDiscreteStates()
        assert not again and not terminate
        self.enterStepMode()


@pytest.fixture(scope="module")
def path(fixtures):
    return fixtures / "SteeringFaultDetector.fmi3.fmu"


@pytest.fixture(scope="module")
def packaged(path, tmp_path_factory):
    """Its folder and description."""
    folder = fmpy.extract(str(path), unzipdir=str(tmp_path_factory.mktemp("fmi3")))
    return folder, fmpy.read_model_description(folder)


@pytest.fixture
def detector3(packaged):
    """Makes instances, freed at the end."""
    made = []

    def instance(**options):
        folder, description = packaged
        made.append(Detector3(description, folder, **options))
        return made[-1]

    yield instance
    for each in made:
        each.freeInstance()


def table(path, name):
    """Column names and rows of a table inside an FMU, numbers as they are written."""
    with zipfile.ZipFile(path) as archive:
        head, *lines = archive.read(f"extra/{name}").decode().splitlines()
    return head.split(","), [line.split(",") for line in lines]


def bits(value):
    """What two values have in common if they are the same."""
    return struct.pack("<d", value) if isinstance(value, float) else int(value)


@pytest.fixture(scope="module")
def reference_inputs(fixtures):
    names, rows = table(fixtures / "SteeringFaultDetector.fmu", "SteeringFaultDetector_in.csv")
    return names[1:], [[float(value) for value in row[1:]] for row in rows]


def run_fmpy(*arguments):
    """`python -m fmpy ...`."""
    command = [sys.executable, "-m", "fmpy", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


def test_fmpy_finds_nothing(path):
    assert validate_fmu(str(path)) == []
    result = run_fmpy("validate", path)
    assert result.returncode == 0 and "No problems found" in result.stdout, result.stdout


def test_our_own_check_finds_nothing(path, steerguard):
    result = subprocess.run([steerguard, "check", path], capture_output=True, text=True, check=False)
    assert result.returncode == 0 and "no findings" in result.stdout, result.stdout


@pytest.mark.parametrize(
    ("file", "schema"),
    [
        ("modelDescription.xml", "fmi3ModelDescription.xsd"),
        ("terminalsAndIcons/terminalsAndIcons.xml", "fmi3TerminalsAndIcons.xsd"),
    ],
)
def test_files_follow_the_schema(packaged, file, schema):
    schemas = Path(fmpy.__file__).parent / "schema" / "fmi3"
    schema = etree.XMLSchema(file=str(schemas / schema))
    document = etree.parse(str(Path(packaged[0], file)))
    assert schema.validate(document), schema.error_log


@pytest.mark.parametrize("events", [False, True])
def test_fmpy_simulates_with_defaults(path, events):
    result = fmpy.simulate_fmu(str(path), use_event_mode=events, early_return_allowed=events)
    assert len(result) > 100
    for name in result.dtype.names:
        assert np.isfinite(result[name].astype(float)).all(), name


def test_interface_is_that_of_fmi_2(detector, packaged):
    description = packaged[1]
    capabilities = description.coSimulation
    assert description.modelExchange is None and description.scheduledExecution is None
    assert capabilities.hasEventMode and capabilities.mightReturnEarlyFromDoStep
    assert capabilities.canHandleVariableCommunicationStepSize
    assert capabilities.canGetAndSetFMUstate and capabilities.canSerializeFMUstate
    assert float(capabilities.fixedInternalStepSize) == PERIOD
    of_fmi2 = {v.name: v for v in detector.description.modelVariables}
    of_fmi3 = {v.name: v for v in description.modelVariables}
    elements = [element for array in ARRAYS.values() for element in array]
    assert set(of_fmi3) == set(of_fmi2) - set(elements) | set(ARRAYS) | set(OWN)
    for name in set(of_fmi2) & set(of_fmi3):
        two, three = of_fmi2[name], of_fmi3[name]
        same = ["valueReference", "description", "causality", "variability", "unit", "start"]
        for attribute in same:
            assert getattr(two, attribute) == getattr(three, attribute), (name, attribute)
    for name, array in ARRAYS.items():
        assert of_fmi3[name].valueReference == of_fmi2[array[0]].valueReference
        assert of_fmi3[name].shape == (len(array),)
    clock, clocked = of_fmi3["alarm_change"], of_fmi3["alarm_change_time"]
    assert (clock.type, clock.intervalVariability, clock.causality) == ("Clock", "triggered", "output")
    assert clocked.clocks == [clock]


def test_all_results_of_the_reference_input_are_those_of_fmi_2_bit_for_bit(
    detector, detector3, reference_inputs
):
    names, rows = reference_inputs
    three = detector3()
    three.initialise()
    shown = [n for n, v in three.variables.items() if v.causality in ("output", "local") and n not in OWN]
    compared, alarms = 0, 0
    with detector.instance() as two:
        two.initialise()
        for k, row in enumerate(rows):
            inputs = dict(zip(names, row, strict=True))
            two.set(inputs)
            three.set(inputs)
            two.doStep(k * PERIOD, PERIOD)
            assert three.doStep(k * PERIOD, PERIOD)[:3] == (False, False, False)
            for name in shown:
                found = three.get(name)
                if name in ARRAYS:
                    expected = two.get(ARRAYS[name])
                    pairs = [(expected[element], value) for element, value in zip(ARRAYS[name], found, strict=True)]
                else:
                    pairs = [(two.get([name])[name], found)]
                for expected, value in pairs:
                    if isinstance(expected, bytes):
                        assert value in (expected, expected.decode())
                    else:
                        assert bits(expected) == bits(value), (name, k)
                    compared += 1
            alarms += three.get("alarm")
    assert compared > 50 * len(rows) and alarms > 0


def test_the_reference_table_inside_is_met_digit_for_digit(path, detector3, fixtures):
    names, rows = table(path, "SteeringFaultDetector_in.csv")
    heads, expected = table(path, "SteeringFaultDetector_ref.csv")
    heads2, expected2 = table(fixtures / "SteeringFaultDetector.fmu", "SteeringFaultDetector_ref.csv")
    assert expected == expected2, "but for the names it is the table of FMI 2.0"
    assert heads[1:3] == ["residual[1]", "residual[2]"] and heads[3:] == heads2[3:]
    instance = detector3()
    instance.initialise()
    for row, wanted in zip(rows, expected, strict=True):
        time = float(row[0])
        found = [*instance.get("residual"), *(float(instance.get(name)) for name in heads[3:])]
        assert [bits(value) for value in found] == [bits(float(text)) for text in wanted[1:]], time
        instance.set({name: float(text) for name, text in zip(names[1:], row[1:], strict=True)})
        instance.doStep(time, PERIOD)


def drive(instance, inputs, step, duration, event_mode):
    """Steps with the inputs at each communication point; events (point, time, alarm, time said) and what is shown."""
    names, rows = inputs
    events, shown = [], []
    for i in range(round(duration / step)):
        time, end = i * step, (i + 1) * step
        while True:
            row = rows[min(round(time / PERIOD), len(rows) - 1)] if time == i * step else None
            if row:
                instance.set(dict(zip(names, row, strict=True)))
            event, terminate, early, reached = instance.doStep(time, end - time)
            assert not terminate
            if event:
                assert event_mode and not instance.clock()
                instance.enterEventMode()
                assert instance.clock()
                events.append((i * step, reached, instance.get("alarm"), instance.get("alarm_change_time")))
                instance.handle_event()
            if not early:
                assert reached == pytest.approx(end)
                break
            assert event and time <= reached < end
            time = reached
        shown.append((instance.get("residual"), instance.get("J_rms"), instance.get("alarm")))
    return events, shown


@pytest.mark.parametrize("debounce", [1, 4])
def test_the_alarm_is_an_event_at_its_sample_within_a_step_of_100_ms(detector3, reference_inputs, debounce):
    """The fault comes with a communication point: the alarm `debounce` samples from there."""
    whole, instance = detector3(), detector3(eventModeUsed=True, earlyReturnAllowed=True)
    for each in (whole, instance):
        each.set({"debounce_samples": debounce})
    whole.initialise()
    instance.initialise(event_mode=True)
    none, without = drive(whole, reference_inputs, 0.1, 10.0, event_mode=False)
    events, shown = drive(instance, reference_inputs, 0.1, 10.0, event_mode=True)
    assert none == [] and events
    assert shown == without, "inputs are those of the communication points in both"
    point, reached, alarm, said = events[0]
    first = whole.get("first_alarm_time")
    assert alarm and reached == said == first
    assert first == pytest.approx(round(first / PERIOD) * PERIOD)
    assert reached - point == pytest.approx((debounce - 1) * PERIOD), "at the sample"
    alarms = [alarm for _, _, alarm, _ in events]
    assert alarms == [i % 2 == 0 for i in range(len(alarms))], "raised and ended in turn"


def test_without_early_return_the_clock_ticks_at_the_end_of_the_step(detector3, reference_inputs):
    whole, instance = detector3(), detector3(eventModeUsed=True, earlyReturnAllowed=False)
    whole.initialise()
    instance.initialise(event_mode=True)
    _, without = drive(whole, reference_inputs, 0.1, 10.0, event_mode=False)
    events, shown = drive(instance, reference_inputs, 0.1, 10.0, event_mode=True)
    assert shown == without and events
    point, reached, _, said = events[0]
    assert reached == pytest.approx(point + 0.1) and point <= said < reached


def test_a_saved_state_takes_the_event_along(detector3, reference_inputs):
    names, rows = reference_inputs
    instance = detector3(eventModeUsed=True, earlyReturnAllowed=True)
    instance.initialise(event_mode=True)
    for i in range(100):
        instance.set(dict(zip(names, rows[10 * i], strict=True)))
        event, _, _, reached = instance.doStep(i * 0.1, 0.1)
        if event:
            break
    else:
        pytest.fail("no event")
    state = instance.getFMUState()
    serialised = instance.serializeFMUState(state)
    other = detector3(eventModeUsed=True, earlyReturnAllowed=True)
    restored = other.deserializeFMUState(serialised)
    other.setFMUState(restored)
    for each in (instance, other):
        each.enterEventMode()
        assert each.clock() and each.get("alarm_change_time") == pytest.approx(reached)
    instance.freeFMUState(state)
    other.freeFMUState(restored)


def test_initial_state_is_set_as_an_array(detector3):
    instance = detector3()
    instance.set({"z_0": [20.0, 0.5, 0.1]})
    assert instance.get("z_0") == [20.0, 0.5, 0.1]
    with pytest.raises(FMICallException):
        instance.set({"z_0": [20.0, 0.5]})
    status, category, text = instance.messages[-1]
    assert (status, category) == (3, "logStatusError")
    assert text == "fmi3SetFloat64: the variables have 3 elements, nValues is 2"


def test_what_is_not_provided_is_refused_with_a_message(detector3):
    instance = detector3()
    instance.initialise()
    value = c_bool()
    for call, reason in [
        (lambda: instance.fmi3EnterContinuousTimeMode(instance.component), "not for Model Exchange"),
        (lambda: instance.fmi3ActivateModelPartition(instance.component, 0, 0.0), "Scheduled Execution"),
        (lambda: instance.fmi3EnterConfigurationMode(instance.component), "no structural parameters"),
        (lambda: instance.fmi3SetClock(instance.component, None, 0, byref(value)), "triggered output"),
    ]:
        with pytest.raises(FMICallException):
            call()
        status, _, text = instance.messages[-1]
        assert status == 3 and reason in text, text


def test_terminals_name_what_is_wired(packaged):
    root = etree.parse(str(Path(packaged[0], "terminalsAndIcons", "terminalsAndIcons.xml"))).getroot()
    members = {
        terminal.get("name"): {m.get("memberName"): m.get("variableName") for m in terminal}
        for terminal in root.find("Terminals")
    }
    assert members["measurement"] == {"v_x": "v_x", "r": "r"}
    assert members["command"] == {"T_eng": "u.T_eng", "delta": "u.delta"}
    assert {"alarm", "residual", "alarm_change"} <= set(members["verdict"])
    names = {v.name for v in packaged[1].modelVariables}
    assert all(variable in names for member in members.values() for variable in member.values())
    assert Path(packaged[0], "terminalsAndIcons", "icon.png").exists()
