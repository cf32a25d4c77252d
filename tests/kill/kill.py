"""Kills the command at random times and looks at what it leaves: old files or new ones, never halves."""

import argparse
import hashlib
import json
import math
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DESIGN = ROOT / "designer" / "verify" / "tests" / "fixtures" / "paper.json"
# What drives alone do not show.
KNOWN = """
[vehicle]
mass_kg = 1476.0
front_axle_distance_m = 1.13
rear_axle_distance_m = 1.49

[sensors]
steering_offset_deg = 0.0
yaw_rate_bias_deg_per_s = 0.0
"""
# A design that takes seconds.
SPECIFICATION = """
[operating_range]
v_y_m_per_s = [-1.5, 1.5]
r_rad_per_s = [-0.55, 0.55]

[design]
method = "paper"
search_budget = 1

[estimator]
enabled = false

[evaluation.calibration]
speeds = 2
manoeuvres = ["sine"]
initial_v_y_m_per_s = [0.0]
duration_s = 2.0
"""
OLD = b"old\n"
# What temporary files and folders of the command begin with: packaging/src/output/temporary.rs.
OURS = (".steerguard-", "steerguard-fmu-")


def drive_file(path):
    """Twenty seconds of a single-track car whose driver steers sines of several frequencies."""
    mass, inertia, front, rear, c_f, c_r = 1476.0, 1810.0, 1.13, 1.49, 57000.0, 59000.0
    v_y = r = 0.0
    rows = ["t [s],v [m/s],r [rad/s],steering [rad]"]
    for k in range(2000):
        t = k * 0.01
        v = 17.0 + 5.0 * math.sin(0.13 * t)
        delta = 0.02 * math.sin(0.9 * t) + 0.01 * math.sin(2.3 * t + 1.0) + 0.006 * math.sin(5.1 * t)
        rows.append(f"{t:.2f},{v:.5f},{r:.7f},{delta:.7f}")
        for _ in range(10):
            force_f = c_f * (delta - (v_y + front * r) / v)
            force_r = -c_r * (v_y - rear * r) / v
            v_y += 0.001 * ((force_f + force_r) / mass - v * r)
            r += 0.001 * (front * force_f - rear * force_r) / inertia
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")


class Subject:
    """A command that writes files, in a folder of its own."""

    def __init__(self, steerguard, name, arguments, outputs, following=None):
        """`following` is the command that is given after a kill; None: the same again."""
        self.name, self.outputs = name, outputs
        self.line = [steerguard, name, *arguments]
        self.following = following and [steerguard, *following]
        self.folder = Path(tempfile.mkdtemp(prefix="kill-"))
        self.temporary = Path(tempfile.mkdtemp(prefix="kill-temporary-"))
        self.new = {}

    def start(self, line=None):
        return subprocess.Popen(
            line or self.line,
            cwd=self.folder,
            env=os.environ | {"TMPDIR": str(self.temporary)},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        )

    def whole(self, line=None):
        """A run that nobody ends; its duration in s."""
        begun = time.monotonic()
        process = self.start(line)
        error = process.communicate()[1].decode()
        if process.returncode != 0:
            sys.exit(f"{self.name} ended with {process.returncode}: {error}")
        return time.monotonic() - begun

    def files(self):
        """Bytes of the results that are there, by path; temporary files are none."""
        there = (path for path in self.folder.rglob("*") if path.is_file())
        return {
            str(path.relative_to(self.folder)): path.read_bytes()
            for path in there
            if not path.name.startswith(OURS)
        }

    def left(self):
        """Temporary files and folders."""
        return [
            path
            for folder in (self.folder, self.temporary)
            for path in folder.rglob("*")
            if path.name.startswith(OURS)
        ]

    def reset(self):
        """Old files where the command will put new ones; a campaign goes on, so that it begins with none."""
        for path in self.folder.iterdir():
            shutil.rmtree(path) if path.is_dir() else path.unlink()
        for name in self.outputs:
            (self.folder / name).write_bytes(OLD)

    def judge(self):
        """Numbers of old, new and half files."""
        old = new = half = 0
        for name, data in self.files().items():
            if data == self.new.get(name):
                new += 1
            elif data == OLD and name in self.outputs:
                old += 1
            elif self.unordered(name) and block_is_whole(data):
                new += 1
            else:
                half += 1
                print(f"{self.name}: {name} is neither old nor new: {len(data)} bytes", file=sys.stderr)
        missing = [name for name in self.outputs if not (self.folder / name).exists()]
        for name in missing:
            half += 1
            print(f"{self.name}: {name} has gone", file=sys.stderr)
        return old, new, half

    def unordered(self, name):
        """Whether a file may differ between two runs: the report of a campaign states its speed."""
        return False


def block_is_whole(data):
    rows, mark, end = data.rstrip().rpartition(b',"sha256":"')
    return bool(mark) and end == hashlib.sha256(rows).hexdigest().encode() + b'"}'


def run(subject, kills, chance):
    """Kills `subject` so often; the row of the table."""
    subject.reset()
    subject.whole()
    subject.new = subject.files()
    subject.reset()
    duration_s = subject.whole()
    again = subject.files()
    if OLD in again.values():
        sys.exit(f"{subject.name} writes nothing")
    if again != subject.new:
        differ = [name for name in again if again[name] != subject.new.get(name)]
        sys.exit(f"{subject.name} does not write the same twice: {', '.join(differ)}")
    table = dict.fromkeys(["ended", "old", "new", "halves", "temporary", "left-overs", "right"], 0)
    for k in range(kills):
        subject.reset()
        process = subject.start()
        # Every other kill comes while a file is being written, and such times are short.
        if k % 2:
            while process.poll() is None and not any(
                name.startswith(OURS[0]) for _, _, names in os.walk(subject.folder) for name in names
            ):
                time.sleep(0.0002)
            time.sleep(chance.choice([0.0, 0.0, chance.uniform(0.0, 0.002)]))
        else:
            time.sleep(chance.uniform(0.0, duration_s))
        process.kill()
        process.communicate()
        table["ended"] += process.returncode != -9
        old, new, half = subject.judge()
        table["old"] += old
        table["new"] += new
        table["halves"] += half
        table["temporary"] += len(subject.left())
        before = subject.files()
        subject.whole(subject.following)
        table["left-overs"] += len(subject.left())
        after = subject.files()
        # The same again mends everything, another one changes nothing.
        table["right"] += before.items() <= after.items() if subject.following else after == subject.new
    return table


def main():
    parser = argparse.ArgumentParser(prog="tests/kill/run", description=__doc__)
    parser.add_argument("--steerguard", type=Path, required=True, help=argparse.SUPPRESS)
    parser.add_argument("--kills", type=int, default=100, help="of each command; default: %(default)s")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("command", nargs="*", help="design, package, identify, campaign; default: all")
    here = parser.parse_args()
    steerguard = here.steerguard.resolve()
    inputs = Path(tempfile.mkdtemp(prefix="kill-inputs-"))
    specification, drive, known = inputs / "car.toml", inputs / "drive.csv", inputs / "known.toml"
    known.write_text(KNOWN, encoding="utf-8")
    specification.write_text(SPECIFICATION, encoding="utf-8")
    drive_file(drive)
    package = [DESIGN, "-o", "a.fmu", "--fmi", "both", "--plant", "p.fmu", "--system", "s.ssp"]
    campaign = [DESIGN, "--drives", "33", "--duration", "5", "--seed", "5", "--jobs", "1", "-o", "out"]
    subjects = {
        # Another design would take as long again.
        "design": (
            [specification, "-o", "design.json"], ["design.json"], ["package", DESIGN, "-o", "next.fmu"]
        ),
        "package": (package, ["a.fmu", "a.fmi3.fmu", "p.fmu", "s.ssp"]),
        "identify": ([drive, "--known", known, "-o", "car.toml"], ["car.toml", "car.fit.svg"]),
        "campaign": (campaign, []),
    }
    bad = 0
    heads = ["command", "kills", "too late", "old", "new", "halves", "temporary", "left-overs", "next run right"]
    print("  ".join(f"{head:>10}" for head in heads))
    try:
        for name in here.command or subjects:
            subject = Subject(steerguard, name, *subjects[name])
            try:
                row = run(subject, here.kills, random.Random(f"{here.seed} {name}"))
            finally:
                shutil.rmtree(subject.folder)
                shutil.rmtree(subject.temporary)
            cells = [name, here.kills, *row.values()]
            print("  ".join(f"{cell:>{max(10, len(head))}}" for cell, head in zip(cells, heads)), flush=True)
            bad += row["halves"] + row["left-overs"] + (here.kills - row["right"])
    finally:
        shutil.rmtree(inputs)
    print("old, new: files after the kill. temporary: ours, left by the kill; left-overs: after the next command.")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
