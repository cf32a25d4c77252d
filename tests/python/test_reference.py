"""docs/reference is what the sources and the command say, and names every key, variable, finding and exit code."""

import importlib.util
import re
import tomllib
from pathlib import Path
from xml.etree import ElementTree
from zipfile import ZipFile

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def writer():
    spec = importlib.util.spec_from_file_location("reference_pages", ROOT / "docs" / "site" / "reference.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def page(name):
    return (ROOT / "docs" / "reference" / name).read_text(encoding="utf-8")


def test_the_pages_are_current(writer, steerguard):
    for name, text in writer.pages(str(steerguard)).items():
        assert page(name) == text, f"docs/reference/{name}: run docs/site/reference.py target/release/steerguard"


def test_every_key_is_there():
    # The specification that `steerguard init` writes names each; packaging/tests/init.rs holds it complete.
    text = (ROOT / "packaging" / "assets" / "car.toml").read_text(encoding="utf-8")
    tables, found = {}, page("keys.md")
    table = None
    for line in text.splitlines():
        line = line.removeprefix("# ")
        if heading := re.match(r"\[\[?[a-z_.]+\]\]?(?=$| +#)", line):
            table = heading[0]
        elif key := re.match(r"(\w+) = ", line):
            tables.setdefault(table, set()).add(key[1])
    assert len(tables) > 10 and sum(map(len, tables.values())) > 60
    for table, keys in tables.items():
        section = found.split(f"## `{table}`\n")[1].split("\n## ")[0]
        missing = [key for key in keys if f"| `{key}` |" not in section]
        assert not missing, f"{table}: {missing}"
    # And one by one what a design says its whole specification is.
    assert tomllib.loads(text).keys() <= {re.sub(r"[\[\]]|\..*", "", table) for table in tables}


def test_every_variable_is_there(fixtures):
    found = page("variables.md")
    for name in ("SteeringFaultDetector", "VehiclePlant"):
        with ZipFile(fixtures / f"{name}.fmu") as archive:
            root = ElementTree.fromstring(archive.read("modelDescription.xml"))
        names = [variable.get("name") for variable in root.iter("ScalarVariable")]
        assert names and not [of for of in names if f"| `{of}` |" not in found]


def test_every_finding_and_exit_code_is_there():
    # Anything that a source of `check` writes as a code, however it comes into a finding.
    folders = [ROOT / "packaging" / "src" / "check", ROOT / "modelDescription" / "src" / "xml" / "lint"]
    found, codes = page("findings.md"), set()
    for path in (path for folder in folders for path in folder.rglob("*.rs")):
        text = path.read_text(encoding="utf-8")
        codes |= set(re.findall(r'code: "([^"]+)"', text))
        codes |= set(re.findall(r'\b(?:error|warning|note)\(\s*(?:&?[\w.]+,\s*)?"([a-z0-9-]+)",', text))
    assert len(codes) > 60
    assert not [code for code in codes if f"| `{code}` |" not in found]
    for code in (0, 1, 2):
        assert f"\n| {code} | " in page("command.md")
