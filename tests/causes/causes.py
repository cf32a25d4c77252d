"""A table of causes: false alarms where one is driven and not told, where it is told, and what telling costs.

    causes.py --steerguard COMMAND [--drives N]

Conventions
- The default specification otherwise. "Not told" is the detector without the cause's key or input, "told" the one with
  it; both are driven alike.
- What campaigns draw: N drives of 60 s of the standard mix, seed 1, which the cause alone widens.
- What they do not: the reference vehicle as specified in stated manoeuvres, to both sides; noise 0.02 m/s, 0.002 rad/s.
- Cost, of the told design: the smallest fault that its verdict sees, at the worst of three speeds; delays and misses of
  N biases of 1 degree in 60 s, seed 2, under its own uncertainty. An input costs nothing while it is not used, and
  while it is, nothing is seen.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "python"))
from driving import PERIOD_S, drive, weave
from fmu import Fmu

# Cause; what the specification says of it; what widens the campaign by it.
DRAWN = [
    ("steering ratio 10 %", "uncertainty.steering_ratio_percent = [-10, 10]", ["--steering-ratio", "10"]),
    ("steering offset 0.3 deg", "uncertainty.steering_offset_deg = 0.3", ["--steering-offset", "0.3"]),
    ("yaw-rate bias 0.5 deg/s", "uncertainty.yaw_rate_bias_deg_per_s = 0.5", ["--r-bias", "0.00872664625997"]),
    ("speed scale 5 %", "uncertainty.v_x_scale_percent = 5", ["--v-x-scale", "5"]),
    ("friction 0.4", "uncertainty.friction = [0.4, 1.0]", ["--friction", "0.4..1"]),
    ("height of the centre of gravity 100 % off", "uncertainty.load_transfer_percent = 100", ["--load-transfer", "100"]),
    ("actuator lag 0.1 s", "uncertainty.actuator_lag_s = 0.1", ["--actuator-lag", "0.1"]),
]  # fmt: skip

NO_HEIGHT = "vehicle.centre_of_gravity_height_m = 0"
END_STOP_DEG = 16
BRAKE = """
[[disturbance]]
kind = "yaw_moment"
name = "brake"
bound_n_m = 1000
"""


def both_sides(values):
    return [(value, side) for value in values for side in (1, -1)]


def turn(speed, lateral):
    """A steady turn, entered within a second."""
    angle = lateral * (2.62 / speed**2 + 0.0017)
    return lambda t: angle * np.clip(t - 1, 0, 1)


def braking(plant, detector):
    """At 5 m/s^2 to 7 m/s, in a turn of 3 m/s^2, wheel held."""
    for speed, side in both_sides([15.0, 18.0, 21.0, 24.0, 27.0]):

        def slope(t, speed=speed):
            return -5.0 if 4 <= t < 4 + (speed - 7) / 5 else 0.0

        yield drive(plant, detector, speed, steering=turn(speed, 3.0 * side), slope=slope, vehicle={"vehicle.h": 0.55})


def end_stop(plant, detector):
    """Commands 2 and 6 degrees beyond the end stop, which are reached within 2 s."""
    for speed in (5.6, 7.0):
        for beyond, side in both_sides([2, 6]):
            most = side * np.radians(END_STOP_DEG + beyond)
            yield drive(plant, detector, speed, steering=lambda t, most=most: most * np.clip((t - 2) / 2, 0, 1),
                        vehicle={"actuator.angle_limit": np.radians(END_STOP_DEG)})  # fmt: skip


def brake(plant, detector, moment=1000.0, seconds=1.0, told=lambda t, told: told):
    """A brake on one side in a weave of 2 m/s^2, from 6 s on."""
    for speed, side in both_sides([8.0, 12.0, 16.0, 20.0, 24.0]):
        yield drive(plant, detector, speed, steering=weave(speed, 2.0), told=told,
                    moment=lambda t, side=side: side * moment if 6 <= t < 6 + seconds else 0.0)  # fmt: skip


def disabled(plant, detector):
    """`enabled` false meanwhile and for a second after."""
    return brake(plant, detector, 3000.0, 0.5, lambda t, told: told | {"enabled": not 5.95 <= t < 7.5})


def stale(plant, detector, parameters=None):
    """v_x and r stand for a second of a weave of 2 m/s^2."""
    for speed, start in ((speed, start) for speed in (8.0, 16.0, 24.0) for start in (4.0, 5.25, 6.5)):
        held = {}

        def told(t, told, start=start, held=held):
            if start <= t < start + 1:
                return told | held
            held |= {name: told[name] for name in ("v_x", "r")}
            return told

        yield drive(plant, detector, speed, steering=weave(speed, 2.0), told=told, parameters=parameters)


def reversing(detector, sign):
    """Backwards at 5.5 to 7 m/s in a weave of 5 degrees, rolling without side slip: the reference vehicle only drives
    forward. The speed is measured times `sign`."""
    t = np.arange(0, 10, PERIOD_S)
    for speed, side in both_sides([5.5, 6.0, 7.0]):
        steering = side * np.radians(5) * np.sin(2 * np.pi * 0.2 * t)
        draw = np.random.default_rng(7)
        inputs = {
            "v_x": sign * -speed + 0.02 * draw.standard_normal(len(t)),
            "r": -speed * np.tan(steering) / 2.62 + 0.002 * draw.standard_normal(len(t)),
            "u.T_eng": np.zeros(len(t)),
            "u.delta": steering,
        }
        with detector.instance() as instance:
            instance.initialise()
            rows = {name: values.tolist() for name, values in inputs.items()}
            yield instance.record(rows, ["alarm", "state", "J_ratio"], PERIOD_S), []


# Cause; the specification without and with its key; drives of the detector without and with its input.
DRIVEN = [
    ("known load transfer, braking at 5 m/s^2 in a turn", NO_HEIGHT, "", braking, braking),
    (f"end stop at {END_STOP_DEG} deg", "", f"actuator.angle_limit_deg = {END_STOP_DEG}", end_stop, end_stop),
    ("yaw moment of 1000 N m for 1 s, as a disturbance", "", BRAKE, brake, brake),
    ("yaw moment of 3000 N m for 0.5 s, `enabled` false", "", "",
     lambda plant, detector: brake(plant, detector, 3000.0, 0.5), disabled),
    ("v_x and r stand for 1 s, `stale_after_s` 0.1", "", "",
     lambda plant, detector: stale(plant, detector, {"stale_after_s": 0.0}),
     lambda plant, detector: stale(plant, detector, {"stale_after_s": 0.1})),
    ("reversing, `v_x` signed", "", "",
     lambda plant, detector: reversing(detector, -1), lambda plant, detector: reversing(detector, 1)),
]  # fmt: skip


class Bench:
    """Designs, campaigns and FMUs of one table, in a folder of its own."""

    def __init__(self, steerguard, drives, folder):
        self.steerguard, self.drives, self.folder = steerguard, drives, folder
        self.fmu = cache(self.fmu)
        self.cost = cache(self.cost)
        self.design = cache(self.design)
        self.plant = None

    def new(self):
        return Path(tempfile.mkdtemp(dir=self.folder))

    def design(self, text):
        """Path of a design, and whether it is blind."""
        folder = self.new()
        spec, path = folder / "car.toml", folder / "design.json"
        spec.write_text(text + "\n", encoding="utf-8")
        command = [self.steerguard, "design", spec, "-o", path]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0 and not path.exists():
            raise RuntimeError(done.stderr)
        return path, done.returncode != 0

    def fmu(self, text):
        """The packaged detector; the plant beside it."""
        folder = self.new()
        design, _ = self.design(text)
        command = [self.steerguard, "package", design, "--allow", "blind", "-o", folder / "detector.fmu"]
        subprocess.run([*command, "--plant", folder / "plant.fmu"], check=True, stdout=subprocess.DEVNULL)
        self.plant = self.plant or Fmu(folder / "plant.fmu", folder / "plant")
        return Fmu(folder / "detector.fmu", folder / "detector")

    def campaign(self, text, *arguments):
        folder = self.new()
        design, _ = self.design(text)
        command = [self.steerguard, "campaign", design, "--allow", "blind", "--drives", str(self.drives), "-o", folder]
        subprocess.run([*command, *arguments], check=True, stdout=subprocess.DEVNULL)
        return json.loads((folder / "report.json").read_text(encoding="utf-8"))

    def drawn(self, text, arguments=()):
        """Drives with an alarm, and the largest J/J_th."""
        group = self.campaign(text, "--faults", "none", "--seed", "1", *arguments)["false_alarms"][0]
        return f"{group['drives_with_episodes']} of {group['drives']}, {group['largest_ratio']:.2f}"

    def driven(self, text, drives):
        detector = self.fmu(text)
        records = [records for records, _ in drives(self.plant, detector)]
        alarms = sum(bool(record["alarm"].any()) for record in records)
        return f"{alarms} of {len(records)}, {max(record['J_ratio'].max() for record in records):.2f}"

    def cost(self, text):
        """Smallest fault seen straight and in the turn, deg; misses and delays of 1 degree, s."""
        path, blind = self.design(text)
        courses = json.loads(path.read_text(encoding="utf-8"))["performance"]["sight"]["courses"]
        seen = {}
        for course in courses:
            size = course["seen_from_deg"]
            seen.setdefault(course["lateral_acceleration_m_per_s2"], []).append(float("inf") if size is None else size)
        sizes = " / ".join(f"{max(seen[lateral]):.2f}" for lateral in sorted(seen))
        found = self.campaign(text, "--faults", "bias", "--fault-deg", "1..1", "--seed", "2")["detections"][0]
        delays = [found[key] for key in ("delay_median_s", "delay_95_s")]
        shown = " / ".join("-" if delay is None else f"{delay:.2f}" for delay in delays)
        return f"{sizes}{', blind' if blind else ''} | {shown} | {found['missed']}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steerguard", type=Path, required=True)
    parser.add_argument("--drives", type=int, default=200)
    a = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(a.steerguard.resolve(), a.drives, folder)
        print("Drives with an alarm, and largest J/J_th, where the detector is not told and where it is.\n")
        print("| cause | not told | told | sees straight / turning, deg | 1 deg, median / 95 %, s | missed |")
        print("|---|---|---|---|---|---|")
        print(f"| none | | {bench.drawn('')} | {bench.cost('')} |", flush=True)
        for cause, text, arguments in DRAWN:
            counts = f"{bench.drawn('', arguments)} | {bench.drawn(text, arguments)}"
            print(f"| {cause} | {counts} | {bench.cost(text)} |", flush=True)
        for cause, without, with_key, not_told, told in DRIVEN:
            counts = f"{bench.driven(without, not_told)} | {bench.driven(with_key, told)}"
            print(f"| {cause} | {counts} | {bench.cost(with_key)} |", flush=True)
            if without:
                print(f"| the same without its key | | | {bench.cost(without)} |", flush=True)


if __name__ == "__main__":
    main()
