"""The archives as an importer finds them."""

import subprocess
import sys

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

NAMES = ["SteeringFaultDetector", "VehiclePlant"]


def run_fmpy(*arguments):
    """`python -m fmpy ...`."""
    command = [sys.executable, "-m", "fmpy", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


@pytest.mark.parametrize("name", NAMES)
def test_fmpy_finds_nothing(fixtures, name):
    path = fixtures / f"{name}.fmu"
    assert validate_fmu(str(path)) == []
    result = run_fmpy("validate", path)
    assert result.returncode == 0 and "No problems found" in result.stdout, result.stdout


@pytest.mark.parametrize("name", NAMES)
def test_fmpy_simulates_with_defaults(fixtures, tmp_path, name):
    csv = tmp_path / "out.csv"
    result = run_fmpy("simulate", fixtures / f"{name}.fmu", "--output-file", csv)
    assert result.returncode == 0, result.stderr
    table = np.genfromtxt(csv, delimiter=",", names=True, dtype=None)
    assert len(table) > 100
    outputs = fmpy.read_model_description(str(fixtures / f"{name}.fmu")).outputs
    assert len(table.dtype.names) == 1 + len(outputs)
    for column in table.dtype.names:
        assert np.isfinite(table[column].astype(float)).all(), column


@pytest.mark.parametrize("name", NAMES)
def test_interface_is_what_the_description_says(fixtures, name):
    description = fmpy.read_model_description(str(fixtures / f"{name}.fmu"))
    assert (description.fmiVersion, description.modelName) == ("2.0", name)
    assert description.coSimulation is not None and description.modelExchange is None
    capabilities = description.coSimulation
    assert capabilities.canHandleVariableCommunicationStepSize
    assert capabilities.canGetAndSetFMUstate and capabilities.canSerializeFMUstate
    references = [v.valueReference for v in description.modelVariables]
    assert len(references) == len(set(references)), "unique over all types"


def test_constants_are_those_of_the_design(detector, design):
    with detector.instance() as instance:
        instance.initialise()
        found = instance.get(
            ["design.hash", "design.sample_period", "design.window", "design.threshold"]
        )
    model, evaluation = design["detector"]["model"], design["detector"]["evaluation"]
    assert found["design.hash"].decode() == design["hash"]
    assert found["design.sample_period"] == model["sampling_period_s"]
    assert found["design.window"] == evaluation["window"]
    assert found["design.threshold"] == evaluation["threshold"]


@pytest.mark.parametrize("name", NAMES)
def test_types_platform_and_version(request, name):
    fmu = request.getfixturevalue({"SteeringFaultDetector": "detector", "VehiclePlant": "plant"}[name])
    with fmu.instance() as instance:
        assert (instance.getTypesPlatform(), instance.getVersion()) == ("default", "2.0")
