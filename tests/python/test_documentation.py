"""The documentation: the site builds without a warning and its links lead somewhere; what its pages show runs."""

import os
import re
import shlex
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import scenario
from signals import INPUTS

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def blocks(path, *languages):
    """Fenced blocks of these languages."""
    text = path.read_text(encoding="utf-8")
    return [body for language, body in re.findall(r"```(\w+)\n(.*?)```", text, flags=re.DOTALL) if language in languages]


def test_the_site_builds_without_a_warning_and_its_links_lead_somewhere():
    build = subprocess.run([ROOT / "docs" / "site" / "build"], capture_output=True, text=True, timeout=300)
    assert build.returncode == 0, build.stdout + build.stderr
    assert re.search(r"docs: [1-9]\d+ pages, \d+ links", build.stdout)
    site = Path(os.environ["CARGO_TARGET_DIR"], "docs", "site")
    assert "<math" in (site / "method" / "3-observer.html").read_text(encoding="utf-8")


def commands(path):
    text = "\n".join(blocks(path, "sh", "console")).replace("\\\n", " ")
    lines = [line.strip().removeprefix("$ ") for line in text.splitlines()]
    return [shlex.split(line, comments=True) for line in lines if line.startswith("steerguard ")]


def test_commands_on_pages_have_the_arguments_that_they_are_given(steerguard):
    """What takes minutes to run is at least what the command understands; whole runs: test_from_log_to_fmu.py."""
    known, seen = {}, 0
    for path in PAGES:
        for line in commands(path):
            name = next((word for word in line[1:] if not word.startswith("-")), None)
            if name not in known:
                run = subprocess.run([steerguard, *filter(None, [name]), "--help"], capture_output=True, text=True)
                assert run.returncode == 0, f"{path}: {shlex.join(line)}\n{run.stderr}"
                known[name] = run.stdout
            for word in line[1:]:
                if word.startswith("-"):
                    flag = word.split("=")[0]
                    assert re.search(rf"(?<![\w-]){re.escape(flag)}(?![\w-])", known[name]), f"{path}: {shlex.join(line)}"
            seen += 1
    assert seen > 20


def test_what_init_begins_is_what_the_start_says(steerguard, tmp_path):
    line = next(line for line in commands(ROOT / "docs" / "index.md") if line[1] == "init")
    run = subprocess.run([steerguard, *line[1:]], cwd=tmp_path, capture_output=True, text=True)
    assert run.returncode == 0 and "steerguard design car.toml" in run.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["car.toml"]


@pytest.fixture(scope="module")
def inputs(plant, detector, reference):
    record = scenario.drive(plant, detector, 15.0, reference.period)
    table = np.zeros(len(record["time"]), dtype=[(name, float) for name in ["time", *INPUTS]])
    for name in table.dtype.names:
        table[name] = record[name]
    return table


def test_the_wiring_runs_as_it_is_shown(inputs, fixtures, tmp_path, monkeypatch, capsys):
    shutil.copy(fixtures / "SteeringFaultDetector.fmu", tmp_path)
    monkeypatch.chdir(tmp_path)
    fmpy, libcosim = blocks(ROOT / "docs" / "wiring.md", "python")
    exec(fmpy, {"inputs": inputs})  # noqa: S102
    first = float(re.search(r"\[(.*)\]", capsys.readouterr().out)[1])
    assert scenario.FAULT_ONSET_S < first < scenario.FAULT_ONSET_S + 0.2
    shown = {}
    exec(libcosim, shown)  # noqa: S102
    assert shown["execution"].step()
