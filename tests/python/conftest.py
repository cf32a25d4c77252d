"""The packaged FMUs and their design, from the folder that tests/run names."""

import json
import os
import subprocess
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


# Every deviation that the detector knows, every limit of the actuator and both zeros, on the method that
# designs in seconds.
EVERYTHING = """
[vehicle]
centre_of_gravity_height_m = 0.6

[operating_range]
v_x_m_per_s = [5.0, 30.0]
v_y_m_per_s = [-1.5, 1.5]
r_rad_per_s = [-0.55, 0.55]

[sensors]
steering_offset_deg = 0.4
yaw_rate_bias_deg_per_s = -0.3

[actuator]
lag_s = 0.06
delay_s = 0.033
rate_limit_rad_per_s = 0.3
angle_limit_deg = 2.5

[uncertainty]
actuator_lag_s = 0.02
actuator_delay_s = 0.015
steering_ratio_percent = [-2.0, 3.0]
steering_offset_deg = 0.2
yaw_rate_bias_deg_per_s = 0.1
v_x_scale_percent = 1.0
friction = [0.5, 1.0]
front_cornering_stiffness_percent = [-25.0, 20.0]
rear_cornering_stiffness_percent = [-30.0, 10.0]    # reference motions are drawn from 23 m/s on

[design]
method = "paper"

[evaluation]
debounce_samples = 2
alarm_hold_s = 0.5

[evaluation.calibration]
speeds = 3
manoeuvres = ["straight", "weave"]
lateral_acceleration_m_per_s2 = [0.2, 0.4]
duration_s = 4.0
search_drives = 0
"""


@pytest.fixture(scope="session")
def everything(steerguard, tmp_path_factory):
    """Detector and reference of a design in which every deviation acts."""
    return made(steerguard, tmp_path_factory.mktemp("everything"), EVERYTHING)


@pytest.fixture(scope="session", params=["few", "everything"])
def with_second_test(request, steerguard, tmp_path_factory):
    """Detector and reference of designs with the second test: of the usual uncertainties, of every one."""
    few = EVERYTHING[EVERYTHING.index("[operating_range]") : EVERYTHING.index("[sensors]")]
    text = few + EVERYTHING[EVERYTHING.index("[design]") :] if request.param == "few" else EVERYTHING
    return made(steerguard, tmp_path_factory.mktemp("second"), text + "\n[estimator]\nenabled = true\n")


def made(steerguard, folder, specification):
    """Detector and reference of a specification."""
    spec, design, fmu = (folder / f"made.{kind}" for kind in ("toml", "json", "fmu"))
    spec.write_text(specification, encoding="utf-8")
    # With so much uncertain it may be blind, which is an answer too.
    done = subprocess.run([steerguard, "design", spec, "-o", design], check=False, capture_output=True, text=True)
    assert done.returncode in (0, 1) and design.exists(), done.stderr
    package = ["package", design, "--allow", "uncertified,blind", "-o", fmu]
    subprocess.run([steerguard, *package], check=True, capture_output=True)
    return Fmu(fmu, folder / "fmu"), Reference(json.loads(design.read_text(encoding="utf-8")))


@pytest.fixture(scope="session")
def plant(fixtures, tmp_path_factory):
    return Fmu(fixtures / "VehiclePlant.fmu", tmp_path_factory.mktemp("plant"))
