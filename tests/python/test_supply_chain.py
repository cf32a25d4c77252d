"""What the project is built from: licences and sources, bills of materials, unsafe code."""

import hashlib
import json
import re
import subprocess
import tomllib
import zipfile
from pathlib import Path

import pytest
from imports import NOISE

ROOT = Path(__file__).parents[2]
MEMBERS = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))["workspace"]["members"]
POLICY = tomllib.loads((ROOT / "deny.toml").read_text(encoding="utf-8"))
LOCK = tomllib.loads((ROOT / "Cargo.lock").read_text(encoding="utf-8"))["package"]


def cargo(*arguments):
    line = ["cargo", *arguments, "--locked"]
    return subprocess.run(line, cwd=ROOT, check=True, capture_output=True, text=True).stdout


@pytest.fixture(scope="module")
def packages():
    """Those of others that are built for any platform, tests' importer of others aside."""
    data = json.loads(cargo("metadata", "--format-version", "1"))
    nodes = {node["id"]: node for node in data["resolve"]["nodes"]}
    by_id = {package["id"]: package for package in data["packages"]}
    excluded = set(POLICY["graph"]["exclude"])
    to_do = [member for member in data["workspace_members"] if by_id[member]["name"] not in excluded]
    reached = set()
    while to_do:
        node = to_do.pop()
        if node not in reached:
            reached.add(node)
            to_do += nodes[node]["dependencies"]
    return [by_id[node] for node in reached if by_id[node]["source"] is not None]


def allowed(expression, licences):
    """Whether an SPDX expression can be met by `licences`."""
    tokens = re.findall(r"\(|\)|[\w.+-]+(?: WITH [\w.-]+)?", expression.replace("/", " OR "))

    def term():
        token = tokens.pop(0)
        if token != "(":
            return token in licences
        value = any_of()
        assert tokens.pop(0) == ")"
        return value

    def all_of():
        value = term()
        while tokens and tokens[0] == "AND":
            tokens.pop(0)
            value &= term()
        return value

    def any_of():
        value = all_of()
        while tokens and tokens[0] == "OR":
            tokens.pop(0)
            value |= all_of()
        return value

    value = any_of()
    assert not tokens, expression
    return value


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("MIT", True),
        ("GPL-3.0", False),
        ("MIT OR GPL-3.0", True),
        ("MIT AND GPL-3.0", False),
        ("(MIT OR GPL-3.0) AND ISC", True),
        ("GPL-3.0 OR MIT AND Apache-2.0 WITH LLVM-exception", False),
        ("GPL-3.0/MIT", True),
    ],
)
def test_expressions_of_licences_are_understood(expression, expected):
    assert allowed(expression, {"MIT", "ISC"}) is expected


def test_licences_are_those_allowed(packages):
    exceptions = {row["crate"]: set(row["allow"]) for row in POLICY["licenses"]["exceptions"]}
    assert len(packages) > 100
    for package in packages:
        licences = set(POLICY["licenses"]["allow"]) | exceptions.get(package["name"], set())
        assert package["license"], package["name"]
        assert allowed(package["license"], licences), f"{package['name']}: {package['license']}"
    unused = set(exceptions) - {package["name"] for package in packages}
    assert not unused, "exceptions that nothing needs"


def test_sources_are_one_registry_and_nothing_is_banned(packages):
    [source] = {package["source"] for package in packages}
    assert source.startswith("registry+"), source
    banned = {row["crate"] for row in POLICY["bans"]["deny"]}
    assert not banned & {package["name"] for package in packages}


def test_every_package_is_locked_with_its_digest():
    for package in LOCK:
        assert ("checksum" in package) == ("source" in package), package["name"]


def linked(cdylib):
    """Names and versions of what a library links."""
    kinds = ["-e", "normal,no-proc-macro", "--prefix", "none", "--format", "{p}"]
    lines = cargo("tree", "-p", cdylib, *kinds).splitlines()
    return {tuple(line.replace(" v", " ").split()[:2]) for line in lines}


@pytest.mark.parametrize(
    ("file", "cdylib"),
    [
        ("SteeringFaultDetector.fmu", "steerguard-fmu-cdylib"),
        ("SteeringFaultDetector.fmi3.fmu", "steerguard-fmi3-cdylib"),
        ("VehiclePlant.fmu", "steerguard-plant-cdylib"),
    ],
)
def test_a_bill_names_what_the_library_links(fixtures, file, cdylib):
    with zipfile.ZipFile(fixtures / file) as fmu:
        bill = json.loads(fmu.read("documentation/sbom.cdx.json"))
    # What CycloneDX 1.6 requires.
    assert (bill["bomFormat"], bill["specVersion"]) == ("CycloneDX", "1.6")
    assert isinstance(bill["version"], int) and bill["version"] >= 1
    files = {c["name"]: c for c in bill["components"] if c["type"] == "file"}
    packages = [c for c in bill["components"] if c["type"] != "file"]
    components = [bill["metadata"]["component"], *packages]
    for component in components:
        assert component["type"] == "library" and component["name"]
        [licence] = component["licenses"]
        assert allowed(licence["expression"], {"MIT"})
        for digest in component.get("hashes", []):
            assert digest["alg"] == "SHA-256" and re.fullmatch("[0-9a-f]{64}", digest["content"])
    references = [component["bom-ref"] for component in components]
    assert len(set(references)) == len(references)
    [dependency] = bill["dependencies"]
    assert dependency["ref"] == references[0] and dependency["dependsOn"] == references[1:]
    # Nothing that differs from one packaging to the next.
    assert "serialNumber" not in bill and "timestamp" not in bill["metadata"]

    with zipfile.ZipFile(fixtures / file) as fmu:
        libraries = {name: fmu.read(name) for name in fmu.namelist() if name.startswith("binaries/")}
    assert libraries and files.keys() == libraries.keys()
    for name, library in libraries.items():
        [digest] = files[name]["hashes"]
        assert digest == {"alg": "SHA-256", "content": hashlib.sha256(library).hexdigest()}

    named = {(c["name"], c["version"]) for c in packages if c["name"] != "core"}
    assert named == linked(cdylib)
    digests = {(p["name"], p["version"]): p.get("checksum") for p in LOCK}
    with zipfile.ZipFile(fixtures / file) as fmu:
        texts = {Path(name).stem for name in fmu.namelist() if "/licenses/" in name}
    for component in packages:
        if component["name"] == "core":
            continue
        [digest] = [d["content"] for d in component.get("hashes", [])] or [None]
        assert digest == digests[component["name"], component["version"]]
        if "purl" in component:
            assert component["purl"] == f"pkg:cargo/{component['name']}@{component['version']}"
            assert component["name"].split("-")[0] in texts, "its licence comes with it"


def unsafe(member):
    """Numbers of unsafe blocks and functions in a crate, tests aside."""
    blocks = functions = 0
    for path in (ROOT / member / "src").rglob("*.rs"):
        if "tests" in path.parts or path.name == "tests.rs":
            continue
        text = NOISE.sub(" ", path.read_text(encoding="utf-8"))
        blocks += len(re.findall(r"\bunsafe \{", text))
        functions += len(re.findall(r"\bunsafe (?:extern\s+)?fn \w", text))
    return blocks, functions


def test_unsafe_code_is_where_the_table_says():
    rows = re.findall(r"^\| `([\w/-]+)` \| (\d+) \| (\d+) \|", (ROOT / "docs" / "unsafe.md").read_text(), re.M)
    stated = {member: (int(blocks), int(functions)) for member, blocks, functions in rows}
    product = [member for member in MEMBERS if not member.startswith("tests/")]
    found = {member: unsafe(member) for member in product}
    assert stated == {member: count for member, count in found.items() if count != (0, 0)}
