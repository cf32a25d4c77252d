"""The smallest fault that any detector could tell from what is stated: a bound by convex optimisation (method 12).

Two drives cannot be told apart where their measurements lie no further apart than the noise lets see. So the
largest fault f for which a sound car within the stated box (vehicle, bank, gusts, initial state) measures what
the faulty one does, up to `LAMBDA` standard deviations in all, is lost on every detector: two vehicles differ by
at most twice the box, one that knows its car by the box. A second-order cone programme, linearised along the manoeuvre.

Conventions
- State and derivative of told.py; the manoeuvre is that of the nominal car. SI; faults in deg.
- Gusts of any course within their bound: knots every 0.25 s; bank within its bound and 1 deg/s: every 0.5 s;
  straight lines between.
"""

import clarabel
import numpy as np
from scipy import sparse
from told import BANK, FAULT, GRAVITY, GUST, MASS, STATES

LAMBDA = 6.6  # standard deviations: missed and false alarms of 0.05 % each
GUST_KNOT_S, BANK_KNOT_S = 0.25, 0.5
BANK_RATE = np.radians(1.0) * GRAVITY  # m/s^3
STEERING_RATE = 0.3  # rad/s, of the calibration
WEAVE_HZ = 0.2
MANOEUVRES = ("straight", "weave", "turn")


def steering(manoeuvre, vehicle, speed, lateral, t):
    """Road-wheel angle over time t of a manoeuvre to so much lateral acceleration, rad."""
    v = vehicle.vehicle
    l_f, l_r = v["front_axle_distance_m"], v["rear_axle_distance_m"]
    c_f, c_r = v["front_cornering_stiffness_n_per_rad"], v["rear_cornering_stiffness_n_per_rad"]
    understeer = v["mass_kg"] * (c_r * l_r - c_f * l_f) / (2 * c_f * c_r * (l_f + l_r))
    angle = lateral * ((l_f + l_r) / speed**2 + understeer)
    omega = 2 * np.pi * WEAVE_HZ
    return {
        "straight": 0 * t,
        "weave": min(angle, STEERING_RATE / omega) * np.sin(omega * t),
        "turn": np.minimum(angle, STEERING_RATE * t),
    }[manoeuvre]


class Indistinguishable:
    """What a fault from the middle of a record on and everything stated does to the measurements of a manoeuvre."""

    def __init__(self, vehicle, noise, period, manoeuvre, speed, lateral=3.0, record_s=30.0):
        wind = vehicle.gust["speed_m_per_s"]
        gust = vehicle.gust["coefficient_n_s2_per_m2"] * wind * np.hypot(speed, wind) / vehicle.vehicle["mass_kg"]
        t = period * np.arange(round(record_s / period))
        self.gusts, self.banks = int(record_s / GUST_KNOT_S) + 2, int(record_s / BANK_KNOT_S) + 2
        if vehicle.bank == 0:
            self.banks = 0
        if gust == 0:
            self.gusts = 0
        columns = 1 + self.banks + self.gusts + 4 + 3
        self.bank_columns = slice(1, 1 + self.banks)
        gust_columns = slice(1 + self.banks, 1 + self.banks + self.gusts)
        parameter_columns = slice(gust_columns.stop, gust_columns.stop + 4)
        e = np.zeros((3, columns))
        e[:, -3:] = np.eye(3)
        x = np.zeros((1, STATES))
        x[0, 0] = speed
        shown = np.zeros((len(t), 2, columns))
        angles = steering(manoeuvre, vehicle, speed, lateral, t)
        v = vehicle.vehicle
        for k, now in enumerate(t):
            shown[k] = e[[0, 2]]
            hold = v["longitudinal_drag_n_m_s2_per_m2"] * speed**2
            torque = hold + v["effective_longitudinal_inertia_kg_m"] * (speed - x[0, 0])
            u = np.array([[torque, angles[k]]])
            A = vehicle.jacobian(x, u)[0]
            B = np.zeros((3, columns))
            B[:, 0] = (now >= record_s / 2) * A[:3, FAULT]
            for place, column, knot in [(self.bank_columns, BANK, BANK_KNOT_S), (gust_columns, GUST, GUST_KNOT_S)]:
                if place.stop > place.start:
                    index, share = divmod(now / knot, 1.0)
                    B[:, place.start + int(index)] += (1 - share) * A[:3, column]
                    B[:, place.start + int(index) + 1] += share * A[:3, column]
            B[:, parameter_columns] = A[:3, MASS:FAULT]
            a = period * A[:3, :3]
            e = e + a @ e + a @ (a @ e) / 2 + period * (B + a @ B / 2)
            middle = x + period / 2 * vehicle.derivative(x, u)
            x = x + period * vehicle.derivative(middle, u)
        rows = (shown / np.array(noise)[:, None]).reshape(-1, columns)
        rows[:, 0] *= np.pi / 180
        box = np.concatenate(
            [np.full(self.banks, vehicle.bank), np.full(self.gusts, gust), vehicle.parameters, [np.inf, 1.5, np.inf]]
        )
        self.bounded = np.isfinite(box) & (box > 0)
        scale = np.where(self.bounded, box, 1.0)
        rows[:, 1:] *= np.where(box == 0, 0.0, scale)
        self.factor = np.linalg.qr(rows, mode="r")
        self.bank_step = BANK_RATE * BANK_KNOT_S / vehicle.bank if vehicle.bank else 0.0

    def largest(self, boxes):
        """The largest fault that `boxes` times the box hides, deg."""
        columns = self.factor.shape[1]
        bounded = 1 + np.flatnonzero(self.bounded)
        within = sparse.csc_matrix(
            (np.ones(len(bounded)), (np.arange(len(bounded)), bounded)), shape=(len(bounded), columns)
        )
        blocks, sides = [within, -within], [np.full(2 * len(bounded), float(boxes))]
        if self.banks > 1:
            first = self.bank_columns.start
            steps = np.arange(self.banks - 1)
            change = sparse.csc_matrix(
                (
                    np.concatenate([np.ones(len(steps)), -np.ones(len(steps))]),
                    (np.concatenate([steps, steps]), np.concatenate([first + 1 + steps, first + steps])),
                ),
                shape=(len(steps), columns),
            )
            blocks += [change, -change]
            sides.append(np.full(2 * len(steps), boxes * self.bank_step))
        linear = sum(len(side) for side in sides)
        cone = sparse.vstack([sparse.csc_matrix((1, columns)), sparse.csc_matrix(-self.factor)])
        cost = np.zeros(columns)
        cost[0] = -1.0
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        solution = clarabel.DefaultSolver(
            sparse.csc_matrix((columns, columns)),
            cost,
            sparse.vstack([*blocks, cone]).tocsc(),
            np.concatenate([*sides, [LAMBDA], np.zeros(len(self.factor))]),
            [clarabel.NonnegativeConeT(linear), clarabel.SecondOrderConeT(1 + len(self.factor))],
            settings,
        ).solve()
        if str(solution.status) not in ("Solved", "AlmostSolved"):
            raise ArithmeticError(f"no limit: {solution.status}")
        return solution.x[0]
