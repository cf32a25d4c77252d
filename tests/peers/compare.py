"""Compares steerguard with its peers on the same drives, at the same rate of false alarms.

Peers: an extended Kalman filter with a test on the mean NIS of a window, one with a CUSUM test, and
the detector of the paper as printed: constant threshold, W_r = I. Two more filters are told what
steerguard is told of bank, gust and vehicle (told.py): one with the fault as a state, one with the likelihood
ratio over onsets. Beside them steerguard with a constant in the place of its threshold's level and
uncertainties, which shows what these bring, and with its second test, if the design has one.

The thresholds of all are set on fault-free drives, so that at most as many of these have an alarm
as the rate allows: steerguard's by `threshold_factor`. At factor 1 it is "as shipped". Then biases of random size, from other seeds, show what is detected, and biases
of 1 degree how soon. The filters take the best process noise, window, drift and setting of a grid: what
surely detects the smallest of the very biases that they are then judged by (where none does, what
detects most, then soonest), which favours them.

Two conditions, the nominal plant and a perturbed one; and the nominal plant once more with what was
set for the perturbed one, since nobody knows which vehicle a detector will be in.
"""

import argparse
import json
import math
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from drives import Bench, Incomparable, read_design
from judgement import Outcomes, peaks, threshold
from kalman import Tuning, Vehicle, cusum, innovations, windowed_mean
from limit import MANOEUVRES, Indistinguishable
from plot import draw
from told import Setting, ToldVehicle, fault_state, onset_ratio

CONDITIONS = {
    "nominal": ["--nominal"],
    "perturbed": [
        *("--parameters", 10, "--bank", 3, "--gust", 10),
        *("--actuator-lag", 0, "--actuator-delay", 0),
    ],
}
ACCELERATIONS = (0.03, 0.3, 3.0)  # m/s^2
YAW_ACCELERATIONS = (0.03, 0.3, 3.0)  # rad/s^2
WINDOWS = (10, 40, 100)  # samples
DRIFTS = (0.25, 0.5, 1.0, 2.0)  # standard deviations
TOLD = (Setting(bank=0.05, wind=2.5), Setting(bank=0.2, wind=6.0))
FAULT_WALKS = (6e-4, 2e-3)  # rad per root of s
LIMIT_SPEEDS = (6.0, 15.0, 29.0)  # m/s
HEAD = [
    "detector",
    "tuning",
    "threshold",
    "fault-free",
    "false alarms",
    "masked",
    "detected",
    "missed",
    "largest missed deg",
    "sure from deg",
    "1 deg: delay median s",
    "95 % s",
    "0.5 deg: seen",
    "median s",
    "95 % s",
]


@dataclass(frozen=True)
class Detector:
    """A kind of detector and its tuning."""

    name: str
    tuning: str = ""


SHIPPED = Detector("steerguard as shipped")
BOTH = Detector("steerguard with second test")
STEERGUARD = Detector("steerguard")
CONSTANT = Detector("steerguard, constant")
PAPER = Detector("paper")
NIS = "EKF, NIS"
CUSUM = "EKF, CUSUM"
FAULT_STATE = "EKF told, fault as a state"
ONSET = "EKF told, likelihood ratio"
AS_DESIGNED = (SHIPPED, BOTH)  # alarm at 1
NAMES = (
    *(SHIPPED.name, BOTH.name, STEERGUARD.name, CONSTANT.name, PAPER.name),
    *(NIS, CUSUM, FAULT_STATE, ONSET),
)


@dataclass(frozen=True)
class Threshold:
    """A threshold, and how many of the drives that it was set on reach it."""

    value: float
    drives_with_alarm: int

    @classmethod
    def of(cls, detector, peaks, allowed):
        value = 1.0 if detector in AS_DESIGNED else threshold(peaks, allowed)
        return cls(float(value), int((peaks >= value).sum()))


class Comparison:
    """Two designs and a grid of filters on the drives of a campaign."""

    def __init__(self, bench, arguments, design):
        detector = design["detector"]
        self.bench = bench
        self.arguments = arguments
        self.period_s = detector["model"]["sampling_period_s"]
        self.vehicle = Vehicle.of(detector["model"])
        self.told = ToldVehicle(detector, design["spec"]["vehicle"]["centre_of_gravity_height_m"])
        self.has_second_test = detector["estimator"] is not None

    def campaign(self, condition, seed, faults):
        a = self.arguments
        return [
            *("--drives", a.drives, "--duration", a.duration, "--seed", seed, "--mix", a.mix),
            *("--v-x-noise", a.v_x_noise, "--r-noise", a.r_noise),
            *CONDITIONS[condition],
            *faults,
        ]

    def statistics(self, drives, only=None):
        """Each detector, or each of `only`, and its statistic."""
        a = self.arguments
        wanted = lambda detector: only is None or detector in only  # noqa: E731
        for detector, statistic in [
            (SHIPPED, drives.j_ratio),
            (STEERGUARD, drives.j_ratio),
            (CONSTANT, drives.j_past_start_up),
            (PAPER, drives.j_paper),
        ]:
            if wanted(detector):
                yield detector, statistic
        if self.has_second_test and wanted(BOTH):
            yield BOTH, np.maximum(drives.j_ratio, drives.second_ratio)
        noise = (a.v_x_noise, a.r_noise)
        given = (noise, self.period_s, drives.y, drives.u, drives.armed)
        for setting in TOLD:
            of_setting = f"bank {setting.bank} m/s^2, wind {setting.wind} m/s"
            if wanted(detector := Detector(ONSET, of_setting)):
                yield detector, onset_ratio(self.told, setting, *given)[0]
            for walk in FAULT_WALKS:
                if wanted(detector := Detector(FAULT_STATE, f"{of_setting}, fault {walk} rad")):
                    yield detector, fault_state(self.told, replace(setting, fault=walk), *given)
        for acceleration in ACCELERATIONS:
            for yaw in YAW_ACCELERATIONS:
                of_q = f"{acceleration} m/s^2, {yaw} rad/s^2"
                by_window = [Detector(NIS, f"{of_q}, window {window}") for window in WINDOWS]
                by_drift = [Detector(CUSUM, f"{of_q}, drift {drift}") for drift in DRIFTS]
                if not any(map(wanted, by_window + by_drift)):
                    continue
                tuning = Tuning(a.v_x_noise, a.r_noise, acceleration, yaw)
                found = innovations(
                    self.vehicle, tuning, self.period_s, drives.y, drives.u, drives.armed
                )
                for detector, window in zip(by_window, WINDOWS, strict=True):
                    if wanted(detector):
                        yield detector, windowed_mean(found.nis, drives.armed, window)
                sums = cusum(found.yaw_rate, drives.armed, DRIFTS)
                for k, detector in enumerate(by_drift):
                    if wanted(detector):
                        yield detector, sums[:, k]

    def thresholds(self, condition):
        """Of each detector; hours monitored; number of drives that may have an alarm."""
        found, armed_samples = {}, 0
        campaign = self.campaign(condition, self.arguments.seed, ["--faults", "none"])
        for drives in self.bench.drive(campaign):
            armed_samples += drives.armed.sum()
            for detector, statistic in self.statistics(drives):
                found.setdefault(detector, []).append(peaks(statistic, drives.armed))
        hours = armed_samples * self.period_s / 3600
        allowed = math.floor(self.arguments.per_hour * hours)
        thresholds = {
            detector: Threshold.of(detector, np.concatenate(parts), allowed)
            for detector, parts in found.items()
        }
        return thresholds, hours, allowed

    def outcomes(self, condition, seed, sizes, thresholds):
        """Of each detector that has a threshold."""
        found = {}
        campaign = self.campaign(condition, seed, ["--faults", "bias", "--fault-deg", sizes])
        for drives in self.bench.drive(campaign):
            for detector, statistic in self.statistics(drives, thresholds):
                found.setdefault(detector, []).append(
                    Outcomes.of(
                        statistic,
                        drives.armed,
                        drives.fault_rad,
                        thresholds[detector].value,
                        self.period_s,
                    )
                )
        return {detector: Outcomes.joined(parts) for detector, parts in found.items()}

    def all(self):
        """The figures of all conditions."""
        nominal, _ = self.tuned("nominal")
        perturbed, best = self.tuned("perturbed")
        same = {"driven": "nominal", "detectors": self.figures("nominal", best)}
        return [nominal, perturbed, perturbed | same]

    def tuned(self, condition):
        """The figures of a condition, and thresholds by detector."""
        thresholds, hours, allowed = self.thresholds(condition)
        best = {}
        biases = self.biases(condition, thresholds)
        for detector in sorted(biases, key=lambda d: merit(biases[d])):
            best[detector.name] = detector  # the last one stays
        thresholds = {best[name]: thresholds[best[name]] for name in NAMES if name in best}
        return {
            "driven": condition,
            "set_on": condition,
            "fault_free_hours": hours,
            "drives_with_alarm": allowed,
            "detectors": self.figures(condition, thresholds),
        }, thresholds

    def figures(self, condition, thresholds):
        """Of the detectors that have a threshold, on biased drives."""
        biases = self.biases(condition, thresholds)
        one_degree, half_a_degree = (
            self.outcomes(condition, self.arguments.seed + 2, size, thresholds)
            for size in ("1..1", "0.5..0.5")
        )
        return [
            figures_of(d, thresholds[d], biases[d], one_degree[d], half_a_degree[d]) for d in thresholds
        ]

    def biases(self, condition, thresholds):
        sizes = f"0..{self.arguments.largest}"
        return self.outcomes(condition, self.arguments.seed + 1, sizes, thresholds)


def merit(biases):
    """What the best tuning has most of."""
    sure = biases.surely_detected_deg()
    return -np.nan_to_num(sure, nan=np.inf), biases.detected.sum(), -biases.delay_quantile_s(0.5)


def figures_of(detector, threshold, biases, one_degree, half_a_degree):
    def finite(value):
        return float(value) if np.isfinite(value) else None

    return {
        "detector": detector.name,
        "tuning": detector.tuning,
        "threshold": threshold.value,
        "fault_free_drives_with_alarm": threshold.drives_with_alarm,
        "drives_with_alarm_before_the_fault": int(biases.false_alarm.sum()),
        "masked": int(biases.masked.sum()),
        "detected": int(biases.detected.sum()),
        "missed": int((biases.tried & ~biases.detected).sum()),
        "largest_missed_deg": finite(biases.largest_missed_deg()),
        "surely_detected_deg": finite(biases.surely_detected_deg()),
        "one_degree_detected": int(one_degree.detected.sum()),
        "one_degree_missed": int((one_degree.tried & ~one_degree.detected).sum()),
        "one_degree_delay_median_s": finite(one_degree.delay_quantile_s(0.5)),
        "one_degree_delay_95_s": finite(one_degree.delay_quantile_s(0.95)),
        "half_a_degree_detected": int(half_a_degree.detected.sum()),
        "half_a_degree_missed": int((half_a_degree.tried & ~half_a_degree.detected).sum()),
        "half_a_degree_delay_median_s": finite(half_a_degree.delay_quantile_s(0.5)),
        "half_a_degree_delay_95_s": finite(half_a_degree.delay_quantile_s(0.95)),
        "sizes_deg": biases.size_deg[biases.tried].tolist(),
        "delays_s": [finite(delay) for delay in biases.delay_s[biases.tried]],
    }


def text(result):
    """A table for each condition."""
    lines = [
        "Biases up to {largest} deg; delays at 1 deg; {drives} drives of {duration} s each from seeds "
        "{seed}, and the two after it; noise {v_x_noise} m/s and {r_noise} rad/s".format(
            **result["settings"]
        )
    ]
    for condition in result["conditions"]:
        lines += [
            "",
            "{driven}: thresholds let {drives_with_alarm} {set_on} drives without fault alarm in "
            "{fault_free_hours:.2f} h".format(**condition),
        ]
        lines += table([HEAD, *map(cells, condition["detectors"])])
    lines += ["", "The largest bias that some pair of drives within what is stated hides from any detector (limit.py), deg:"]
    lines += table(
        [["manoeuvre", "m/s", "of a known car", "between two cars"]]
        + [
            [found["manoeuvre"], f"{found['speed_m_per_s']:.0f}"]
            + [f"{found[k]:.3f}" for k in ("known_car_deg", "two_cars_deg")]
            for found in result["limits"]
        ]
    )
    return "\n".join(lines)


def limits(vehicle, noise, period_s, record_s):
    """Of an onset in the middle of a record, by manoeuvre and speed."""
    for manoeuvre in MANOEUVRES:
        for speed in LIMIT_SPEEDS:
            hidden = Indistinguishable(vehicle, noise, period_s, manoeuvre, speed, record_s=record_s)
            yield {
                "manoeuvre": manoeuvre,
                "speed_m_per_s": speed,
                "known_car_deg": hidden.largest(1),
                "two_cars_deg": hidden.largest(2),
            }


def cells(figures):
    def number(value):
        return "-" if value is None else f"{value:.2f}"

    return [
        figures["detector"],
        figures["tuning"],
        f"{figures['threshold']:.4g}",
        *(
            str(figures[k])
            for k in (
                *("fault_free_drives_with_alarm", "drives_with_alarm_before_the_fault"),
                *("masked", "detected", "missed"),
            )
        ),
        *(number(figures[k]) for k in ("largest_missed_deg", "surely_detected_deg")),
        *(number(figures[k]) for k in ("one_degree_delay_median_s", "one_degree_delay_95_s")),
        "{half_a_degree_detected} of {tried}".format(
            tried=figures["half_a_degree_detected"] + figures["half_a_degree_missed"], **figures
        ),
        *(number(figures[k]) for k in ("half_a_degree_delay_median_s", "half_a_degree_delay_95_s")),
    ]


def table(rows):
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  " + "  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]


def parser():
    parser = argparse.ArgumentParser(
        prog="tests/peers/run",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add(
        "--steerguard",
        metavar="PATH",
        required=True,
        help="the command (tests/peers/run names it)",
    )
    add(
        "--design",
        metavar="FILE",
        help="design or specification; default: every key at its default, and the second test",
    )
    add("--paper", metavar="FILE", required=True, help="the paper's (tests/peers/run names it)")
    add("--drives", type=int, default=200, help="of each kind; default: %(default)s")
    add("--duration", type=float, default=20.0, help="of a drive, s; default: %(default)s")
    add("--seed", type=int, default=1, help="and the two after it; default: %(default)s")
    add("--largest", type=float, default=2.0, help="bias, deg; default: %(default)s")
    add(
        "--v-x-noise",
        type=float,
        default=0.02,
        help="standard deviation, m/s; default: %(default)s",
    )
    add(
        "--r-noise",
        type=float,
        default=0.002,
        help="standard deviation, rad/s; default: %(default)s",
    )
    add("--mix", choices=["standard", "classic"], default="standard", help="manoeuvres; default: %(default)s")
    add("--per-hour", type=float, default=0.1, help="false alarms allowed; default: %(default)s")
    add(
        "--limit-record",
        type=float,
        default=30.0,
        help="what limit.py looks at, the onset in the middle, s; default: %(default)s",
    )
    add("-o", "--output", metavar="FILE", help="the figures as JSON")
    add("--plot", metavar="FILE", help="what is detected of uncertain vehicles, by size (SVG, PNG, PDF)")
    return parser


def compare(arguments):
    """The figures of all conditions, and what they belong to."""
    with tempfile.TemporaryDirectory() as folder:
        made = [Path(folder, name) for name in ("design.json", "paper.json")]
        default = Path(folder, "default.toml")
        default.write_text("[estimator]\nenabled = true\n", encoding="utf-8")
        bench = Bench(arguments.steerguard, *made)
        for source, design in zip(
            [arguments.design or default, arguments.paper], made, strict=True
        ):
            bench.make(source, design)
        design = read_design(made[0])
        if any(design["spec"]["actuator"].values()):
            raise Incomparable(
                "the design has an [actuator], and the filters, which are given the command, know "
                "of none: compare the design without it"
            )
        comparison = Comparison(bench, arguments, design)
        settings = {k: v for k, v in vars(arguments).items() if isinstance(v, (int, float))}
        hashes = {"design": design["hash"], "paper": read_design(made[1])["hash"]}
        conditions = comparison.all()
        noise = (arguments.v_x_noise, arguments.r_noise)
        hidden = list(limits(comparison.told, noise, comparison.period_s, arguments.limit_record))
        return {"settings": settings, **hashes, "limits": hidden, "conditions": conditions}


def main():
    arguments = parser().parse_args()
    try:
        result = compare(arguments)
    except Incomparable as error:
        sys.exit(f"error: {error}")
    print(text(result))
    if arguments.plot:
        draw(result, arguments.plot)
    if arguments.output:
        Path(arguments.output).write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
