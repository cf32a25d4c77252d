"""Records the inputs of the frozen traces: drives of the vehicle in each stored configuration.

    python3 tests/replay/record.py CONFIGURATION...     (folders of tests/replay/recorded)

Once recorded, inputs stay as they are: the traces show what changes in the detector. Run it for a
configuration that is new, and then `cargo run --release -p steerguard-replay -- --renew`.

Nothing but the standard library, and no code in common with the detector. Sensors are rounded as
real ones are, which also keeps the files small.
"""

import json
import math
import random
import sys
from pathlib import Path

RECORDED = Path(__file__).parent / "recorded"
HEADER = "v_x_m_per_s,r_rad_per_s,t_eng_n_m,delta_rad"
SUBSTEPS = 8


class Car:
    """The nonlinear vehicle (1)-(3) of method 1 with linear tyres, on RK4."""

    def __init__(self, model, v_x):
        self.data = model["vehicle"]
        self.period = model["sampling_period_s"]
        self.x = [v_x, 0.0, 0.0]

    def slope(self, x, t_eng, delta, push):
        c = self.data
        v_x, v_y, r = x
        l_f, l_r = c["front_axle_distance_m"], c["rear_axle_distance_m"]
        front = 2 * c["front_cornering_stiffness_n_per_rad"] * (delta - (v_y + l_f * r) / v_x)
        rear = 2 * c["rear_cornering_stiffness_n_per_rad"] * (l_r * r - v_y) / v_x
        drag = c["lateral_drag_n_s2_per_m2"] * v_y * v_y
        along = t_eng - c["longitudinal_drag_n_m_s2_per_m2"] * v_x * v_x
        return [
            along / c["effective_longitudinal_inertia_kg_m"] + v_y * r,
            (front + rear - drag) / c["mass_kg"] - v_x * r + push,
            (l_f * front - l_r * rear) / c["yaw_inertia_kg_m2"],
        ]

    def step(self, t_eng, delta, push):
        def along(slope, h):
            return [x + h * s for x, s in zip(self.x, slope)]

        h = self.period / SUBSTEPS
        for _ in range(SUBSTEPS):
            k_1 = self.slope(self.x, t_eng, delta, push)
            k_2 = self.slope(along(k_1, h / 2), t_eng, delta, push)
            k_3 = self.slope(along(k_2, h / 2), t_eng, delta, push)
            k_4 = self.slope(along(k_3, h), t_eng, delta, push)
            slope = [(a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(k_1, k_2, k_3, k_4)]
            self.x = along(slope, h)

    def torque(self, v_x, gain=1.0):
        """Holds `v_x`, m/s."""
        c = self.data
        return (
            c["longitudinal_drag_n_m_s2_per_m2"] * v_x * v_x
            + c["effective_longitudinal_inertia_kg_m"] * gain * (v_x - self.x[0])
        )

    def angle(self, r):
        """Road-wheel angle of a steady turn at yaw rate `r`, rad."""
        c, v_x = self.data, self.x[0]
        l_f, l_r = c["front_axle_distance_m"], c["rear_axle_distance_m"]
        c_f = 2 * c["front_cornering_stiffness_n_per_rad"]
        c_r = 2 * c["rear_cornering_stiffness_n_per_rad"]
        understeer = c["mass_kg"] * (l_r * c_r - l_f * c_f) / ((l_f + l_r) * c_f * c_r)
        return r * ((l_f + l_r) / v_x + understeer * v_x)


def weave(t, hz=0.3):
    return math.sin(2 * math.pi * hz * t)


def fault(car, range_, part, t):
    """Start, straight, weave, a steering fault of 1.2 degrees that comes and goes, braking."""
    fast = 0.6 * range_["v_x"]["max"]
    a_y = 2.0 if 0.15 <= part < 0.35 else 0.0
    command = car.angle(a_y / car.x[0]) * weave(t)
    bias = math.radians(1.2) if 0.45 <= part < 0.65 else 0.0
    target = fast if part < 0.8 else 0.5 * fast
    return car.torque(target), command, command + bias, lambda y: y


def edges(car, range_, part, t):
    """Below the range, into it, out in yaw rate, speed and estimate, and signals that are lost."""
    low, high = range_["v_x"]["min"], range_["v_x"]["max"]
    command = wheel = car.angle(0.5 / car.x[0]) * weave(t)
    measured = lambda y: y
    if 0.25 <= part < 0.32:
        command = wheel = car.angle(1.2 * range_["r"]["max"])
    elif 0.45 <= part < 0.48:
        measured = lambda y: [1.1 * high, y[1]]  # the speed sensor reads too much
    elif 0.55 <= part < 0.62:
        command = 1.59  # which the wheel does not follow
    elif 0.72 <= part < 0.725:
        measured = lambda y: [math.nan, y[1]]
    elif 0.77 <= part < 0.775:
        measured = lambda y: [y[0], math.inf]
    elif 0.82 <= part < 0.825:
        command = math.nan
    elif 0.87 <= part < 0.872:
        command = -2e9
    elif 0.9 <= part:
        wheel = command - math.radians(3.0)
    target = 0.7 * low if part < 0.05 else 1.6 * low
    return car.torque(target, gain=4.0), command, wheel, measured


def record(folder, name, drive, v_x_share, duration_s):
    model = json.loads((folder / "configuration.json").read_text())["model"]
    range_ = model["range"]
    chance = random.Random(f"{folder.name}/{name}")
    car = Car(model, v_x_share * range_["v_x"]["min"])
    lines = [HEADER]
    samples = round(duration_s / car.period)
    for k in range(samples):
        t = k * car.period
        t_eng, command, wheel, measured = drive(car, range_, k / samples, t)
        v_x, r = measured(
            [car.x[0] + chance.gauss(0, 0.01), car.x[2] + chance.gauss(0, 0.0005)]
        )
        lines.append(f"{v_x:.4f},{r:.6f},{t_eng:.2f},{command:.6f}".replace("nan", "NaN"))
        gust = 0.05 * math.sin(2 * math.pi * 0.11 * t + 1.0)
        car.step(round(t_eng, 2), 0.0 if math.isnan(wheel) else wheel, gust)
    (folder / f"{name}.inputs.csv").write_text("\n".join(lines) + "\n")


def main():
    for name in sys.argv[1:]:
        folder = RECORDED / name
        period = json.loads((folder / "configuration.json").read_text())["model"][
            "sampling_period_s"
        ]
        duration_s = 1600 * max(period, 0.01)
        record(folder, "fault", fault, 3.0, duration_s)
        record(folder, "edges", edges, 0.7, duration_s)


if __name__ == "__main__":
    main()
