"""Every command that writes, on a disk that is full or read-only: a clear refusal, and nothing half."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "kill"))
import kill  # noqa: E402

OLD = "old"
# Mounts a small disk at $1, puts an old file $3 there, prepares it by $2, runs the rest, and lists what is there.
SCRIPT = """
disk=$1 prepare=$2 old=$3
shift 3
mount -t tmpfs -o size=128k none "$disk"
[ -z "$old" ] || printf old >"$disk/$old"
cd "$disk"
case $prepare in
    full) cat /dev/zero >filler 2>/dev/null ;;
    tight) head -c 96k /dev/zero >filler ;;
    read-only) mount -o remount,ro "$disk" ;;
esac
"$@"
code=$?
echo "listing:"
find "$disk" -mindepth 1 -not -name filler -type f -printf '%P\\n'
[ -z "$old" ] || { echo "old:"; cat "$disk/$old"; }
exit $code
"""


def namespace():
    """A command in front of which mounts are those of its process and its children alone."""
    # Who is not root is one in a namespace of users.
    return ["unshare", "--mount", *([] if os.geteuid() == 0 else ["--map-root-user"])]


def mounts_are_allowed():
    """Containers may forbid them."""
    line = [*namespace(), "sh", "-c", "mount -t tmpfs -o size=128k none /mnt"]
    try:
        return subprocess.run(line, check=False, capture_output=True).returncode == 0
    except FileNotFoundError:
        return False


pytestmark = pytest.mark.skipif(not mounts_are_allowed(), reason="no small disk can be mounted on this machine")

REASONS = {
    "full": r"(?i)no space left|full",
    "tight": r"(?i)no space left|full",
    "read-only": r"(?i)read-only",
}
def on_small_disk(disk, prepare, old, line, **environment):
    """Exit code, what it says on the standard error, files on the disk, and text of the old file."""
    done = subprocess.run(
        [*namespace(), "sh", "-c", SCRIPT, "sh", disk, prepare, old, *line],
        capture_output=True,
        text=True,
        timeout=120,
        env=os.environ | environment,
    )
    _, mark, listing = done.stdout.rpartition("listing:\n")
    assert mark, done.stderr
    files, _, text = listing.partition("old:\n")
    return done.returncode, done.stderr, files.split(), text


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("inputs")
    rows = "".join(f"{k * 0.01:.2f},15.0,0.0,0.0\n" for k in range(1000))
    (folder / "drive.csv").write_text("t [s],v [m/s],r [rad/s],steering [rad]\n" + rows)
    (folder / "quick.toml").write_text(kill.SPECIFICATION)
    return folder


def commands(fixtures, inputs):
    """Arguments by command, and the file that is replaced, if it is one."""
    design, drive = fixtures / "design.json", inputs / "drive.csv"
    fmus = [
        "--detector", fixtures / "SteeringFaultDetector.fmu", "--plant", fixtures / "VehiclePlant.fmu",
    ]  # fmt: skip
    return {
        "design": (["design", inputs / "quick.toml", "-o", "design.json"], "design.json"),
        "package": (["package", design, "-o", "a.fmu"], "a.fmu"),
        "replay": (["replay", design, drive, "-o", "replayed"], ""),
        "simulate": (["simulate", *fmus, "-o", "simulated"], ""),
        "campaign": (["campaign", design, "--drives", "2", "--duration", "5", "-o", "out"], ""),
    }


@pytest.mark.parametrize("prepare", ["full", "tight", "read-only"])
@pytest.mark.parametrize("name", ["package", "replay", "simulate", "campaign"])
def test_a_disk_that_takes_nothing_is_told_of(steerguard, fixtures, inputs, tmp_path, name, prepare):
    refused(steerguard, commands(fixtures, inputs)[name], tmp_path, name, prepare)


def test_a_design_for_a_full_disk(steerguard, fixtures, inputs, tmp_path):
    refused(steerguard, commands(fixtures, inputs)["design"], tmp_path, "design", "full")


def refused(steerguard, command, disk, name, prepare):
    arguments, old = command
    line = [steerguard, *arguments]
    code, error, files, text = on_small_disk(disk, prepare, old, line)
    if prepare == "tight" and code == 0:
        assert name in ("replay", "campaign"), "what is small has room"
        assert not [file for file in files if "/.steerguard" in f"/{file}"], files
        return
    assert code == 2, (code, error)
    assert error.startswith("error: "), error
    assert re.search(REASONS[prepare], error), error
    assert old in error or "replayed" in error or "simulated" in error or "out" in error, error
    assert "panicked" not in error and "Traceback" not in error
    if old:
        assert (files, text) == ([old], OLD)
    assert not [file for file in files if "/.steerguard" in f"/{file}"], files


def test_identify_on_a_full_disk(steerguard, tmp_path_factory, tmp_path):
    folder = tmp_path_factory.mktemp("identify")
    kill.drive_file(folder / "drive.csv")
    (folder / "known.toml").write_text(kill.KNOWN)
    arguments = ["identify", folder / "drive.csv", "--known", folder / "known.toml", "-o", "car.toml"]
    for prepare in ["full", "read-only"]:
        refused(steerguard, (arguments, "car.toml"), tmp_path, "identify", prepare)


@pytest.mark.parametrize("prepare", ["full", "read-only"])
def test_where_temporary_files_belong_takes_nothing(steerguard, fixtures, inputs, tmp_path, prepare):
    """FMUs are unpacked there before they are driven."""
    out = tmp_path / "out"
    disk = tmp_path / "disk"
    disk.mkdir()
    line = [steerguard, "campaign", fixtures / "design.json", "--drives", "2", "-o", out]
    code, error, files, _ = on_small_disk(disk, prepare, "", line, TMPDIR=str(disk))
    assert code == 2, (code, error)
    assert re.search(REASONS[prepare], error) and "TMPDIR" in error, error
    assert not files
    assert not list(out.rglob("*.parquet"))
