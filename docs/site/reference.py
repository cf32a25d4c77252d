"""The pages of docs/reference, from the sources and from what the command says of itself.

    docs/site/reference.py STEERGUARD [--check]

STEERGUARD is the command of this build. Keys and their meaning are the docstrings of designer/src/spec, what is
allowed and what holds for a key left out are the words in which the command refuses an impossible value; variables
are those of a packaged FMU, findings those of the sources of `steerguard check`, what `--json` prints is its own schemas.
"""

import functools
import json
import os
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = ROOT / "docs" / "reference"
SPEC = ROOT / "designer" / "src" / "spec"
STORED = ROOT / "designer" / "verify" / "tests" / "fixtures" / "paper.json"
CHECKS = [ROOT / "packaging" / "src" / "check", ROOT / "modelDescription" / "src" / "xml" / "lint"]
# Tables of a specification, in its order: heading, file, and what their keys are called by the command.
TABLES = [
    ("[vehicle]", "../../../detector/src/vehicle", "Vehicle"),
    ("[operating_range]", "operating_range", "OperatingRangeTable"),
    ("[sampling]", "sampling", "Sampling"),
    ("[sensors]", "sensors", "SensorsTable"),
    ("[actuator]", "actuator", "ActuatorTable"),
    ("[[fault]]", "fault", "Fault"),
    ("[[disturbance]]", "disturbance", "Disturbance"),
    ("[noise.v_x]", "noise", "SpeedNoise"),
    ("[noise.r]", "noise", "YawRateNoise"),
    ("[uncertainty]", "uncertainty", "UncertaintyTable"),
    ("[design]", "design", "Method"),
    ("[evaluation]", "evaluation", "Evaluation"),
    ("[evaluation.calibration]", "calibration", "Calibration"),
    ("[estimator]", "estimator", "EstimatorTable"),
]
# Where one of several kinds stands, what each needs beside the key that is asked for.
KINDS = {
    "Steering": 'channel = "steering"\n',
    "Torque": 'channel = "torque"\nsmallest_n_m = 200.0\n',
    "SideWind": 'name = "d"\nkind = "side_wind"\nbound_m_per_s2 = 0.1\n',
    "Bank": 'name = "d"\nkind = "bank"\nbound_deg = 1.0\n',
    "YawMoment": 'name = "d"\nkind = "yaw_moment"\nbound_n_m = 100.0\n',
    "Direction": 'name = "d"\nkind = "direction"\ndirection = [0.0, 1.0, 0.0]\nbound = 0.1\n',
}
UNITS = [
    ("_n_m_s2_per_m2", "N m s²/m²"), ("_n_s2_per_m2", "N s²/m²"), ("_kg_m2", "kg m²"), ("_kg_m", "kg m"),
    ("_n_per_rad", "N/rad"), ("_deg_per_s", "°/s"), ("_rad_per_s", "rad/s"), ("_m_per_s2", "m/s²"),
    ("_m_per_s", "m/s"), ("_per_rad", "1/rad"), ("_per_s", "1/s"), ("_n_m", "N m"), ("_percent", "%"), ("_deg", "°"),
    ("_kg", "kg"), ("_m2", "m²"), ("_hz", "Hz"), ("_samples", "samples"), ("_m", "m"), ("_s", "s"),
]  # fmt: skip
GENERATED = "<!-- Made by docs/site/reference.py: change the sources that it reads. -->\n\n"


def unit(key):
    return next((unit for end, unit in UNITS if key.endswith(end)), "")


def cell(text):
    return " ".join(text.split()).replace("|", "\\|")


def links_as_code(text):
    """Links of Rust's documentation as code."""
    return re.sub(r"\[(`[^`]+`)\]", r"\1", text)


def fields(text, item):
    """(kind or None, key, docstring) of a struct's or an enum's fields, as they are written."""
    body = re.search(rf"(?:struct|enum) {item} \{{\n(.*?)\n\}}", text, flags=re.DOTALL)[1]
    kind, doc, key = None, [], None
    for line in map(str.strip, body.splitlines()):
        if line.startswith("///"):
            doc.append(line[3:].strip())
        elif renamed := re.search(r'#\[serde\(.*rename = "(\w+)"', line):
            key = renamed[1]
        elif variant := re.fullmatch(r"([A-Z]\w+) \{", line):
            kind, doc = variant[1], []
        elif field := re.match(r"(?:pub )?(\w+): ", line):
            if key or field[1] not in ("calibration",):
                yield kind, key or field[1], " ".join(doc)
            doc, key = [], None


def refusals(steerguard, folder, table, kind, key):
    """What the command says to impossible values: what is allowed, and what it is when left out."""
    allowed = left_out = ""
    path = table.strip("[]").replace("[", "")
    for value in ("1e99", "-1e99", "4000000000", "[1e99, -1e99]", '"?"', "{}"):
        needed = KINDS.get(kind, "")
        needed = re.sub(rf"^{key} = .*\n", "", needed, flags=re.MULTILINE)
        # Impossible beside, so that nothing is ever designed.
        other = "" if path == "sampling" else "[sampling]\nperiod_s = 1e99\n"
        spec = folder / "spec.toml"
        spec.write_text(f"{other}{table}\n{needed}{key} = {value}\n", encoding="utf-8")
        command = [steerguard, "--json", "design", spec, "-o", folder / "no.json"]
        run = subprocess.run(command, capture_output=True, text=True, timeout=60)
        if run.returncode != 2:
            continue
        for found in json.loads(run.stderr)["diagnostics"]:
            if not re.search(rf"[`.]{key}`", found["message"]):
                continue
            for label in found["labels"]:
                if label["text"].startswith("allowed is "):
                    allowed = allowed or label["text"].removeprefix("allowed is ")
            for note in found["notes"]:
                if note.startswith("left out, it is "):
                    left_out = left_out or note.removeprefix("left out, it is ")
        if allowed:
            break
    return allowed, left_out


def keys(steerguard, folder):
    lines = [
        "# Keys of the specification", "",
        "A specification is a TOML file; `steerguard init` writes one that explains every key. Each key may be left",
        "out, but for those that say \"needed\". Unknown keys and impossible values are refused by name and line.", "",
    ]  # fmt: skip
    for table, file, item in TABLES:
        lines += [f"## `{table}`", "", "| key | unit | allowed | left out | meaning |", "|---|---|---|---|---|"]
        for kind, key, doc in fields((SPEC / f"{file}.rs").read_text(encoding="utf-8"), item):
            allowed, left_out = refusals(steerguard, folder, table, kind, key)
            doc = links_as_code(doc)
            meaning, _, said = doc.partition("; default ")
            default = f"`{left_out}`" if left_out else said.split(". ")[0].rstrip(".")
            meaning = meaning.rstrip(".") + (". " + said.split(". ", 1)[1] if ". " in said else "")
            if kind:
                meaning = f"({re.sub('(?<!^)(?=[A-Z])', '_', kind).lower()}) {meaning}"
                default = default or ("" if said else "needed")
            row = [f"`{key}`", unit(key), allowed, default, meaning]
            lines.append("| " + " | ".join(map(cell, row)) + " |")
        if item in ("Fault", "Disturbance"):
            key = {"Fault": "channel", "Disturbance": "kind"}[item]
            text = (SPEC / f"{file}.rs").read_text(encoding="utf-8")
            names = dict.fromkeys(kind for kind, _, _ in fields(text, item))
            values = ", ".join(f'"{re.sub("(?<!^)(?=[A-Z])", "_", name).lower()}"' for name in names)
            lines.append(f"| `{key}` |  | {values} | needed | Which of these it is: the keys with its name belong to it |")
        lines.append("")
    return "\n".join(lines)


def variables(steerguard, folder):
    fmus = folder / "D.fmu", folder / "P.fmu"
    command = [steerguard, "package", STORED, "-o", fmus[0], "--plant", fmus[1]]
    subprocess.run(command, check=True, capture_output=True)
    lines = ["# Variables of the FMUs", "", "As `modelDescription.xml` of FMI 2.0 has them; in FMI 3.0 see",
             "[FMI 3.0](../fmi3.md). Start values are those of the paper's design.", ""]  # fmt: skip
    for fmu in fmus:
        with zipfile.ZipFile(fmu) as archive:
            root = ElementTree.fromstring(archive.read("modelDescription.xml"))
        lines += [f"## {root.get('modelName')}", "", root.get("description", ""), ""]
        lines += ["| name | reference | causality, variability | type, unit | start | range | meaning |", "|" + "---|" * 7]
        for variable in root.iter("ScalarVariable"):
            kind = variable[0]
            ends = [kind.get("min"), kind.get("max")]
            span = " to ".join(end or "…" for end in ends) if any(ends) else ""
            name = kind.get("declaredType") or kind.tag
            # Digests and numbers that are another for each design say nothing here.
            start = "" if variable.get("variability") == "constant" else kind.get("start", "")
            row = [f"`{variable.get('name')}`", variable.get("valueReference"),
                   f"{variable.get('causality')}, {variable.get('variability')}",
                   " ".join(filter(None, [name, kind.get("unit")])), start, span,
                   variable.get("description", "")]  # fmt: skip
            lines.append("| " + " | ".join(map(cell, row)) + " |")
        lines.append("")
        types = [of for of in root.iter("SimpleType") if of.find("Enumeration") is not None]
        for of in types:
            lines += [f"### {of.get('name')}", "", of.get("description", ""), "", "| value | item | meaning |", "|---|---|---|"]
            for item in of.iter("Item"):
                row = [item.get("value"), f"`{item.get('name')}`", item.get("description", "")]
                lines.append("| " + " | ".join(map(cell, row)) + " |")
            lines.append("")
    return "\n".join(lines)


def sources(folders):
    for folder in folders:
        for path in sorted(folder.rglob("*.rs")):
            yield path.read_text(encoding="utf-8").split("#[cfg(test)]")[0]


def codes():
    """Codes of findings with their levels."""
    found = {}
    string = r'"([a-z0-9]+(?:-[a-z0-9]+)*)"'
    plain = rf"\b(?:(error|warning|note)\(\s*(?:&?[\w.]+,\s*)?{string},)"
    for text in sources(CHECKS):
        for level, code in re.findall(plain, text):
            found.setdefault(code, set()).add(level)
        for code, level in re.findall(rf"\bcode: {string},\s*level: Level::(\w+)", text):
            found.setdefault(code, set()).add(level.lower())
        # Codes that stand in a list of those that a loop reports.
        for listed, level in re.findall(r"for \(\w+, code\) in \[(.*?)\] \{.*?\.(error|warning|note)\(", text, flags=re.DOTALL):
            for code in re.findall(rf"{string}\)", listed):
                found.setdefault(code, set()).add(level)
        # Codes that stand elsewhere in a table, or go through a function that adds them.
        for code in re.findall(r'"([a-z0-9]+(?:-[a-z0-9]+)+)"', text):
            found.setdefault(code, set())
    return {code: levels for code, levels in sorted(found.items()) if not code.startswith(("x86-", "utf-", "iso-"))}


def findings(_steerguard, _folder):
    lines = ["# Findings of `steerguard check`", "",
             "Each finding has a code, a level, the place and what to do. An `error` is against the standard, a `warning`",
             "is what importers may stumble over, a `note` could be better. Exit code 1 where there is an error.", "",
             "| code | level |", "|---|---|"]  # fmt: skip
    if (ROOT / "docs" / "checks.md").exists():
        lines[6:6] = ["[Checks](../checks.md) says of each what it means and what to do.", ""]
    lines += [f"| `{code}` | {', '.join(sorted(levels)) or 'as the case is'} |" for code, levels in codes().items()]
    return "\n".join(lines) + "\n"


def exits():
    text = (ROOT / "packaging" / "src" / "cli" / "failure.rs").read_text(encoding="utf-8")
    body = re.search(r"pub enum Exit \{\n(.*?)\n\}", text, flags=re.DOTALL)[1]
    meanings = {name: doc for doc, name in re.findall(r"/// (.*)\n\s+(\w+),", body)}
    numbers = {name: number for name, number in re.findall(r"Exit::(\w+) => (\d+)", text)}
    assert meanings.keys() == numbers.keys()
    return [(number, meanings[name]) for name, number in numbers.items()]


def helps(steerguard, *command):
    width = {name: value for name, value in os.environ.items() if name != "COLUMNS"}
    run = subprocess.run([steerguard, *command, "--help"], capture_output=True, text=True, check=True, env=width)
    return "\n".join(line.rstrip() for line in run.stdout.splitlines())


def commands(steerguard, _folder):
    text = helps(steerguard)
    names = re.findall(r"^  ([a-z]+) {2,}", re.search(r"Commands:\n(.*?)\n\n", text, flags=re.DOTALL)[1], flags=re.MULTILINE)
    lines = ["# The command", "", "## Exit codes", "", "| code | meaning |", "|---|---|"]
    lines += [f"| {number} | {cell(meaning)} |" for number, meaning in exits()]
    for title, words in [("steerguard", ()), *((f"steerguard {name}", (name,)) for name in names if name != "help")]:
        lines += ["", f"## `{title}`", "", "```text", helps(steerguard, *words), "```"]
    return "\n".join(lines) + "\n"


def schemas(steerguard):
    """The JSON Schemas of what is printed, by name, as the command prints them."""
    names = re.findall(r"^ +- ([a-z-]+): ", helps(steerguard, "schema"), flags=re.MULTILINE)
    run = functools.partial(subprocess.run, capture_output=True, text=True, check=True)
    return {name: run([steerguard, "schema", name]).stdout for name in names}


def rows(schema, root, path=""):
    """(path, type, meaning) of every key below a schema; what an array holds has the path of the array with []."""
    if "$ref" in schema:
        schema = {**root["$defs"][schema["$ref"].rsplit("/", 1)[1]], **{k: v for k, v in schema.items() if k != "$ref"}}
    if path:
        yield path, kind(schema, root), schema.get("description", "")
    for key, inner in schema.get("properties", {}).items():
        yield from rows(inner, root, f"{path}.{key}" if path else key)
    for part in [*schema.get("anyOf", []), *schema.get("oneOf", [])]:
        yield from list(rows(part, root, path))[1:]
    for inner, mark in ((schema.get("items"), "[]"), (schema.get("additionalProperties"), ".*")):
        if isinstance(inner, dict):
            yield from list(rows(inner, root, path + mark))[1:]


def kind(schema, root):
    """The type of a value in words."""
    if "$ref" in schema:
        return kind(root["$defs"][schema["$ref"].rsplit("/", 1)[1]], root)
    if "const" in schema:
        return f'"{schema["const"]}"'
    if "enum" in schema:
        return " or ".join(f'"{value}"' for value in schema["enum"])
    if parts := [*schema.get("anyOf", []), *schema.get("oneOf", [])]:
        return " or ".join(dict.fromkeys(kind(part, root) for part in parts))
    types = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
    if "array" in types and "items" in schema:
        count = f" of {schema['minItems']}" if schema.get("minItems") else ""
        types = [f"array{count}: {kind(schema['items'], root)}" if of == "array" else of for of in types]
    return " or ".join(types)


def printed(steerguard, _folder):
    lines = ["# What `--json` prints", "",
             "With `--json` a command prints one JSON value on the standard output; where it cannot do what was asked, one",
             "on the standard error output. Each has a JSON Schema (draft 2020-12), which `steerguard schema WHAT` prints.",
             "Later versions may print more keys; those that are there keep name, unit and meaning. In a path, `[]` is each",
             "value of an array and `*` each key of an object.", ""]  # fmt: skip
    for name, text in schemas(steerguard).items():
        root = json.loads(text)
        lines += [f"## {root['title']}", "", f"{root['description']} Schema: [`{name}`](schemas/{name}.json).", ""]
        lines += ["| key | type | unit | meaning |", "|---|---|---|---|"]
        for path, of, meaning in rows(root, root):
            row = [f"`{path}`", of, unit(path), meaning]
            lines.append("| " + " | ".join(map(cell, row)) + " |")
        lines.append("")
    return "\n".join(lines)


WRITERS = {
    "keys.md": keys, "variables.md": variables, "findings.md": findings, "command.md": commands, "json.md": printed,
}  # fmt: skip


def pages(steerguard):
    """Text of each page, and of each schema, by its name."""
    with tempfile.TemporaryDirectory() as folder:
        made = {name: GENERATED + make(steerguard, Path(folder)).rstrip() + "\n" for name, make in WRITERS.items()}
    return made | {f"schemas/{name}.json": text for name, text in schemas(steerguard).items()}


def main():
    arguments = [argument for argument in sys.argv[1:] if argument != "--check"]
    if len(arguments) != 1:
        sys.exit(__doc__)
    stale = []
    for name, text in pages(str(Path(arguments[0]).resolve())).items():
        path = PAGES / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            stale.append(name)
            if "--check" not in sys.argv:
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text, encoding="utf-8")
    if stale and "--check" in sys.argv:
        sys.exit(f"docs/reference is not current: {', '.join(stale)}; run docs/site/reference.py STEERGUARD")


if __name__ == "__main__":
    main()
