"""Drives of `steerguard campaign` as arrays: what the detectors are given, and what ours say.

Conventions: records are T x D (samples, drives) or T x D x 2; SI units, J without.
"""

import json
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow.parquet as parquet

MONITORING = 2
TOGETHER = 250  # drives in memory


class Incomparable(ValueError):
    """Designs that this comparison cannot do justice to."""


@dataclass
class Drives:
    """Some drives of a campaign, with two designs in the place of the detector."""

    y: np.ndarray  # v_x, r as measured
    u: np.ndarray  # T_eng, delta
    fault_rad: np.ndarray
    armed: np.ndarray
    j_ratio: np.ndarray  # J/J_th of the design
    second_ratio: np.ndarray  # its second test's statistic over its threshold; 0 without
    j_past_start_up: np.ndarray  # its J less the threshold's start-up term
    j_paper: np.ndarray  # J of the paper's design


GIVEN = ("v_x", "r", "u.T_eng", "u.delta", "fault")


class Bench:
    """The `steerguard` command and the two designs."""

    def __init__(self, steerguard, design, paper):
        self.steerguard = steerguard
        self.designs = [Path(design), Path(paper)]

    def make(self, source, design):
        """Makes the file `design` of a design or a specification."""
        text = Path(source).read_text(encoding="utf-8")
        if text.lstrip().startswith("{"):
            Path(design).write_text(text, encoding="utf-8")
        else:
            self._run("design", source, "-o", design)

    def _run(self, *line):
        subprocess.run([self.steerguard, *map(str, line)], check=True, stdout=subprocess.DEVNULL)

    def drive(self, arguments):
        """Drives a campaign with both designs; yields `Drives`, some at a time."""
        with tempfile.TemporaryDirectory() as folder:
            files = [Path(folder, f"{k}.parquet") for k in range(len(self.designs))]
            for design, file in zip(self.designs, files, strict=True):
                self._run("campaign", design, *arguments, "--signals", file)
            evaluation = read_design(self.designs[0])["detector"]["evaluation"]
            ours, papers = map(parquet.ParquetFile, files)
            for begin in range(0, ours.num_row_groups, TOGETHER):
                groups = list(range(begin, min(begin + TOGETHER, ours.num_row_groups)))
                yield joined(evaluation, *(records(file, groups) for file in (ours, papers)))


def records(file, groups):
    """The columns of drives, a row group each, T x D."""
    table = file.read_row_groups(groups)
    return {name: table[name].to_numpy().reshape(len(groups), -1).T for name in table.column_names}


def start_up(evaluation, armed):
    """The start-up term of J_th, T x D (method 6); 0 while not armed."""
    samples = 1 + np.arange(len(armed))[:, None]
    since = samples - np.maximum.accumulate(np.where(armed, 0, samples))  # samples, this one too
    window = evaluation["window"]
    within = np.minimum(since, window)
    decay = evaluation["start_up_decay"] ** 2
    squares = decay ** (since - within) * (1 - decay**within) / (1 - decay)
    return evaluation["start_up_amplitude"] * np.sqrt(squares / window)


def joined(evaluation, ours, papers):
    for name in GIVEN:
        if not np.array_equal(ours[name], papers[name]):
            raise Incomparable(
                f"the two designs do not get the same {name}: their vehicles, armed ranges and "
                "calibration manoeuvres must agree"
            )
    armed = ours["state"] == MONITORING
    return Drives(
        y=np.stack([ours["v_x"], ours["r"]], axis=-1),
        u=np.stack([ours["u.T_eng"], ours["u.delta"]], axis=-1),
        fault_rad=ours["fault"],
        armed=armed,
        j_ratio=ours["J_rms"] / ours["J_th"],
        second_ratio=ours["second_ratio"],
        j_past_start_up=ours["J_rms"] - start_up(evaluation, armed),
        j_paper=papers["J_rms"],
    )


def read_design(path):
    return json.loads(Path(path).read_text(encoding="utf-8"))
