"""Every figure of the reference cases is held against something."""

from pathlib import Path

import pytest
from cases import FOLDER, Case

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def tests_text():
    """Text of all tests, in Rust and Python."""
    folders = ["detector/tests", "designer/tests", "packaging/tests", "tests/python"]
    paths = [path for folder in folders for path in (ROOT / folder).rglob("*.[rp][sy]")]
    return "".join(path.read_text(encoding="utf-8") for path in paths)


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.toml")), ids=lambda path: path.stem)
def test_every_figure_is_used(path, tests_text):
    case = Case(path.stem)
    for figure in case.data["expected"]:
        # Of figures at several speeds the tests put the name together.
        name = figure.partition("_at_")[0] if path.stem == "model" else f'"{figure}"'
        assert name in tests_text, f"{path.name}: {figure} is read by no test"
