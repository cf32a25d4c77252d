"""docs/checks.md holds every code of `steerguard check`, and a test makes each of them."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = ("packaging/src/check/*.rs", "modelDescription/src/xml/**/*.rs")
TESTS = ("packaging/tests/*.rs", "packaging/src/check/*.rs", "modelDescription/tests/**/*.rs",
         "modelDescription/src/xml/lint/*.rs")

# A code as it is handed to a finding: behind the element it is about, first, or as a field.
WRITTEN = re.compile(
    r'(?:\.(?:error|warning|note)\(\s*(?:&?\w+,\s*)?|code: |Level::\w+, (?:&?\w+, )?'
    r'|BakedError::\w+ => |\(\s*findings,\s*)"([a-z][a-z0-9-]*)"'
)
ELSEWHERE = re.compile(r'"((?:empty|start)-[a-z-]+)"')


def texts(patterns):
    return [path.read_text() for pattern in patterns for path in sorted(ROOT.glob(pattern))]


def codes():
    found = set()
    for text in texts(SOURCES):
        text = text.split("#[cfg(test)]")[0]
        found |= set(WRITTEN.findall(text)) | set(ELSEWHERE.findall(text))
    return found


def documented():
    return re.findall(r"^\| `([a-z0-9-]+)` \|", (ROOT / "docs/checks.md").read_text(), re.MULTILINE)


def test_each_code_is_documented_once_and_no_other():
    names = documented()
    assert len(names) == len(set(names))
    assert sorted(names) == sorted(codes())


@pytest.mark.parametrize("code", documented())
def test_each_code_has_an_example(code):
    tests = [text.split("#[cfg(test)]")[-1] for text in texts(TESTS)
             if "#[cfg(test)]" in text or "#[test]" in text]
    named = re.compile(rf'(?:error |warning |note |"){code}(?![a-z-])')
    assert any(named.search(text) for text in tests)


def test_each_row_says_what_why_and_what_to_do():
    rows = [line for line in (ROOT / "docs/checks.md").read_text().splitlines()
            if line.startswith("| `")]
    for row in rows:
        cells = [cell.strip() for cell in row.strip("|").split("|")]
        assert len(cells) == 4 and all(cells), row
