"""The detector once more, from its equations, in numpy.

An independent statement of method 2, 3 and 6, which the packaged FMU is compared with.
Its numbers come from a design file, so a design file that does not mean what it says is found too.

Conventions
- Axes ISO 8855, SI units; sample k holds the measurement y = [v_x, r] and the input
  u = [T_eng, delta]; arrays have one row for each sample.
- The observer is a recursion and is written as one. Everything after it, from the window to the
  latch, is computed on whole arrays, episode by episode: an episode begins where the observer starts.

Behaviour stated here and nowhere in the equations
- A sample is valid if its four numbers are finite and smaller than 1e9. An invalid one holds all
  results, and the observer starts anew at the next valid sample.
- Outside S_x (measured v_x or r) no observer runs: residual, estimate and J are 0, no alarm.
- The observer starts, and alarms are given, from the first sample inside the armed range, which is
  S_x less a hysteresis. Start: z = M [v_x, 0, r]; the first sample of all may be given another z.
- An estimate of v_y outside its range ends the alarms while the observer goes on; it starts anew
  once estimate and measurement are back in the armed range.
"""

from dataclasses import dataclass

import numpy as np

STARTING, MONITORING, OUT_OF_RANGE, INVALID_INPUT = 1, 2, 3, 4
LARGEST_MAGNITUDE = 1e9
NO_ALARM_TIME = -1.0


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
    state: np.ndarray

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
            "state": self.state,
        }


def windowed_rms(norms, window):
    """RMS over the last `window` of `norms`; samples before the first count 0 (method 6)."""
    squares = np.concatenate([np.zeros(window - 1), np.square(norms)])
    windows = np.lib.stride_tricks.sliding_window_view(squares, window)
    return np.sqrt(windows.mean(axis=1))


@dataclass
class Uncertainty:
    """Bounds of `spec.uncertainty`: relative deviations, bank in m/s^2, gusts (method 6)."""

    mass: float
    yaw_inertia: float
    front: float
    rear: float
    bank: float
    gust_speed: float
    gust_coefficient: float
    gust_ahead: float

    @classmethod
    def of(cls, spec):
        def inertia(key):  # 1 / (1 + p) - 1
            return max(abs(100 / (100 + percent) - 1) for percent in spec[f"{key}_percent"])

        def stiffness(key):
            return max(abs(percent) for percent in spec[f"{key}_cornering_stiffness_percent"]) / 100

        return cls(
            inertia("mass"),
            inertia("yaw_inertia"),
            stiffness("front"),
            stiffness("rear"),
            9.80665 * np.sin(np.radians(spec["bank_deg"])),
            spec["gust_m_per_s"],
            0.5 * 1.2 * spec["frontal_area_m2"] * spec["side_force_per_rad"],
            spec["gust_acting_ahead_m"],
        )


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
        self.period = told["model"]["sampling_period_s"]

        ranges = [told["model"]["range"][name] for name in ("v_x", "v_y", "r")]
        self.bounds = np.array([[ends["min"], ends["max"]] for ends in ranges])
        self.hysteresis = np.array(told["hysteresis"])

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
        self.uncertainty_share = evaluation["uncertainty_share"]

        spec = design["spec"]
        self.euler_correction = spec["sampling"]["euler_correction"]
        self.uncertainty = Uncertainty.of(spec["uncertainty"])
        fault = spec["fault"][0]
        torque = fault["channel"] == "torque"
        smallest = fault["smallest_n_m"] if torque else np.radians(fault["smallest_deg"])
        self.smallest_fault = self.B[:, 0 if torque else 1] * smallest

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

    def slope(self, x, u):
        """x' of (1)-(2), and the axle forces, N."""
        v_x, v_y, r = x
        front = 2 * self.c_f * (u[1] - (v_y + self.l_f * r) / v_x)
        rear = 2 * self.c_r * (self.l_r * r - v_y) / v_x
        slope = [
            (u[0] - self.c_x * v_x**2) / self.longitudinal_inertia + v_y * r,
            (front + rear - self.c_y * v_y**2) / self.mass - v_x * r,
            (self.l_f * front - self.l_r * rear) / self.yaw_inertia,
        ]
        return np.array(slope), front, rear

    def jacobian(self, x, u):
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

    def deviations(self, x, u):
        """w of Euler's remainder, of each uncertainty, and of the smallest fault: 8 x 3."""
        slope, front, rear = self.slope(x, u)
        remainder = self.euler_correction * self.period**2 / 2 * self.jacobian(x, u) @ slope
        q, m, i_z = self.uncertainty, self.mass, self.yaw_inertia
        wind = q.gust_coefficient * q.gust_speed * np.hypot(x[0], q.gust_speed)
        along = np.array([slope[0] - x[1] * x[2], slope[1] + x[0] * x[2], 0])  # forces over masses
        uncertain = [
            q.mass * along,
            [0, 0, q.yaw_inertia * slope[2]],
            q.front * front * np.array([0, 1 / m, self.l_f / i_z]),
            q.rear * rear * np.array([0, 1 / m, -self.l_r / i_z]),
            [0, q.bank, 0],
            wind * np.array([0, 1 / m, q.gust_ahead / i_z]),
        ]
        return np.vstack([remainder, self.period * np.array(uncertain), self.smallest_fault])

    def run(self, y, u, *, threshold_factor=1.0, debounce=None, z_0=None):
        """The results of samples `y` (n x 2), `u` (n x 2); `z_0` starts the first sample."""
        y, u = np.asarray(y, dtype=float), np.asarray(u, dtype=float)
        valid, episode, armed, x_hat, responses = self._observe(y, u, z_0)
        return self._decide(
            y, valid, episode, armed, x_hat, responses, threshold_factor, debounce or self.debounce
        )

    def _observe(self, y, u, z_0):
        """Runs the observer.

        Returns for each sample: whether it is valid; the sample at which its observer started, or
        -1 where none runs; whether alarms are given; x^; and the error's responses (13) to the
        deviations since the start, n x 8 x 3.
        """
        n = len(y)
        with np.errstate(invalid="ignore"):
            valid = np.all(np.abs(np.hstack([y, u])) < LARGEST_MAGNITUDE, axis=1)
        v_x_r, v_y = self.bounds[[0, 2]], self.bounds[1]
        margin, v_y_margin = self.hysteresis[[0, 2]], self.hysteresis[1]
        inside = np.all((v_x_r[:, 0] <= y) & (y <= v_x_r[:, 1]), axis=1)
        well_inside = np.all((v_x_r[:, 0] + margin <= y) & (y <= v_x_r[:, 1] - margin), axis=1)

        episode = np.full(n, -1)
        armed = np.zeros(n, dtype=bool)
        x_hat, responses = np.zeros((n, 3)), np.zeros((n, 8, 3))
        z, start, is_armed, last_v_y = None, -1, False, 0.0
        for k in range(n):
            if not valid[k] or not inside[k]:
                z, start, is_armed = None, -1, False
                continue
            returned = v_y[0] + v_y_margin <= last_v_y <= v_y[1] - v_y_margin
            if not is_armed and well_inside[k] and (z is None or returned):
                given = k == 0 and z_0 is not None
                z = np.array(z_0) if given else self.M @ [y[k, 0], 0.0, y[k, 1]]
                start, is_armed = k, True
                response = np.zeros((8, 3))
            if z is not None:
                x_hat[k], z = self.observer_step(z, y[k], u[k])
                responses[k] = response
                n_of_h = np.tensordot(self.membership(y[k]), self.N, axes=1)
                w = self.deviations([y[k, 0], x_hat[k, 1], y[k, 1]], u[k])
                response = response @ n_of_h.T + w @ self.M.T
                last_v_y = x_hat[k, 1]
                is_armed = is_armed and bool(v_y[0] <= last_v_y <= v_y[1])
                episode[k], armed[k] = start, is_armed
        return valid, episode, armed, x_hat, responses

    def _decide(self, y, valid, episode, armed, x_hat, responses, factor, debounce):
        n = len(y)
        running = episode >= 0
        answers = responses @ self.C.T  # n x 8 x 2
        residual = np.where(running[:, None], y - x_hat @ self.C.T - answers[:, 0], 0.0)
        norms = np.linalg.norm(residual * self.weights, axis=1)
        sizes = np.linalg.norm(answers * self.weights, axis=2)
        j_rms, term, uncertain, fault = (np.zeros(n) for _ in range(4))
        for start in np.unique(episode[running]):
            samples = np.flatnonzero(episode == start)  # without a gap
            j_rms[samples] = windowed_rms(norms[samples], self.window)
            decay = self.start_up_decay ** np.arange(len(samples))
            term[samples] = self.start_up_amplitude * windowed_rms(decay, self.window)
            uncertain[samples] = windowed_rms(sizes[samples, 1:7].sum(axis=1), self.window)
            fault[samples] = windowed_rms(sizes[samples, 7], self.window)
        j_th = factor * (self.threshold + term + self.uncertainty_share * uncertain)

        exceeds = armed & (j_rms >= j_th)
        # Consecutive exceedances within an episode: sample number less that of the last without.
        numbers = np.arange(n)
        broken = ~exceeds | (numbers == episode)
        last_without = np.maximum.accumulate(
            np.where(broken, np.where(exceeds, numbers - 1, numbers), -1)
        )
        alarm = exceeds & (numbers - last_without >= debounce)
        state = np.where(armed, MONITORING, OUT_OF_RANGE)

        # Invalid samples show the results of the last valid one; before any, those of the start.
        held = np.maximum.accumulate(np.where(valid, numbers, -1))

        def shown(values, initial):
            return np.where((held >= 0).reshape(-1, *[1] * (values.ndim - 1)), values[held], initial)

        return Outputs(
            residual=shown(residual, 0.0),
            v_y_hat=shown(np.where(running, x_hat[:, 1], 0.0), 0.0),
            j_rms=shown(j_rms, 0.0),
            j_th=shown(j_th, factor * self.threshold),
            detectability=shown(fault / j_th, 0.0),
            alarm=shown(alarm, False),
            alarm_latched=np.maximum.accumulate(shown(alarm, False)),
            state=np.where(valid, state, INVALID_INPUT),
        )
