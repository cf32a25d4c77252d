"""Reference cases of tests/cases, which tests in Rust read too (tests/support/src/cases.rs).

Each expected figure has a value with an `absolute` or `relative` tolerance, or limits `at_least` and
`at_most`; units are in its name.
"""

import math
import tomllib
from pathlib import Path

FOLDER = Path(__file__).parents[1] / "cases"


class Case:
    """A reference case by its name."""

    def __init__(self, name):
        self.data = tomllib.loads((FOLDER / f"{name}.toml").read_text(encoding="utf-8"))

    def limits(self, figure):
        """Smallest and largest value of `figure` that agrees."""
        match self.data["expected"][figure]:
            case {"value": value, "absolute": tolerance}:
                return value - tolerance, value + tolerance
            case {"value": value, "relative": tolerance}:
                return value - tolerance * abs(value), value + tolerance * abs(value)
            case limits:
                return limits.get("at_least", -math.inf), limits.get("at_most", math.inf)

    def check(self, figure, value):
        """Holds `value` against what the case expects of `figure`."""
        least, most = self.limits(figure)
        assert least <= value <= most, f"{figure} = {value}, expected {least} to {most}"
