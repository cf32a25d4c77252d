"""The packaged detector in several importers against the detector without an FMU around it.

The records of the plain detector come from tests/conformance, which the Rust tests write to the
folder of the packaged FMUs: for each communication step a table with the inputs that hold from each
communication point on and the results after the step that begins there.

Equality is exact: the results are bit for bit the same.
"""

import numpy as np
import pytest
from fmpy.model_description import read_model_description
from signals import INPUTS, OUTPUTS

# Name of the record to the step in sample periods.
# Without `excited`, which is detectability >= 1 and no result of the detector's own, the causes, which
# follow from what is recorded, and the second test, which this design has not.
NOT_RECORDED = ["excited", "alarm_cause", "state_cause", "second_ratio"]
NOT_RECORDED += ["fault_estimate", "fault_estimate_bound", "fault_onset_time", "fault_hypothesis"]
RESULTS = [name for name in OUTPUTS if name not in NOT_RECORDED]
STEPS = {"one": (1, 1), "two": (2, 1), "eight": (8, 1), "third": (1, 3), "sixtieth": (5, 3)}


def step_size(step, period):
    numerator, denominator = STEPS[step]
    return numerator * period / denominator


@pytest.fixture(params=STEPS)
def step(request):
    return request.param


@pytest.fixture
def record(fixtures, step):
    path = fixtures / "plain_detector" / f"{step}.csv"
    assert path.is_file(), f"{path} is written by the Rust tests: run them first, as tests/run does"
    with path.open(encoding="utf-8") as file:
        names = file.readline().strip().split(",")
        table = np.loadtxt(file, delimiter=",")
    assert len(table) > 700
    return dict(zip(names, table.T, strict=True))


def assert_identical(found, record, names):
    for name in names:
        np.testing.assert_array_equal(found[name], record[name], err_msg=name)


def test_fmpy(detector, reference, record, step):
    with detector.instance() as instance:
        instance.initialise()
        inputs = {name: record[name] for name in INPUTS}
        found = instance.record(inputs, RESULTS, step_size(step, reference.period))
    assert_identical(found, record, RESULTS)
    assert record["alarm"].any() and not record["alarm"].all()


def test_libcosim(fixtures, reference, record, step):
    """libcosim of the Open Simulation Platform, with its FMI library in C: another importer."""
    from libcosimpy import CosimLogging
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    CosimLogging.log_output_level(CosimLogging.CosimLogLevel.ERROR)
    path = fixtures / "SteeringFaultDetector.fmu"
    variables = {v.name: v for v in read_model_description(str(path)).modelVariables}

    def references(names):
        return [variables[name].valueReference for name in names]

    # It counts time in whole nanoseconds: rounded down, every sample stays in its step.
    execution = CosimExecution.from_step_size(int(1e9 * step_size(step, reference.period) + 1e-3))
    slave = execution.add_local_slave(CosimLocalSlave(str(path), "detector"))
    manipulator = CosimManipulator.create_override()
    execution.add_manipulator(manipulator)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)

    reals = [name for name in RESULTS if variables[name].type == "Real"]
    booleans = [name for name in RESULTS if variables[name].type == "Boolean"]
    found = {name: [] for name in reals + booleans}  # it knows no enumerations: no `state`
    for row in zip(*(record[name] for name in INPUTS), strict=True):
        manipulator.slave_real_values(slave, references(INPUTS), list(row))
        assert execution.step()
        for name, value in zip(reals, observer.last_real_values(slave, references(reals))):
            found[name].append(value)
        for name, value in zip(booleans, observer.last_boolean_values(slave, references(booleans))):
            found[name].append(value)
    assert_identical(found, record, found)
