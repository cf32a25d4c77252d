"""What commands print with --json is what their schemas say, key by key; and every key is described."""

import json
import subprocess

import jsonschema
import pytest
from quick import write_inputs

ROAD = ["--drives", "2", "--duration", "5"]


def run(steerguard, folder, *arguments):
    return subprocess.run([steerguard, "--json", *map(str, arguments)], cwd=folder, capture_output=True, text=True)


@pytest.fixture(scope="module")
def folder(steerguard, fixtures, tmp_path_factory):
    folder = tmp_path_factory.mktemp("json")
    write_inputs(steerguard, fixtures, folder, [15])
    return folder


@pytest.fixture(scope="module")
def schema(steerguard):
    def of(name):
        text = subprocess.run([steerguard, "schema", name], check=True, capture_output=True, text=True).stdout
        return json.loads(text)

    return of


def objects(schema):
    """Every schema of an object inside another, itself included."""
    if isinstance(schema, dict):
        if "properties" in schema:
            yield schema
        for inner in schema.values():
            yield from objects(inner)
    elif isinstance(schema, list):
        for inner in schema:
            yield from objects(inner)


def closed(schema):
    """The schema with no other keys than those it names: it must know all that is printed."""
    for of in objects(schema):
        of["additionalProperties"] = False
    return schema


def names(steerguard):
    text = subprocess.run([steerguard, "schema", "--help"], check=True, capture_output=True, text=True).stdout
    return [line.strip().removeprefix("- ").split(":")[0] for line in text.splitlines() if line.strip().startswith("- ")]


def test_every_key_is_described(steerguard, schema):
    of_all = {name: schema(name) for name in names(steerguard)}
    assert len(of_all) == 16
    for name, of in of_all.items():
        jsonschema.Draft202012Validator.check_schema(of)
        # The one key of an alternative is described where the alternative is.
        keys = [
            (key, inner.get("description") or len(part["properties"]) == 1 and part.get("description"))
            for part in objects(of)
            for key, inner in part["properties"].items()
        ]
        assert keys, name
        assert not [key for key, described in keys if not described], name


# By what schema: arguments, exit status. In this order: some read what others write. The main job takes too long here;
# what it prints is composed of what these print.
PRINTED = {
    "init": (["init", "car.toml"], 0),
    "identify": (["identify", "drive.csv", "--known", "known.toml", "-o", "identified.toml"], 0),
    "design": (["design", "quick.toml", "-o", "quick.json"], 1),
    "verify": (["verify", "{fixtures}/design.json"], 0),
    "package": (["package", "{fixtures}/design.json", "-o", "D.fmu"], 0),
    "check": (["check", "{fixtures}/SteeringFaultDetector.fmu"], 0),
    "simulate": (["simulate", "--detector", "{fixtures}/SteeringFaultDetector.fmu", "--scenario", "short.toml"], 0),
    "scenario": (["simulate", "--print-scenario"], 0),
    "campaign": (["campaign", "{fixtures}/design.json", *ROAD, "-o", "campaign"], 0),
    "campaign-drive": (["campaign", "{fixtures}/design.json", *ROAD, "--drive", "1"], 0),
    "campaign-signals": (["campaign", "{fixtures}/design.json", *ROAD, "--signals", "signals.parquet"], 0),
    "campaign-worst": (["campaign", "{fixtures}/design.json", "--worst", "--budget", "100", "-o", "worst"], 0),
    "replay": (["replay", "{fixtures}/design.json", "drive.csv", "--fault", "bias=1@5s", "-o", "replayed"], 0),
    "report": (["report", "{fixtures}/design.json", "--replay", "replayed", "-o", "report.html"], 0),
    "failure": (["identify", "drive.csv"], 2),
}


@pytest.mark.parametrize("name", PRINTED)
def test_what_is_printed_is_what_the_schema_says(steerguard, fixtures, folder, schema, name):
    arguments, status = PRINTED[name]
    done = run(steerguard, folder, *(word.format(fixtures=fixtures) for word in arguments))
    assert done.returncode == status, done.stderr
    printed = json.loads(done.stderr if name == "failure" else done.stdout)
    jsonschema.validate(printed, closed(schema(name)))


def test_a_key_of_another_type_or_name_is_not_what_the_schema_says(steerguard, fixtures, schema):
    printed = json.loads(run(steerguard, fixtures, "verify", fixtures / "design.json").stdout)
    of = closed(schema("verify"))
    jsonschema.validate(printed, of)
    for other in ({"hash": 1}, {"new": 1}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(printed | other, of)
    del printed["holds"]
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(printed, of)


def test_the_main_job_prints_what_other_commands_print(schema):
    job, parts = schema("main-job"), schema("design")
    assert job["$defs"]["DesignSummary"] == parts["$defs"]["DesignSummary"]
    assert job["$defs"]["Detection"] == schema("simulate")["$defs"]["Detection"]
    assert job["$defs"]["Packaged"] == schema("package")["$defs"]["Packaged"]


def test_the_page_has_the_injected_faults_one_by_one(steerguard, fixtures, folder, tmp_path):
    design = fixtures / "design.json"
    replay = run(steerguard, folder, "replay", design, "drive.csv", "--fault", "bias=1@5s", "-o", tmp_path / "replay")
    [drive] = json.loads(replay.stdout)["drives"]
    page = tmp_path / "page.html"
    run(steerguard, folder, "report", design, "--replay", tmp_path / "replay", "-o", page).check_returncode()
    text = page.read_text(encoding="utf-8")
    assert len(drive["injected"]) == 2
    for fault in drive["injected"]:
        # Verdict beside the size: a phone shows no more than the first columns.
        numbers = [f"{fault['delay_s']:.2f}", fault["cause"], "5.0", f"{fault['largest_ratio']:.2f}"]
        cells = [fault["kind"], f"{fault['angle_deg']:+g} deg", fault["verdict"], *numbers, "drive.csv"]
        assert "".join(f"<td>{cell}</td>" for cell in cells) in text
