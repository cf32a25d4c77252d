"""The packaged FMUs and their design, from the folder that tests/run names."""

import json
import os
from pathlib import Path

import pytest
from fmu import Fmu
from reference import Reference


FIXTURES = "STEERGUARD_FIXTURES"


def pytest_sessionstart():
    if FIXTURES not in os.environ:
        raise pytest.UsageError(f"{FIXTURES} names the folder of the packaged FMUs; tests/run sets it")


@pytest.fixture(scope="session")
def fixtures():
    """Folder with SteeringFaultDetector.fmu, VehiclePlant.fmu and design.json."""
    return Path(os.environ[FIXTURES])


@pytest.fixture(scope="session")
def steerguard():
    """Path of the command."""
    return Path(os.environ["CARGO_TARGET_DIR"], "release", "steerguard")


@pytest.fixture(scope="session")
def design(fixtures):
    return json.loads((fixtures / "design.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def reference(design):
    return Reference(design)


@pytest.fixture(scope="session")
def detector(fixtures, tmp_path_factory):
    return Fmu(fixtures / "SteeringFaultDetector.fmu", tmp_path_factory.mktemp("detector"))


@pytest.fixture(scope="session", params=["compact", "van"])
def example(request, fixtures, tmp_path_factory):
    """Detector and reference of examples with adaptive thresholds and corrected Euler steps."""
    name = request.param
    text = (fixtures / "examples" / f"{name}.json").read_text(encoding="utf-8")
    fmu = Fmu(fixtures / "examples" / f"{name}.fmu", tmp_path_factory.mktemp(name))
    return fmu, Reference(json.loads(text))


@pytest.fixture(scope="session")
def plant(fixtures, tmp_path_factory):
    return Fmu(fixtures / "VehiclePlant.fmu", tmp_path_factory.mktemp("plant"))
