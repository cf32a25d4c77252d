"""`steerguard-campaign`: the bytes of one machine, whoever is killed; clear refusals."""

import hashlib
import importlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from contextlib import contextmanager, suppress
from pathlib import Path
from types import SimpleNamespace

import psutil
import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "packaging" / "dask"
BLOCKS = 8
CAMPAIGN = ["--drives", "120", "--duration", "300", "--seed", "5"]
TIMEOUT_S = 120


def environment(path=None, package=True):
    """Of a process; `path` replaces PATH, and only with `package` is ours there."""
    changed = {"PATH": str(path)} if path else {}
    changed |= {"PYTHONPATH": str(PACKAGE)} if package else {}
    return {k: v for k, v in os.environ.items() if k != "PYTHONPATH"} | changed


def started(design, arguments, **kind):
    line = [sys.executable, "-m", "steerguard_campaign", str(design), *map(str, arguments)]
    return subprocess.Popen(
        line, env=environment(**kind), text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )


def finished(process):
    """Exit code and output."""
    out, err = process.communicate(timeout=TIMEOUT_S)
    return process.returncode, out, err


def until(condition, process):
    """The first true value of `condition`, while `process` runs."""
    end = time.monotonic() + TIMEOUT_S
    while time.monotonic() < end:
        assert process.poll() is None, process.communicate()
        if value := condition():
            return value
        time.sleep(0.005)
    raise AssertionError("nothing happened")


def blocks(folder):
    """The times of the blocks that are there, by name; those being written have a leading dot."""
    there = (folder / "blocks").glob("[!.]*.json")
    return {path.name: path.stat().st_mtime_ns for path in there}


def stopped(pid):
    """The `steerguard` processes of a worker, stopped in the middle."""
    found = []
    for child in psutil.Process(pid).children():
        with suppress(psutil.NoSuchProcess):
            if child.name() == "steerguard":
                child.suspend()
                found.append(child)
    return found


def ended(process):
    """Whether it has, be it that nobody has asked for its exit code yet."""
    return not process.is_running() or process.status() == psutil.STATUS_ZOMBIE


@pytest.fixture(scope="module")
def design_file(fixtures):
    return fixtures / "design.json"


@pytest.fixture(scope="module")
def one_machine(steerguard, design_file, tmp_path_factory):
    """Folder of the campaign as one machine drives it."""
    folder = tmp_path_factory.mktemp("one") / "campaign"
    line = [steerguard, "campaign", design_file, *CAMPAIGN, "-o", folder]
    subprocess.run(line, check=True, capture_output=True)
    return folder


def assert_same(folder, reference):
    for file in ["results.parquet", "report.json", "campaign.json"]:
        assert (folder / file).read_bytes() == (reference / file).read_bytes(), file


class Cluster:
    """A scheduler and workers that know nothing of this project, as processes."""

    def __init__(self, folder):
        self.folder = folder
        self.processes = []
        self.start("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
        file = until(self._written, self.processes[0])
        self.address = json.loads(file.read_text())["address"]

    def _written(self):
        file = self.folder / "scheduler.json"
        return file.exists() and file.stat().st_size and file

    def start(self, module, *arguments, path=None):
        line = [sys.executable, "-m", f"distributed.cli.{module}", *arguments]
        line += ["--scheduler-file", self.folder / "scheduler.json"]
        process = subprocess.Popen(
            line,
            cwd=self.folder,
            env=environment(path, package=False),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self.processes.append(process)
        return process

    def worker(self, path=None):
        options = ["--no-nanny", "--nthreads", "1", "--no-dashboard"]
        return self.start("dask_worker", *options, path=path)


@contextmanager
def cluster(folder):
    made = Cluster(folder)
    try:
        yield made
    finally:
        for process in made.processes:
            process.kill()
            process.wait()


def test_a_killed_worker_costs_its_shard_and_nothing_else(
    steerguard, design_file, one_machine, tmp_path
):
    folder = tmp_path / "campaign"
    with cluster(tmp_path) as dask:
        victim, _ = dask.worker(), dask.worker()
        arguments = [*CAMPAIGN, "--command", steerguard, "--scheduler", dask.address]
        arguments += ["--shards", BLOCKS, "-o", folder, "--json"]
        running = started(design_file, arguments)
        until(lambda: blocks(folder), running)
        [orphan] = until(lambda: stopped(victim.pid), running)
        before = blocks(folder)
        victim.send_signal(signal.SIGKILL)
        if not shutil.which("setpriv"):
            orphan.kill()
        until(lambda: ended(orphan), running)
        code, out, err = finished(running)
    assert code == 0, err
    assert 0 < len(before) < BLOCKS
    assert before.items() <= blocks(folder).items(), "blocks were driven twice"
    assert json.loads(out)["throughput"] is None, "blocks were driven by the main process"
    assert_same(folder, one_machine)


def test_a_killed_main_process_goes_on(steerguard, design_file, one_machine, tmp_path):
    folder = tmp_path / "campaign"
    arguments = [*CAMPAIGN, "--command", steerguard, "--jobs", 2, "-o", folder, "--json"]
    running = started(design_file, arguments)
    until(lambda: len(blocks(folder)) >= 2, running)
    others = psutil.Process(running.pid).children(recursive=True)
    running.kill()
    running.communicate()
    end = time.monotonic() + 30
    while not all(map(ended, others)):
        assert time.monotonic() < end, "workers outlive the main process"
        time.sleep(0.05)
    before = blocks(folder)
    assert 2 <= len(before) < BLOCKS
    left = folder / "blocks" / ".steerguard-left"
    left.write_text("half")
    assert not (folder / "results.parquet").exists()

    code, out, err = finished(started(design_file, arguments))
    assert code == 0, err
    assert before.items() <= blocks(folder).items(), "blocks were driven twice"
    assert json.loads(out)["throughput"] is None, "blocks were driven by the main process"
    assert_same(folder, one_machine)
    assert not left.exists(), "what a killed process left is swept"

    # Nothing is left to do, and no cluster is started for it.
    code, _, err = finished(started(design_file, [*arguments[:-1], "--scheduler", "tcp://0:1"]))
    assert code == 2 and "--jobs" in err
    arguments[arguments.index("--jobs") : arguments.index("-o")] = ["--scheduler", "tcp://0:1"]
    code, _, err = finished(started(design_file, arguments))
    assert code == 0, err
    assert_same(folder, one_machine)


def test_a_scheduler_that_goes_is_told_of_and_another_goes_on(
    steerguard, design_file, one_machine, tmp_path
):
    folder = tmp_path / "campaign"
    usual = [*CAMPAIGN, "--command", steerguard, "--shards", BLOCKS, "-o", folder, "--scheduler"]
    first, second = tmp_path / "first", tmp_path / "second"
    first.mkdir()
    second.mkdir()
    with cluster(first) as dask:
        dask.worker()
        running = started(design_file, [*usual, dask.address])
        until(lambda: blocks(folder), running)
        dask.processes[0].kill()
        code, _, err = finished(running)
    assert code == 2, err
    assert "error: the scheduler has gone" in err, err
    assert "goes on" in err
    assert "Traceback" not in err

    # On another cluster, whose only worker dies; then one comes to it.
    before = blocks(folder)
    assert 0 < len(before) < BLOCKS
    with cluster(second) as dask:
        victim = dask.worker()
        running = started(design_file, [*usual, dask.address, "--json"])
        [orphan] = until(lambda: stopped(victim.pid), running)
        victim.kill()
        orphan.kill()
        dask.worker()
        code, out, err = finished(running)
    assert code == 0, err
    assert before.items() <= blocks(folder).items(), "blocks were driven twice"
    assert json.loads(out)["throughput"] is None, "blocks were driven by the main process"
    assert_same(folder, one_machine)


def test_a_specification_is_designed_first(steerguard, design_file, tmp_path):
    folder = tmp_path / "campaign"
    specification = ROOT / "examples" / "paper.toml"
    line = ["--drives", "20", "--duration", "5", "--command", steerguard, "-o", folder]
    code, out, err = finished(started(specification, [*line, "--jobs", "1"]))
    assert code == 0, err
    assert "20 drives" in out
    campaign = json.loads((folder / "campaign.json").read_text())
    assert campaign["design"] == json.loads(design_file.read_text())["hash"]


def script(folder, text):
    """A folder with a command `steerguard` that is not the one of the main process."""
    folder.mkdir()
    command = folder / "steerguard"
    command.write_text(text)
    command.chmod(0o755)
    return folder


@pytest.mark.parametrize(
    ("worker", "expected"),
    [
        (None, "there is no `steerguard` command"),
        ('exec "{}" "$@" --nominal', "holds another campaign uncertainty: "),
        ("kill -9 $$", "ended with -9"),
    ],
)
def test_unfit_workers_are_named_before_anything_is_driven(
    steerguard, design_file, tmp_path, worker, expected
):
    empty = tmp_path / "bin"
    text = "#!/bin/sh\n" + (worker or "").format(steerguard) + "\n"
    path = script(empty, text) if worker else empty
    folder = tmp_path / "campaign"
    with cluster(tmp_path) as dask:
        dask.worker(path=path)
        arguments = ["--drives", "32", "--seed", "5", "--scheduler", dask.address, "-o", folder]
        code, _, err = finished(started(design_file, arguments, path=steerguard.parent))
    assert code == 2, err
    assert re.search(r"error: worker tcp://127\.0\.0\.1:\d+: ", err), err
    assert expected in " ".join(err.replace("|", " ").split())
    assert "same build" in err
    assert "Traceback" not in err
    assert not blocks(folder)


def test_refusals_say_what_is_wrong(steerguard, design_file, tmp_path):
    edited = tmp_path / "edited.json"
    edited.write_text(design_file.read_text().replace("1476.0", "1477.0", 1))
    usual = ["--command", steerguard, "-o", tmp_path / "campaign"]
    for design, arguments, parts in [
        (design_file, ["--command", "nowhere"], ["no `nowhere` command", "--command PATH"]),
        (
            design_file,
            [*usual, "--scheduler", "tcp://127.0.0.1:1"],
            ["no scheduler", "127.0.0.1:1"],
        ),
        (design_file, [*usual, "--scheduler", "nonsense://x"], ["no scheduler", "nonsense"]),
        (design_file, [*usual, "--drives", "0"], ["--drives", "0"]),
        (design_file, [*usual, "--shards", "0"], ["--shards", "0"]),
        (design_file, [*usual, "--shard", "1/2"], ["--shard", "steerguard campaign"]),
        (tmp_path / "none.json", usual, ["none.json", "No such file"]),
        (edited, usual, ["edited.json", "steerguard design"]),
        ("--drives", ["5", design_file, *usual], ["DESIGN comes first"]),
    ]:
        code, out, err = finished(started(design, arguments))
        # A design that does not verify is a no, all else is no input.
        assert code == (1 if design == edited else 2), (arguments, err)
        assert not out
        assert "{" not in err
        assert all(part in err for part in parts), err
        assert "Traceback" not in err


def test_the_installed_command_is_this_one():
    project = tomllib.loads((PACKAGE / "pyproject.toml").read_text())["project"]
    module, function = project["scripts"]["steerguard-campaign"].split(":")
    sys.path.insert(0, str(PACKAGE))
    try:
        assert callable(getattr(importlib.import_module(module), function))
    finally:
        sys.path.remove(str(PACKAGE))


def modules():
    """`command` and `failure` of the package."""
    sys.path.insert(0, str(PACKAGE))
    try:
        return [importlib.import_module(f"steerguard_campaign.{name}") for name in ("command", "failure")]
    finally:
        sys.path.remove(str(PACKAGE))


def test_what_nobody_holds_is_swept(tmp_path):
    command, _ = modules()
    held, left, other = (tmp_path / name for name in (".steerguard-held", ".steerguard-left", "other"))
    for path in (held, left, other):
        path.write_text("half")
    with open(held, "rb") as file:
        assert command.lock(file, wait=True)
        command.sweep(tmp_path)
    assert held.exists() and other.exists() and not left.exists()
    command.sweep(tmp_path / "none")


def test_what_workers_send_is_looked_at_before_it_is_stored(tmp_path):
    command, failure = modules()
    here = SimpleNamespace(output=tmp_path / "c")
    (here.output / "blocks").mkdir(parents=True)
    rows = b'{"campaign":"0","rows":[]'
    good = rows + b',"sha256":"' + hashlib.sha256(rows).hexdigest().encode() + b'"}\n'
    command.Campaign.store(here, {"000001.json": good})
    for name, data in [
        ("../000002.json", good),
        ("/etc/000002.json", good),
        ("000002.json\n", good),
        ("000002.json", good.replace(b'"rows"', b'"Rows"')),
        ("000002.json", rows + b"}"),
        ("000002.json", b""),
    ]:
        with pytest.raises(failure.Failure, match="no block"):
            command.Campaign.store(here, {name: data})
    assert [path.name for path in tmp_path.rglob("*") if path.is_file()] == ["000001.json"]
