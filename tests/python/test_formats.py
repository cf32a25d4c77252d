"""docs/formats.md says how anyone can check the hash of a design; its words are run here."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DESIGNS = sorted(path.name for path in (ROOT / "designer/verify/tests/fixtures").glob("*.json"))


@pytest.fixture(scope="module")
def check(tmp_path_factory):
    """Runs the document's program on a file."""
    text = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")
    [program] = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    path = tmp_path_factory.mktemp("formats") / "check.py"
    path.write_text(program, encoding="utf-8")
    return lambda file: subprocess.run([sys.executable, path, file], capture_output=True, text=True)


@pytest.mark.parametrize("name", DESIGNS)
def test_hash_is_that_of_the_document(check, name):
    done = check(ROOT / "designer/verify/tests/fixtures" / name)
    assert (done.returncode, done.stderr) == (0, "")


def test_hash_of_a_new_design(check, fixtures):
    assert check(fixtures / "design.json").returncode == 0


def test_document_and_command_agree_on_what_changes_a_design(check, steerguard, fixtures, tmp_path):
    text = (fixtures / "design.json").read_text(encoding="utf-8")
    design = json.loads(text)
    evaluation = design["detector"]["evaluation"]

    def both(content):
        """Whether the document's program and the command take the content for the design."""
        file = tmp_path / "design.json"
        file.write_text(content, encoding="utf-8")
        verified = subprocess.run([steerguard, "verify", file], capture_output=True, text=True)
        return check(file).returncode == 0, "hash" not in verified.stderr

    assert both(json.dumps(dict(reversed(design.items())), indent=7)) == (True, True)
    window = evaluation["window"]
    evaluation["window"] = float(window)
    assert design["B"][0][1] == 0
    design["B"][0][1] = -0.0
    same = json.dumps(design)
    assert "-0.0" in same
    assert both(same) == (True, True)
    evaluation["window"] = window + 1
    assert both(json.dumps(design)) == (False, False)
    evaluation["window"] = window
    evaluation["weights"][0] *= 1 + 2**-52
    assert both(json.dumps(design)) == (False, False)


def test_document_names_every_key(design):
    text = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")

    def keys(value):
        if isinstance(value, dict):
            for key, inner in value.items():
                yield key
                yield from keys(inner)

    # Vehicle data go by their names in the specification.
    model = dict(design["detector"]["model"], vehicle={})
    named = {*design, *keys(dict(design["detector"], model=model))}
    named |= {key for section in ("constants", "threshold", "performance") for key in design[section]}
    assert {key for key in named if not re.search(rf"\b{re.escape(key)}\b", text)} == set()
