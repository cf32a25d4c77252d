"""The detector once more, from its equations, in numpy.

An independent statement of method 2, 3 and 6, which the packaged FMU is compared with.
Its numbers come from a design file, so a design file that does not mean what it says is found too.

Conventions
- Axes ISO 8855, SI units; sample k holds the measurement y = [v_x, r] and the input
  u = [T_eng, delta]; arrays have one row for each sample.
- Observer, reference motions, actuator and alarm are recursions and are written as such. What lies
  between is computed on whole arrays, episode by episode: an episode begins where the observer starts.

Behaviour stated here and nowhere in the equations
- A sample is valid if its four numbers lie within their limits. An invalid one holds all results;
  observer and reference motions start anew at the next valid sample. The actuator goes on, by the last
  valid command.
- Zeros of sensors are subtracted from what is valid.
- Outside S_x (measured v_x or r) no observer runs: residual, estimate and J are 0.
- The observer starts, and the residual is held against the threshold, from the first sample inside the
  armed range, which is S_x less a hysteresis. Start: z = M [v_x, 0, r]; the first sample of all may be
  given another z.
- An estimate of v_y outside its range ends the monitoring while the observer goes on; it starts anew
  once estimate and measurement are back in the armed range.
- Switched off, no observer runs, no alarm stands and no count is kept; reference motions go on.
- v_x and r both unchanged for longer than a stated time, v_x in its range, are stale: observer and
  window go on, detectability is 0. Where they then jump, or the command moved longer ago than that time,
  observer and motions start anew.
- Reference motions are followed while v_x lies in its range, from the first measurement on.
- Alarm by range: r or the estimate of v_y lies outside S_x and all reference motions, followed for more
  than a window, lie in the armed range.
- Samples that raise an alarm are counted; one that monitors without raising it ends the count, one that
  can tell nothing leaves it. An alarm ends once J has stayed below 0.8 J_th for a stated time, in
  consecutive samples that monitor; one that is invalid interrupts nothing.
- The second test (second_test.py) runs wherever the observer does and starts with it; it raises alarms, and
  keeps one from ending, in samples that monitor. The end of an alarm lets it forget everything.
"""

from dataclasses import dataclass

import numpy as np

from second_test import NOT_KNOWN, SecondTest

STARTING, MONITORING, OUT_OF_RANGE, INVALID_INPUT, DISABLED, STALE_INPUT = range(1, 7)
# Items of state_cause; an invalid or outlying signal has its own, in the order of the inputs.
NOTHING, SPEED, YAW_RATE, DRIVE_TORQUE, STEERING_ANGLE, LATERAL_SPEED, UNCHANGED, NOT_ENABLED = range(
    1, 9
)
NO_ALARM, RESIDUAL, RANGE, SECOND_TEST = 1, 2, 3, 4  # items of alarm_cause

LIMITS = np.array([150.0, 20.0, 1e6, 1.6])  # of v_x, r, T_eng, delta
LARGEST_ESTIMATE = 1e9
NO_ALARM_TIME = -1.0
GRAVITY = 9.80665
ACCELERATION_FILTER_S = 0.15
DRAWN_FROM, DRAW_PER_S = 0.6, 15.0  # of reference motions, by the critical speed
RELEASE = 0.8


@dataclass
class Outputs:
    """Results at each sample; arrays of length n, `residual` n x 2."""

    residual: np.ndarray
    v_y_hat: np.ndarray
    j_rms: np.ndarray
    j_th: np.ndarray
    detectability: np.ndarray
    alarm: np.ndarray
    alarm_latched: np.ndarray
    alarm_cause: np.ndarray
    state: np.ndarray
    state_cause: np.ndarray
    second_ratio: np.ndarray
    estimate: np.ndarray  # n x 4: fault, bound, onset's sample, what it is; NaN where there is none

    def first_alarm_sample(self):
        """Index of the sample that raised the first alarm, or None."""
        return int(np.argmax(self.alarm_latched)) if self.alarm_latched[-1] else None

    def columns(self, sampling_period_s, start_time_s=0.0):
        """Results by the names they have in the FMU."""
        first = self.first_alarm_sample()
        first_time = NO_ALARM_TIME if first is None else start_time_s + first * sampling_period_s
        return {
            "residual.v_x": self.residual[:, 0],
            "residual.r": self.residual[:, 1],
            "v_y_hat": self.v_y_hat,
            "J_rms": self.j_rms,
            "J_th": self.j_th,
            "J_ratio": self.j_rms / self.j_th,
            "detectability": self.detectability,
            "excited": self.detectability >= 1,
            "alarm": self.alarm,
            "alarm_latched": self.alarm_latched,
            "first_alarm_time": np.where(self.alarm_latched, first_time, NO_ALARM_TIME),
            "alarm_cause": self.alarm_cause,
            "state": self.state,
            "state_cause": self.state_cause,
            "second_ratio": self.second_ratio,
            "fault_estimate": np.nan_to_num(self.estimate[:, 0]),
            "fault_estimate_bound": np.nan_to_num(self.estimate[:, 1]),
            "fault_hypothesis": np.nan_to_num(self.estimate[:, 3], nan=NOT_KNOWN),
            "fault_onset_time": np.where(
                np.isnan(self.estimate[:, 2]),
                NO_ALARM_TIME,
                start_time_s + self.estimate[:, 2] * sampling_period_s,
            ),
        }


def windowed_rms(norms, window):
    """RMS over the last `window` of `norms`; samples before the first count 0 (method 6)."""
    squares = np.concatenate([np.zeros(window - 1), np.square(norms)])
    windows = np.lib.stride_tricks.sliding_window_view(squares, window)
    return np.sqrt(windows.mean(axis=1))


def within(values, ends):
    """Which `values` lie in the closed interval `ends`; NaN in none."""
    return (ends[0] <= values) & (values <= ends[1])


@dataclass
class Actuator:
    """Dead time, then a lag of limited speed, then end stops (method 2)."""

    lag: float
    delay: float
    rate_limit: float  # inf for none
    angle_limit: float

    def angles(self, commands, period):
        """Mean road-wheel angle of each sample; `commands` NaN where none was valid.

        Each sample's command is delayed, so two of them act in a sample: the earlier for the odd part
        of the dead time. The angle starts settled at the first command, and an invalid one leaves the
        last standing.
        """
        known = ~np.isnan(commands)
        if not known.any():
            return np.zeros(len(commands))
        begin = int(np.argmax(known))
        last = np.maximum.accumulate(np.where(known, np.arange(len(commands)), -1))
        acting = np.clip(commands[last[begin:]], -self.angle_limit, self.angle_limit)
        whole = int(self.delay / period)
        odd = self.delay - whole * period
        delayed = np.concatenate([np.full(whole + 1, acting[0]), acting])
        angle, means = acting[0], np.zeros(len(commands))
        for k in range(len(acting)):
            angle, before = self._turn(angle, delayed[k], odd)
            angle, after = self._turn(angle, delayed[k + 1], period - odd)
            means[begin + k] = (before + after) / period
        return means

    def _turn(self, angle, command, duration):
        """The angle after `duration` under a held command, and its integral.

        dx/dt = (command - x) / lag, at most the limit: a ramp while the distance exceeds limit times
        lag, an exponential from there on.
        """
        integral = 0.0
        distance = command - angle
        if np.isfinite(self.rate_limit) and abs(distance) > self.rate_limit * self.lag:
            ramp = min(abs(distance) / self.rate_limit - self.lag, duration)
            end = angle + np.sign(distance) * self.rate_limit * ramp
            integral, angle, duration = (angle + end) / 2 * ramp, end, duration - ramp
            distance = command - angle
        left = np.exp(-duration / self.lag) if self.lag > 0 else 0.0
        if duration > 0:
            integral += command * duration - distance * self.lag * (1 - left)
            angle = command - distance * left
        return angle, integral


@dataclass
class Uncertainty:
    """Bounds of `spec.uncertainty`: relative deviations, bank in m/s^2, gusts (method 6)."""

    mass: float
    yaw_inertia: float
    front: float
    rear: float
    friction: float  # inf for tyres without end
    load_transfer: float
    bank: float
    gust_speed: float
    gust_coefficient: float
    gust_ahead: float
    actuator_lag: float
    actuator_delay: float
    steering_ratio: float
    steering_offset: float
    yaw_rate_bias: float
    v_x_scale: float

    @classmethod
    def of(cls, spec):
        def inverse(key):  # 1 / (1 + p) - 1
            return max(abs(100 / (100 + percent) - 1) for percent in spec[f"{key}_percent"])

        def stiffness(key):
            return max(abs(percent) for percent in spec[f"{key}_cornering_stiffness_percent"]) / 100

        return cls(
            inverse("mass"),
            inverse("yaw_inertia"),
            stiffness("front"),
            stiffness("rear"),
            spec["friction"][0] if spec["friction"][0] < 10 else np.inf,
            spec["load_transfer_percent"] / 100,
            GRAVITY * np.sin(np.radians(spec["bank_deg"])),
            spec["gust_m_per_s"],
            0.5 * 1.2 * spec["frontal_area_m2"] * spec["side_force_per_rad"],
            spec["gust_acting_ahead_m"],
            spec["actuator_lag_s"],
            spec["actuator_delay_s"],
            inverse("steering_ratio"),
            np.radians(spec["steering_offset_deg"]),
            np.radians(spec["yaw_rate_bias_deg_per_s"]),
            spec["v_x_scale_percent"] / 100,
        )


@dataclass
class Followed:
    """Where reference motions are at each sample, and what the measured speed says beside.

    `motions` n x 3 x 2 is [v_y, r] before the sample's own command acts; `since` counts the samples that
    they are followed, 0 where they are not; `a_x` is the longitudinal acceleration.
    """

    motions: np.ndarray
    since: np.ndarray
    a_x: np.ndarray


@dataclass
class Observed:
    """What the observer gives at each sample.

    `episode` is the sample at which it started, -1 where none runs; `armed` whether it monitors; the
    rest is x^, what is known to depart from the model, and ||W_r r|| of uncertainties and fault.
    """

    episode: np.ndarray
    armed: np.ndarray
    x_hat: np.ndarray
    known: np.ndarray
    uncertain: np.ndarray
    fault: np.ndarray


class Reference:
    """The detector of a design file."""

    def __init__(self, design):
        told = design["detector"]
        vehicle = told["model"]["vehicle"]
        self.mass = vehicle["mass_kg"]
        self.yaw_inertia = vehicle["yaw_inertia_kg_m2"]
        self.longitudinal_inertia = vehicle["effective_longitudinal_inertia_kg_m"]
        self.l_f = vehicle["front_axle_distance_m"]
        self.l_r = vehicle["rear_axle_distance_m"]
        self.c_f = vehicle["front_cornering_stiffness_n_per_rad"]
        self.c_r = vehicle["rear_cornering_stiffness_n_per_rad"]
        self.c_x = vehicle["longitudinal_drag_n_m_s2_per_m2"]
        self.c_y = vehicle["lateral_drag_n_s2_per_m2"]
        self.height = vehicle["centre_of_gravity_height_m"]
        self.period = told["model"]["sampling_period_s"]

        ranges = [told["model"]["range"][name] for name in ("v_x", "v_y", "r")]
        self.bounds = np.array([[ends["min"], ends["max"]] for ends in ranges])
        self.hysteresis = np.array(told["hysteresis"])
        self.armed_bounds = self.bounds + np.outer(self.hysteresis, [1, -1])

        self.A = np.array([vertex["A"] for vertex in design["vertices"]])
        self.N, self.L, self.M, self.E = (
            np.array(told["gains"][k], dtype=float) for k in ("n", "l", "m", "e")
        )
        self.B, self.G, self.C = (np.array(design[k], dtype=float) for k in ("B", "G", "C"))
        self.G = self.G.reshape(3)
        self.corners = self._corners()

        evaluation = told["evaluation"]
        self.window = evaluation["window"]
        self.weights = np.array(evaluation["weights"], dtype=float)
        self.threshold = evaluation["threshold"]
        self.start_up_amplitude = evaluation["start_up_amplitude"]
        self.start_up_decay = evaluation["start_up_decay"]
        self.debounce = evaluation["debounce_samples"]
        self.alarm_hold_s = evaluation["alarm_hold_s"]
        self.uncertainty_share = evaluation["uncertainty_share"]
        staleness = told["staleness"]
        self.stale_after_s = staleness["after_s"]
        self.jumps = np.array([staleness["v_x_jump_m_per_s"], staleness["r_jump_rad_per_s"]])

        spec = design["spec"]
        self.euler_correction = spec["sampling"]["euler_correction"]
        self.uncertainty = q = Uncertainty.of(spec["uncertainty"])
        sensors, actuator = spec["sensors"], spec["actuator"]
        self.steering_offset = np.radians(sensors["steering_offset_deg"])
        self.yaw_rate_bias = np.radians(sensors["yaw_rate_bias_deg_per_s"])
        rate_limit = actuator["rate_limit_rad_per_s"]
        angle_limit = actuator["angle_limit_deg"]
        limits = (
            np.inf if rate_limit is None else rate_limit,
            np.inf if angle_limit is None else np.radians(angle_limit),
        )
        lag, delay = actuator["lag_s"], actuator["delay_s"]
        self.actuator = Actuator(lag, delay, *limits)
        self.slowest = Actuator(lag + q.actuator_lag, delay + q.actuator_delay, *limits)
        fault = spec["fault"][0]
        torque = fault["channel"] == "torque"
        smallest = fault["smallest_n_m"] if torque else np.radians(fault["smallest_deg"])
        self.smallest_fault = self.B[:, 0 if torque else 1] * smallest
        self.vehicle, self.estimator = vehicle, told["estimator"]

    def _corners(self):
        """Which corner of the premise box each rule is: rules x 2 booleans (v_x max, r max).

        Read from the matrices, A_12 = T_s r and A_22 = 1 - 2 T_s (C_f + C_r) / (M_v v_x), so that
        no order of the rules is assumed.
        """
        r = self.A[:, 0, 1] / self.period
        v_x = 2 * self.period * (self.c_f + self.c_r) / self.mass / (1 - self.A[:, 1, 1])
        found = np.stack([v_x, r], axis=1)
        low, high = self.bounds[[0, 2]].T
        corners = np.abs(found - high) < np.abs(found - low)
        np.testing.assert_allclose(found, np.where(corners, high, low), rtol=1e-10)
        assert len({tuple(c) for c in corners}) == 4, "the rules are not the four corners"
        return corners

    def membership(self, y):
        """h_i of (8), one for each rule: bilinear in (1/v_x, r)."""
        premise = np.array([1 / y[0], y[1]])
        at_min = np.array([1 / self.bounds[0, 0], self.bounds[2, 0]])
        at_max = np.array([1 / self.bounds[0, 1], self.bounds[2, 1]])
        share = (premise - at_min) / (at_max - at_min)  # 0 at the minimum of v_x, r; 1 at the maximum
        return np.prod(np.where(self.corners, share, 1 - share), axis=1)

    def consequent(self, y):
        """g(xi) of (5), corrected (method 1)."""
        v_x, r = y
        return self.period * np.array(
            [
                -self.c_x * v_x**2 / self.longitudinal_inertia,
                2 * (self.c_r * self.l_r - self.c_f * self.l_f) * r / (self.mass * v_x) - v_x * r,
                -2 * (self.c_f * self.l_f**2 + self.c_r * self.l_r**2) * r
                / (self.yaw_inertia * v_x),
            ]
        )

    def observer_step(self, z, y, u):
        """The observer (10): estimate x^ of this sample and z of the next."""
        h = self.membership(y)
        x_hat = z - self.E @ y
        blended = np.tensordot(h, self.N, axes=1) @ z + np.tensordot(h, self.L, axes=1) @ y
        z_next = blended + self.M @ (self.consequent(y) + self.B @ u + self.G * x_hat[1] ** 2)
        return x_hat, z_next

    def axle_forces(self, x, delta):
        """Of linear tyres at their static load, [front, rear] in N (2)."""
        v_x, v_y, r = x
        slip = [delta - (v_y + self.l_f * r) / v_x, (self.l_r * r - v_y) / v_x]
        return 2 * np.array([self.c_f, self.c_r]) * slip

    def by_forces(self, forces, mass=0.0, yaw_inertia=0.0):
        """x' of axle forces; of a vehicle lighter and easier to turn by these shares of 1/M_v, 1/I_z."""
        front, rear = forces
        lateral = (1 + mass) * (front + rear) / self.mass
        return np.array(
            [0, lateral, (1 + yaw_inertia) * (self.l_f * front - self.l_r * rear) / self.yaw_inertia]
        )

    def slope(self, x, u):
        """x' of (1)-(2)."""
        v_x, v_y, r = x
        along = (u[0] - self.c_x * v_x**2) / self.longitudinal_inertia
        turning = [along + v_y * r, -self.c_y * v_y**2 / self.mass - v_x * r, 0]
        return turning + self.by_forces(self.axle_forces(x, u[1]))

    def jacobian(self, x):
        """Of the slope by x; the axle forces depend on v_x by their slip angles."""
        v_x, v_y, r = x
        c_f, c_r, l_f, l_r = 2 * self.c_f / v_x, 2 * self.c_r / v_x, self.l_f, self.l_r
        front = c_f * np.array([(v_y + l_f * r) / v_x, -1, -l_f])
        rear = c_r * np.array([(v_y - l_r * r) / v_x, -1, l_r])
        drags = np.array([2 * self.c_x * v_x / self.longitudinal_inertia, 2 * self.c_y * v_y])
        return np.array(
            [
                [-drags[0], r, v_y],
                (front + rear - [0, drags[1], 0]) / self.mass - [r, 0, v_x],
                (l_f * front - l_r * rear) / self.yaw_inertia,
            ]
        )

    def load_transfer(self, forces, a_x):
        """x' of what cornering stiffness, in proportion to axle load, gains and loses (method 2)."""
        front, rear = forces
        moved = self.mass * a_x * self.height / (self.l_f + self.l_r)  # from front to rear, N
        static = self.mass * GRAVITY / (self.l_f + self.l_r) * np.array([self.l_r, self.l_f])
        return self.by_forces([-front * moved / static[0], rear * moved / static[1]])

    def loads(self, a_x):
        """Axle loads over the static ones."""
        moved = a_x * self.height / GRAVITY
        return np.maximum([1 - moved / self.l_r, 1 + moved / self.l_f], 0.1)

    def missing(self, forces):
        """Share of axle forces on tyres without end, at the static loads, that friction does not give.

        1 - tanh(s) / s by the convergent of tanh with s^4 below, which lies above.
        """
        static = self.mass * GRAVITY * np.array([self.l_r, self.l_f]) / (self.l_f + self.l_r)
        square = np.square(forces / (self.uncertainty.friction * static))
        return square * (35 + square) / (105 + 45 * square + square**2)

    def aside(self, v_x):
        """Axle forces that hold bank and gust at their bounds, on levers about the other axle."""
        q = self.uncertainty
        levers = np.abs([self.l_r + q.gust_ahead, self.l_f - q.gust_ahead])
        bank = self.mass * q.bank * np.array([self.l_r, self.l_f])
        return (bank + self.gust(v_x) * levers) / (self.l_f + self.l_r)

    def gust(self, v_x):
        q = self.uncertainty
        return q.gust_coefficient * q.gust_speed * np.hypot(v_x, q.gust_speed)

    def asked(self, v_x, torque):
        """Longitudinal acceleration that the drive torque asks for."""
        return (torque - self.c_x * v_x**2) / self.longitudinal_inertia

    @property
    def heaviest(self):
        """No bound takes more than nine tenths of 1/M' away."""
        return self.mass / max(1 - self.uncertainty.mass, 0.1)

    def critical_speed(self, factors):
        """Of the heaviest vehicle with its stiffnesses times `factors`, m/s; inf where it does not oversteer.

        There the linear single-track model has a real root at 0: M' v^2 (C_f l_f - C_r l_r) =
        2 C_f C_r L^2.
        """
        c_f, c_r = factors * np.array([self.c_f, self.c_r])
        oversteer = self.heaviest * (c_f * self.l_f - c_r * self.l_r)
        if oversteer <= 0:
            return np.inf
        return np.sqrt(2 * c_f * c_r * (self.l_f + self.l_r) ** 2 / oversteer)

    def lateral_model(self, v_x, mass, front, rear, draw):
        """A and B of [v_y, r]' = A [v_y, r] + B [delta, measured r], linear tyres (method 6)."""
        c_f, c_r, l_f, l_r = 2 * front * self.c_f, 2 * rear * self.c_r, self.l_f, self.l_r
        inertia = np.array([mass, self.yaw_inertia])
        by_slip = np.array([[c_f, c_r], [l_f * c_f, -l_r * c_r]]) / inertia[:, None]
        slip = np.array([[-1, -l_f], [-1, l_r]]) / v_x  # front, rear by v_y, r
        A = by_slip @ slip + [[0, -v_x], [0, -draw]]
        return A, np.array([[by_slip[0, 0], 0], [by_slip[1, 0], draw]])

    def follow(self, valid, y, torque, delta, jumped):
        """Reference motions, by the trapezoidal rule: nominal; front stiff, rear soft; the reverse.

        The last two are of the heaviest vehicle, with the most axle load transferred, on the least friction.
        """
        n, t = len(y), self.period
        motions, since, a_x = np.zeros((n, 3, 2)), np.zeros(n, dtype=int), np.zeros(n)
        q = self.uncertainty
        c_f, c_r = [1 - min(q.front, 0.9), 1 + q.front], [1 - min(q.rear, 0.9), 1 + q.rear]
        corners = np.array([(1, 1), (c_f[1], c_r[0]), (c_f[0], c_r[1])])
        masses = [self.mass, self.heaviest, self.heaviest]
        followed, x, filtered = 0, None, 0.0
        for k in range(n):
            v_x, r = y[k]
            if not valid[k] or not within(v_x, self.bounds[0]):
                followed = 0
                continue
            if followed == 0 or jumped[k]:
                followed, x, filtered = 0, np.array([[0.0, r]] * 3), v_x
            followed += 1
            motions[k], since[k] = x, followed
            # First-order filter, implicit Euler: (v - v_f+) / tau is the acceleration.
            smoothed = (ACCELERATION_FILTER_S * filtered + t * v_x) / (ACCELERATION_FILTER_S + t)
            a_x[k] = (v_x - filtered) / (ACCELERATION_FILTER_S + t)
            filtered = smoothed
            # Cornering stiffness goes with axle load, which the driver moves: not what a fault slows down.
            asked = self.asked(v_x, torque[k])
            driven = np.clip(a_x[k], min(asked, 0), max(asked, 0))
            transfers = np.array([1, 1 + q.load_transfer, 1 + q.load_transfer]) * driven
            factors = corners * [self.loads(a) for a in transfers]
            for i in [1, 2]:
                forces = corners[i] * self.axle_forces(np.array([v_x, *x[i]]), delta[k])
                factors[i] *= 1 - self.missing(np.abs(forces) + self.aside(v_x))
            near = v_x / self.critical_speed(factors[1])
            draw = DRAW_PER_S * np.clip((near - DRAWN_FROM) / (1 - DRAWN_FROM), 0, 1)
            for i, stiffness in enumerate(factors):
                A, B = self.lateral_model(v_x, masses[i], *stiffness, draw)
                half = t / 2 * A
                right = (np.eye(2) + half) @ x[i] + t * B @ [delta[k], r]
                x[i] = np.linalg.solve(np.eye(2) - half, right)
        return Followed(motions, since, a_x)

    def along(self, x, u, a_x, modelled):
        """x' that each cause adds which acts where a vehicle that obeys would be: 6 x 3.

        `modelled` are the axle forces at which the known transfer of axle load is taken.
        """
        q = self.uncertainty
        at_rest = self.axle_forces(x, u[1])
        forces = at_rest * self.loads(a_x)
        aside = self.aside(x[0])
        missing = (np.abs(at_rest) + aside) * self.missing(np.abs(at_rest) + aside) * self.loads(a_x)
        # What forces and torque do.
        drag = np.array([0, self.c_y * x[1] ** 2 / self.mass, 0])
        slope = [self.asked(x[0], u[0]), 0, 0] + self.by_forces(forces) - drag
        unknown = q.load_transfer * abs(a_x) + abs(self.asked(x[0], u[0]) - a_x)

        def of(front, rear):
            return self.by_forces([front, rear], q.mass, q.yaw_inertia)

        return np.array(
            [
                q.mass * slope * [1, 1, 0],
                q.yaw_inertia * slope * [0, 0, 1],
                of(q.front * forces[0], 0),
                of(0, q.rear * forces[1]),
                of(*-np.where(at_rest > 0, missing, -missing)),
                self.load_transfer(at_rest - modelled, a_x)
                + self.load_transfer(at_rest, -unknown if a_x < 0 else unknown),
            ]
        )

    def common(self, x, delta, behind, a_x):
        """Likewise of each that acts wherever the vehicle is: 7 x 3.

        `behind` is the angle of the slowest actuator less that of the actuator.
        """
        q = self.uncertainty
        gust, hold, loads = self.gust(x[0]), self.aside(x[0]), self.loads(a_x)

        def of(front, rear):
            return self.by_forces([front, rear], q.mass, q.yaw_inertia)

        def turned(angle):
            return of(2 * self.c_f * angle, 0)

        # Tyre and load make the stiffness another.
        other = [q.front, q.rear] * loads + np.abs(loads - 1)
        push = gust * np.array([0, 1 / self.mass, q.gust_ahead / self.yaw_inertia])
        return np.array(
            [
                [0, q.bank, 0],
                push * [0, 1 + q.mass, 1 + q.yaw_inertia],
                turned(behind),
                turned(q.steering_ratio * delta),
                turned(q.steering_offset),
                of(other[0] * hold[0], 0),
                of(0, other[1] * hold[1]),
            ]
        )

    def sensed(self, v_x):
        """What each cause that acts on the measurement adds to it: 2 x 2."""
        return np.array([[0, self.uncertainty.yaw_rate_bias], [self.uncertainty.v_x_scale * v_x, 0]])

    def sizes(self, e):
        """||W_r C e|| along the last axis of `e`."""
        return np.linalg.norm(e @ self.C.T * self.weights, axis=-1)

    def run(
        self,
        y,
        u,
        *,
        enabled=None,
        threshold_factor=1.0,
        debounce=None,
        alarm_hold_s=None,
        steering_offset=None,
        yaw_rate_bias=None,
        stale_after_s=None,
        z_0=None,
    ):
        """The results of samples `y` (n x 2), `u` (n x 2), `enabled` (n); `z_0` starts the first sample."""

        def chosen(given, own):
            return own if given is None else given

        y, u = np.array(y, dtype=float), np.array(u, dtype=float)
        enabled = np.ones(len(y), dtype=bool) if enabled is None else np.asarray(enabled, dtype=bool)
        signals = np.hstack([y, u])
        with np.errstate(invalid="ignore"):
            proper = np.abs(signals) <= LIMITS
        valid = proper.all(axis=1)
        y[:, 1] -= chosen(yaw_rate_bias, self.yaw_rate_bias)
        command = np.where(proper[:, 3], u[:, 1], np.nan)
        command -= chosen(steering_offset, self.steering_offset)
        u[:, 1] = self.actuator.angles(command, self.period)
        behind = self.slowest.angles(command, self.period) - u[:, 1]
        stale, jumped = self._compare(valid, y, command, chosen(stale_after_s, self.stale_after_s))
        followed = self.follow(valid, y, u[:, 0], u[:, 1], jumped)
        runs = valid & enabled
        observed = self._observe(runs, jumped, y, u, behind, followed, z_0)
        invalid_signal = SPEED + np.argmin(proper, axis=1)
        return self._decide(
            valid,
            invalid_signal,
            enabled,
            stale,
            y,
            followed,
            observed,
            (u, behind),
            threshold_factor,
            chosen(debounce, self.debounce),
            chosen(alarm_hold_s, self.alarm_hold_s),
        )

    def _compare(self, valid, y, command, after_s):
        """Which samples are stale, and which end that with a jump or after steering without an answer."""
        n = len(y)
        stale, jumped = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool)
        # An inadmissible command leaves the last one standing.
        told = np.maximum.accumulate(np.where(np.isnan(command), 0, np.arange(n)))
        steered = np.append(False, command[told[1:]] != command[told[:-1]])
        unchanged, last, moved = 0, None, None
        for k in np.flatnonzero(valid):
            if k > 0 and not valid[k - 1]:
                unchanged, moved = 0, None
            here = within(y[k, 0], self.bounds[0])
            if last is not None and y[k].tobytes() == last.tobytes():
                unchanged += 1
                if moved is None and steered[k]:
                    moved = k
            else:
                was_stale = 0 < after_s < unchanged * self.period
                unanswered = moved is not None and after_s < (k - moved) * self.period
                leaps = unanswered or (last is not None and (np.abs(y[k] - last) > self.jumps).any())
                jumped[k] = here and was_stale and leaps
                unchanged, moved = 0, None
            stale[k] = here and 0 < after_s < unchanged * self.period
            last = y[k]
        return stale, jumped

    def _observe(self, runs, jumped, y, u, behind, followed, z_0):
        """Runs the observer, and beside it what the error answers to deviations (13)."""
        n = len(y)
        inside = within(y[:, 0], self.bounds[0]) & within(y[:, 1], self.bounds[2])
        well_inside = within(y[:, 0], self.armed_bounds[0]) & within(y[:, 1], self.armed_bounds[2])

        episode = np.full(n, -1)
        armed = np.zeros(n, dtype=bool)
        x_hat, known = np.zeros((n, 3)), np.zeros((n, 3))
        uncertain, fault = np.zeros(n), np.zeros(n)
        z, start, is_armed, last_v_y = None, -1, False, 0.0
        for k in range(n):
            if jumped[k]:
                z, is_armed = None, False
            if not runs[k] or not inside[k]:
                z, is_armed = None, False
                continue
            returned = within(last_v_y, self.armed_bounds[1])
            if not is_armed and well_inside[k] and (z is None or returned):
                given = k == 0 and z_0 is not None
                z = np.array(z_0) if given else self.M @ [y[k, 0], 0.0, y[k, 1]]
                start, is_armed = k, True
                response = Responses()
            if z is None:
                continue
            x_hat[k], z_next = self.observer_step(z, y[k], u[k])
            if np.abs(x_hat[k]).max() >= LARGEST_ESTIMATE:
                z, is_armed, last_v_y = None, False, 0.0
                continue
            z, last_v_y = z_next, x_hat[k, 1]
            known[k], fault[k] = response.known, self.sizes(response.fault)
            uncertain[k] = self._bound(response, y[k, 0])
            self._respond(response, x_hat[k, 1], y[k], u[k], behind[k], followed, k)
            is_armed = is_armed and bool(within(last_v_y, self.bounds[1]))
            episode[k], armed[k] = start, is_armed
        return Observed(episode, armed, x_hat, known, uncertain, fault)

    def _bound(self, response, v_x):
        """What the uncertainties can do to ||W_r r|| at most: of the motions the one where it is most."""
        shown = self.sensed(v_x) @ (self.E + self.C.T).T
        return (
            self.sizes(response.along).sum(axis=1).max()
            + self.sizes(response.common).sum()
            + self.sizes(response.sensed + shown).sum()
        )

    def _respond(self, response, v_y, y, u, behind, followed, k):
        """Takes the responses on by sample `k`."""
        t, x = self.period, np.array([y[0], v_y, y[1]])
        h = self.membership(y)
        N, L = np.tensordot(h, self.N, axes=1), np.tensordot(h, self.L, axes=1)
        J = self.jacobian(x)
        # Second-order hold: a slope d over a period leaves T_s d + T_s^2 / 2 J d.
        held = self.M @ (np.eye(3) + self.euler_correction * t / 2 * J)
        motions = [np.array([y[0], *motion]) for motion in followed.motions[k]]
        modelled, a_x = self.axle_forces(motions[0], u[1]), followed.a_x[k]
        transfer = self.load_transfer(modelled, a_x)
        remainder = self.euler_correction * t**2 / 2 * J @ self.slope(x, u)
        along = np.array([self.along(motion, u, a_x, modelled) for motion in motions])
        common = self.common(x, u[1], behind, a_x)
        # The premise is measured too: K = T_s times the columns of J by what is measured (method 5).
        K = t * J @ self.C.T
        error = self.sensed(y[0])
        response.known = N @ response.known + self.M @ remainder + held @ (t * transfer)
        response.along = response.along @ N.T + t * along @ held.T
        response.common = response.common @ N.T + t * common @ held.T
        response.sensed = response.sensed @ N.T - error @ (L + self.M @ K).T
        response.fault = N @ response.fault + held @ self.smallest_fault

    def _decide(
        self, valid, invalid_signal, enabled, stale, y, followed, observed, steered, factor, debounce, hold_s
    ):
        n = len(valid)
        episode, armed = observed.episode, observed.armed
        running = episode >= 0
        residual = (y - observed.x_hat @ self.C.T) - observed.known @ self.C.T
        residual = np.where(running[:, None], residual, 0.0)
        norms = np.linalg.norm(residual * self.weights, axis=1)
        j_rms, term, uncertain, fault = (np.zeros(n) for _ in range(4))
        for start in np.unique(episode[running]):
            samples = np.flatnonzero(episode == start)  # without a gap
            j_rms[samples] = windowed_rms(norms[samples], self.window)
            decay = self.start_up_decay ** np.arange(len(samples))
            term[samples] = self.start_up_amplitude * windowed_rms(decay, self.window)
            uncertain[samples] = windowed_rms(observed.uncertain[samples], self.window)
            fault[samples] = windowed_rms(observed.fault[samples], self.window)
        j_th = factor * (self.threshold + term + self.uncertainty_share * uncertain)
        v_y_hat = np.where(running, observed.x_hat[:, 1], 0.0)
        monitors = armed & ~stale

        # The first that holds is the state, and its cause.
        place = np.column_stack([y[:, 0], y[:, 1], v_y_hat])
        outside = [
            (~within(place[:, i], bounds[j]), cause)
            for bounds in (self.bounds, self.armed_bounds)
            for i, (j, cause) in enumerate([(0, SPEED), (2, YAW_RATE), (1, LATERAL_SPEED)])
        ]
        conditions = [
            (~valid, INVALID_INPUT, invalid_signal),
            (~enabled, DISABLED, NOT_ENABLED),
            (stale, STALE_INPUT, UNCHANGED),
            (armed, MONITORING, NOTHING),
            *((left, OUT_OF_RANGE, cause) for left, cause in outside),
        ]
        holds, states, causes = zip(*conditions)
        state = np.select(holds, states, OUT_OF_RANGE)
        state_cause = np.select(holds, causes, NOTHING)

        left = ~within(y[:, 1], self.bounds[2]) | ~within(v_y_hat, self.bounds[1])
        obedient = within(followed.motions, self.armed_bounds[1:].T)
        astray = left & ~stale & (followed.since > self.window) & obedient.all(axis=(1, 2))
        second = self.estimator and SecondTest(self.vehicle, self.uncertainty, self.estimator, self.period)
        told = (y, *steered, episode)
        alarm_cause, second_ratio, estimate = self._alarms(
            ~valid, enabled, monitors, monitors & (j_rms >= j_th), astray,
            monitors & (j_rms < RELEASE * j_th), debounce, hold_s, second, told, factor,
        )  # fmt: skip

        # Invalid samples show the results of the last valid one; before any, those of the start.
        held = np.maximum.accumulate(np.where(valid, np.arange(n), -1))

        def shown(values, initial):
            return np.where((held >= 0).reshape(-1, *[1] * (values.ndim - 1)), values[held], initial)

        return Outputs(
            residual=shown(residual, 0.0),
            v_y_hat=shown(v_y_hat, 0.0),
            j_rms=shown(j_rms, 0.0),
            j_th=shown(j_th, factor * self.threshold),
            detectability=shown(np.where(stale, 0.0, fault / j_th), 0.0),
            alarm=alarm_cause != NO_ALARM,
            alarm_latched=np.logical_or.accumulate(alarm_cause != NO_ALARM),
            alarm_cause=alarm_cause,
            state=state,
            state_cause=state_cause,
            second_ratio=second_ratio,
            estimate=estimate,
        )

    def _alarms(
        self, unseen, enabled, monitors, exceeds, astray, sunk, debounce, hold_s, second, told, factor
    ):
        """alarm_cause at each sample: debounced, held and released; what the second test says beside."""
        causes, count, clear, cause = np.full(len(unseen), NO_ALARM), 0, 0, NO_ALARM
        ratios, ratio = np.zeros(len(unseen)), 0.0
        estimates, estimate = np.full((len(unseen), 4), np.nan), None
        y, u, behind, episode = told
        for k in range(len(unseen)):
            if not unseen[k]:
                speaks, is_clear, ratio, latest = False, True, 0.0, None
                if second and enabled[k] and episode[k] >= 0:
                    if episode[k] == k:
                        second.restart()
                    second.sample(y[k], u[k], behind[k], factor)
                    if monitors[k]:
                        speaks, is_clear = second.speaks(factor), second.is_clear(factor)
                        ratio, latest = second.statistic / (factor * second.threshold), second.estimate(factor)
                raises = exceeds[k] or astray[k] or speaks
                if not enabled[k]:
                    count, clear, cause = 0, 0, NO_ALARM
                elif raises:
                    count += 1
                elif monitors[k]:
                    count = 0
                if cause == NO_ALARM:
                    if enabled[k] and raises and count >= debounce:
                        cause = RESIDUAL if exceeds[k] else RANGE if astray[k] else SECOND_TEST
                        clear = 0
                else:
                    ends = sunk[k] and is_clear
                    clear = clear + 1 if ends else 0
                    if ends and clear * self.period >= hold_s:
                        cause = NO_ALARM
                        if second:
                            second.forget()
                if cause == NO_ALARM:
                    estimate = None
                elif latest:
                    fault, bound, age, what = latest
                    estimate = fault, bound, max(k - age, 0), what
            causes[k], ratios[k] = cause, ratio
            if estimate:
                estimates[k] = estimate
        return causes, ratios, estimates


class Responses:
    """What the error answers to each deviation since the observer's start, in m/s, m/s, rad/s.

    `sensed` is e - E times the measurement's error.
    """

    def __init__(self):
        self.known, self.fault = np.zeros(3), np.zeros(3)
        self.along, self.common, self.sensed = np.zeros((3, 6, 3)), np.zeros((7, 3)), np.zeros((2, 3))
