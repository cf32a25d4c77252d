"""The checks of the FMU Manipulation Toolbox: the standard's XML schema, and its rules on variables."""

import subprocess
import sys

import pytest


@pytest.mark.parametrize("name", ["SteeringFaultDetector", "VehiclePlant"])
def test_check_finds_nothing(fixtures, tmp_path, name):
    code = "from fmu_manipulation_toolbox.cli.fmutool import fmutool; fmutool()"
    result = subprocess.run(
        [sys.executable, "-c", code, "-input", fixtures / f"{name}.fmu", "-check"],
        capture_output=True, text=True, timeout=300, check=False, cwd=tmp_path,
    )  # fmt: skip
    report = result.stdout + result.stderr
    assert result.returncode == 0, report
    assert "compliant with FMI-2.0" in report and "No semantic error" in report, report
    assert "ERROR" not in report and "WARNING" not in report, report
