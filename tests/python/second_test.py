"""The second test once more, in numpy: augmented Kalman filter and likelihood ratio over onsets (method 9).

An independent statement, which the packaged FMU is compared with. The Jacobian is that of the slope by complex
steps, gains and covariances are the textbook's.

Conventions
- State [v_x, v_y, r, bank, gust, mass, yaw inertia, front, rear, ratio, offset, yaw-rate bias, speed scale].
- `samples` counts from the filter's start, at which neither innovation nor onset is looked at.
- A hypothesis [onset, errors, a, c]: a fault of one unit from `onset` on makes an error of the state; a / c explains
  most. Three each: 1 rad at the road wheel, 1 rad/s more yaw rate shown, the speed shown twice as large.
"""

import numpy as np

GRAVITY = 9.80665
V_X, V_Y, R, BANK, GUST, MASS, YAW_INERTIA, FRONT, REAR, RATIO, OFFSET, YAW_RATE_BIAS, SPEED_SCALE = range(13)
STATES = 13
LEARNED = [BANK, *range(MASS, STATES)]  # kept through a start
BANK_WALK, WALK = 2.0, 0.017  # of a bound, which counts as a standard deviation, per root of s
GUST_S = 0.5  # in which the gust walks by root 2 of its bound
SLOPE_NOISE, FORCE_NOISE = np.array([0.1, 0.03, 0.03]), 0.02
INITIAL_V_Y, INITIAL_SLIP = 0.1, 0.04  # at a start the rear axle slips by that
LOSS = 0.5  # share taken to be lost of what friction may take
LOST, LOST_V_Y, LOST_R = 200.0, 50.0, 20.0
SPACING_S, OLDEST_S = 0.05, 0.2
KNOWN_FOR_S = 10.0
LOOKS = 0.3  # of what bank and gust at their bounds look like
SETTLED_S = 0.2
CLEAR, GONE, RELEASE = 3.0, 0.2, 0.8
CLEAR_S = 0.1
STEPS = 4  # of the iteration for the angle behind a force that friction limits
YOUNG = 20  # samples at each of which an onset is looked at
CLEARER, CLEARER_BY = 12.0, 0.02
NOT_KNOWN, STEERING, YAW_RATE_SENSOR, SPEED_SENSOR, UNDECIDED = 1, 2, 3, 4, 5  # items of fault_hypothesis
LARGEST_FAULT = 1.6


def missing(x):
    """The share of a linear tyre's force that is missing where it asks for x times what friction holds."""
    square = x**2
    return square * (35 + square) / (105 + 45 * square + square**2)


class SecondTest:
    """Of a vehicle (the design file's), its uncertainty (reference.Uncertainty) and the file's `estimator`."""

    def __init__(self, vehicle, uncertainty, estimator, period):
        self.vehicle, self.uncertainty, self.period = vehicle, uncertainty, period
        self.threshold, self.estimate_factor = estimator["threshold"], estimator["estimate_factor"]
        self.noise = np.square(estimator["noise"])
        q = uncertainty
        bounds = np.zeros(STATES)
        bounds[LEARNED] = [
            q.bank, q.mass, q.yaw_inertia, q.front, q.rear,
            q.steering_ratio, q.steering_offset, q.yaw_rate_bias, q.v_x_scale,
        ]  # fmt: skip
        self.deviations = bounds
        self.spacing, self.oldest = max(int(SPACING_S / period + 0.5), 1), int(OLDEST_S / period)
        self.settled, self.known_for = int(SETTLED_S / period), int(KNOWN_FOR_S / period)
        self.clear_for = max(int(CLEAR_S / period), 1)
        self.forget()

    def forget(self):
        self.x, self.P = np.zeros(STATES), np.diag(self.deviations**2)
        self.restart()

    def restart(self):
        """What has been learned of bank and parameters stays."""
        self.samples, self.statistic, self.looks = 0, 0.0, 0.0
        self.hypotheses = []
        self.held = self.variance = self.largest = 0.0
        self.held_onset = self.held_since = self.clear = 0
        self.hypothesis = UNDECIDED

    def gust_force(self, v_x):
        wind = self.uncertainty.gust_speed
        return self.uncertainty.gust_coefficient * wind * np.sqrt(v_x**2 + wind**2)

    def gust_variance(self, v_x):
        return (self.gust_force(v_x) / self.vehicle["mass_kg"]) ** 2

    def looks_like(self, force, ahead):
        """The angle that a lasting side force, acting so far ahead, looks like, straight and steady."""
        v = self.vehicle
        l_f, l_r = v["front_axle_distance_m"], v["rear_axle_distance_m"]
        on_axles = force * np.array([l_r + ahead, l_f - ahead]) / (l_f + l_r)
        stiffnesses = [v["front_cornering_stiffness_n_per_rad"], v["rear_cornering_stiffness_n_per_rad"]]
        slips = on_axles / (2 * np.array(stiffnesses))
        return abs(slips[0] - slips[1])

    def slips(self, x, steering, fault):
        """Of both axles, with the road wheel off by `fault`, whatever the ratio."""
        v = self.vehicle
        v_x = x[V_X] if x[V_X].real > 0.1 else 0.1
        front = (1 + x[RATIO]) * steering + x[OFFSET] + fault
        front = front - (x[V_Y] + v["front_axle_distance_m"] * x[R]) / v_x
        return np.array([front, (v["rear_axle_distance_m"] * x[R] - x[V_Y]) / v_x])

    def linear(self, x, slips, loads):
        """Forces of axles on tyres without end."""
        v = self.vehicle
        stiffnesses = [v["front_cornering_stiffness_n_per_rad"], v["rear_cornering_stiffness_n_per_rad"]]
        return 2 * np.array(stiffnesses) * loads * (1 + x[[FRONT, REAR]]) * slips

    def taken(self, x, slips, loads):
        """What the least friction takes from them."""
        v = self.vehicle
        l_f, l_r = v["front_axle_distance_m"], v["rear_axle_distance_m"]
        held = self.uncertainty.friction * v["mass_kg"] * GRAVITY * np.array([l_r, l_f]) / (l_f + l_r)
        forces = self.linear(x, slips, loads)
        return forces * missing(forces / (held * loads))

    def axle_forces(self, x, slips, loads):
        return self.linear(x, slips, loads) - LOSS * self.taken(x, slips, loads)

    def slope(self, x, u, fault, loads):
        """d[v_x, v_y, r]/dt with the road wheel off by `fault`."""
        v, q = self.vehicle, self.uncertainty
        front, rear = self.axle_forces(x, self.slips(x, u[1], fault), loads)
        mass, inertia = v["mass_kg"] * (1 + x[MASS]), v["yaw_inertia_kg_m2"] * (1 + x[YAW_INERTIA])
        drive = u[0] - v["longitudinal_drag_n_m_s2_per_m2"] * x[V_X] ** 2
        drag = v["lateral_drag_n_s2_per_m2"] * x[V_Y] ** 2
        moment = v["front_axle_distance_m"] * front - v["rear_axle_distance_m"] * rear
        by_gust = q.gust_ahead * v["mass_kg"] / v["yaw_inertia_kg_m2"] * x[GUST]
        return np.array(
            [
                drive / (v["effective_longitudinal_inertia_kg_m"] * (1 + x[MASS])) + x[V_Y] * x[R],
                (front + rear - drag) / mass - x[V_X] * x[R] + x[BANK] + x[GUST],
                moment / inertia + by_gust,
            ]
        )

    def sample(self, y, u, behind, factor):
        """Takes in a sample: measurement, input, the slowest actuator's lag in angle."""
        starts = self.samples == 0
        if not starts and not self._update(y, factor):
            self.forget()
            starts = True
        if starts:
            self._start(y)
        self._predict(u, behind)

    def _start(self, y):
        kept = np.zeros(STATES)
        kept[LEARNED] = 1
        self.P = self.P * np.outer(kept, kept)
        self.x[[V_X, V_Y, R, GUST]] = y[0] / (1 + self.x[SPEED_SCALE]), 0, y[1] - self.x[YAW_RATE_BIAS], 0
        v_y = INITIAL_V_Y + INITIAL_SLIP * self.x[V_X]
        fresh = [self.noise[0], v_y**2, self.noise[1], self.gust_variance(self.x[V_X])]
        self.P[[V_X, V_Y, R, GUST], [V_X, V_Y, R, GUST]] = fresh

    def _update(self, y, factor):
        """Whether the filter goes on."""
        H = np.zeros((2, STATES))
        H[0, [V_X, SPEED_SCALE]] = 1 + self.x[SPEED_SCALE], self.x[V_X]
        H[1, [R, YAW_RATE_BIAS]] = 1
        shown = [(1 + self.x[SPEED_SCALE]) * self.x[V_X], self.x[R] + self.x[YAW_RATE_BIAS]]
        innovation = y - shown
        S = H @ self.P @ H.T + np.diag(self.noise)
        size = innovation @ np.linalg.solve(S, innovation)
        if not (size < LOST**2 and abs(self.x[V_Y]) < LOST_V_Y and abs(self.x[R]) < LOST_R):
            return False
        K = np.linalg.solve(S, H @ self.P).T
        directly = np.array([[0, 0], [0, 1], [self.x[V_X], 0]])
        self.x = self.x + K @ innovation
        self.P = self.P - K @ S @ K.T
        self.P = (self.P + self.P.T) / 2
        # Nothing is off by more than is stated, and what would take it there takes no error of it any further.
        bounds = np.where(np.arange(STATES) < BANK, np.inf, self.deviations)
        bounds[GUST] = np.sqrt(self.gust_variance(max(self.x[V_X], 0.1)))
        within = np.clip(self.x, -bounds, bounds)
        K[within != self.x] = 0
        self.x = within
        for hypothesis in self.hypotheses:
            for k in range(3):
                s = H @ hypothesis[1][k] + directly[k]
                hypothesis[2][k] += s @ np.linalg.solve(S, innovation)
                hypothesis[3][k] += s @ np.linalg.solve(S, s)
                hypothesis[1][k] -= K @ s
        q = self.uncertainty
        by_bank = self.looks_like(self.vehicle["mass_kg"] * q.bank, 0.0)
        self.looks = LOOKS * (by_bank + self.looks_like(self.gust_force(self.x[V_X]), q.gust_ahead))
        counts = self.likeliest([h for h in self.hypotheses if self.on_grid(h)])
        self.statistic = 0.0 if counts is None else self.statistic_of(counts)
        found = self.likeliest(self.hypotheses)
        limit = factor * self.threshold
        # What ends a fault that is known needs less than what begins one.
        ends = found is not None and found[2][0] * self.held < 0
        if self.statistic < (RELEASE * limit if ends else limit):
            self.clear = 0
            if self.largest == 0:
                self.hypothesis = UNDECIDED
            return True
        if self.largest == 0 and self.hypothesis == UNDECIDED:
            self.hypothesis = self.explanation()
        if abs(self.held + found[2][0] / found[3][0]) > LARGEST_FAULT:
            return False
        self.clear = self.clear + 1 if self.statistic >= CLEAR * limit else 0
        if self.samples - found[0] < self.settled and self.clear < self.clear_for:
            return True
        return not self._take_in(found, limit)

    def _take_in(self, found, limit):
        """Whether this step ends a fault that was known."""
        onset, error, a, c = found[0], found[1][0], found[2][0], found[3][0]
        self.x = self.x + a / c * error
        self.P = self.P + np.outer(error, error) / c
        further = self.largest > 0
        if not further:
            self.held_onset = onset
        self.held_since, self.clear = self.samples, 0
        self.held += a / c
        self.variance += 1 / c
        self.largest = max(self.largest, abs(self.held))
        self.hypotheses = []
        return further and abs(self.held) <= max(
            limit * (np.sqrt(self.variance) + self.looks), GONE * self.largest
        )

    def _predict(self, u, behind):
        v, q, t = self.vehicle, self.uncertainty, self.period
        l_f, l_r = v["front_axle_distance_m"], v["rear_axle_distance_m"]
        # No more is unknown than at first.
        variances = np.diag(self.P)
        scale = np.ones(STATES)
        largest = self.deviations**2
        largest[GUST] = self.gust_variance(max(self.x[V_X], 0.1))
        excess = (np.arange(STATES) >= BANK) & (variances > largest)
        scale[excess] = np.sqrt(largest[excess] / variances[excess])
        self.P = self.P * np.outer(scale, scale)

        drive = u[0] - v["longitudinal_drag_n_m_s2_per_m2"] * max(self.x[V_X], 0.1) ** 2
        a_x = drive / (v["effective_longitudinal_inertia_kg_m"] * (1 + self.x[MASS]))
        moved = a_x * v["centre_of_gravity_height_m"] / GRAVITY
        loads = np.array([max(1 - moved / l_r, 0.1), max(1 + moved / l_f, 0.1)])
        x, held = self.x, self.held
        A = np.empty((3, STATES))
        for k in range(STATES):
            step = x.astype(complex)
            step[k] += 1e-30j
            A[:, k] = self.slope(step, u, held, loads).imag / 1e-30
        slips = self.slips(x, u[1], held)
        forces = self.axle_forces(x, slips, loads)
        stiffnesses = self.axle_forces(x, slips + 1e-30j, loads).imag / 1e-30
        unknown = self.unknown_forces(stiffnesses, x[V_X])
        # Of a parameter's column the share that its force is known to: of the sum, the moment, front and rear slope.
        moment = l_f * forces[0] - l_r * forces[1]
        sums = [sum(forces) - v["lateral_drag_n_s2_per_m2"] * x[V_Y] ** 2, moment, *(stiffnesses * slips)]
        for k, force, variance in zip([MASS, YAW_INERTIA, FRONT, REAR], sums, unknown):
            A[1:, k] *= 1 - variance / force**2 if force**2 > variance else 0.0
        by_fault = self.slope(x.astype(complex), u, held + 1e-30j, loads).imag / 1e-30
        # The filter's steering offset and a fault act alike but for what the filter takes them for.
        F = t * A[:, :3]
        over = t * (np.eye(3) + F / 2 + F @ F / 6)
        Phi = np.eye(STATES)
        Phi[:3] += over @ A
        self.x = x.copy()
        self.x[:3] += over @ self.slope(x, u, held, loads)
        self.P = Phi @ self.P @ Phi.T
        self.P = (self.P + self.P.T) / 2
        self.P += self._noise(x, forces, self.taken(x, slips, loads), stiffnesses[0] * behind, loads, unknown)

        self.samples += 1
        explained = [self.explained(k) for k in range(3)]
        most = {self.hypotheses[int(np.argmax(x))][0] for x in explained if len(x) and max(x) > 0}
        self.hypotheses = [
            h for h in self.hypotheses
            if self.samples - h[0] <= (self.oldest if self.on_grid(h) or h[0] in most else min(YOUNG, self.oldest))
        ]  # fmt: skip
        for hypothesis in self.hypotheses:
            hypothesis[1] = hypothesis[1] @ Phi.T
            hypothesis[1][0, :3] += over @ by_fault
        self.hypotheses.append([self.samples, np.zeros((3, STATES)), np.zeros(3), np.zeros(3)])

    def on_grid(self, hypothesis):
        return hypothesis[0] % self.spacing == 0

    def explained(self, k):
        """a^2 / c of an explanation, by onset."""
        return [h[2][k] ** 2 / h[3][k] if h[3][k] > 0 else 0.0 for h in self.hypotheses]

    def explanation(self):
        """What explains clearly more since some onset than the others do since any."""
        most = np.array([max(self.explained(k), default=0.0) for k in range(3)])
        second, first = np.sort(most)[1:]
        if first - second < max(CLEARER, CLEARER_BY * first):
            return UNDECIDED
        return [STEERING, YAW_RATE_SENSOR, SPEED_SENSOR][int(np.argmax(most))]

    def unknown_forces(self, stiffnesses, v_x):
        """Variances of the axle forces' sum and moment, and of the front and the rear force, by those of v_y and r."""
        v = self.vehicle
        l_f, l_r = v["front_axle_distance_m"], v["rear_axle_distance_m"]
        front, rear = -stiffnesses[0] * np.array([1, l_f]), -stiffnesses[1] * np.array([1, -l_r])
        by_state = np.array([front + rear, l_f * front - l_r * rear, front, rear]) / max(v_x, 0.1)
        return np.diag(by_state @ self.P[V_Y : R + 1, V_Y : R + 1] @ by_state.T)

    def _noise(self, x, forces, taken, behind, loads, unknown):
        v, q, t = self.vehicle, self.uncertainty, self.period
        l_f, l_r = v["front_axle_distance_m"], v["rear_axle_distance_m"]
        mass, inertia = v["mass_kg"] * (1 + x[MASS]), v["yaw_inertia_kg_m2"] * (1 + x[YAW_INERTIA])
        lasting = np.abs((1 - LOSS) * taken) + np.abs(q.load_transfer * (loads - 1) * forces)
        intensities = (FORCE_NOISE * forces) ** 2 + lasting**2
        intensities[0] += behind**2
        # Products of what is unknown of a force and of its parameter.
        of_mass, of_inertia, of_front, of_rear = unknown * np.diag(self.P)[MASS : REAR + 1]
        intensities = [intensities[0] + of_front, intensities[1] + of_rear]
        by_force = np.array([[0, 0], [1 / mass, 1 / mass], [l_f / inertia, -l_r / inertia]])
        Q = np.zeros((STATES, STATES))
        Q[:3, :3] = t * (np.diag(SLOPE_NOISE**2) + by_force @ np.diag(intensities) @ by_force.T)
        Q[V_Y, V_Y] += t * of_mass / mass**2
        Q[R, R] += t * of_inertia / inertia**2
        Q[BANK, BANK] = t * (BANK_WALK * q.bank) ** 2
        Q[GUST, GUST] = t * 2 / GUST_S * self.gust_variance(max(x[V_X], 0.1))
        for k in range(MASS, STATES):
            Q[k, k] = t * (WALK * self.deviations[k]) ** 2
        return Q

    def likeliest(self, hypotheses):
        return max((h for h in hypotheses if h[3][0] > 0), key=self.statistic_of, default=None)

    def statistic_of(self, hypothesis):
        a, c = hypothesis[2][0], hypothesis[3][0]
        return abs(a / c) / (1 / np.sqrt(c) + self.looks)

    def slid(self, found):
        """What tyres that slide may hide of a fault that is found."""
        v, q = self.vehicle, self.uncertainty
        l_f, l_r = v["front_axle_distance_m"], v["rear_axle_distance_m"]
        held = q.friction * v["mass_kg"] * GRAVITY * l_r / (l_f + l_r)
        angle = found
        for _ in range(STEPS):
            left = 1 - missing(2 * v["front_cornering_stiffness_n_per_rad"] * angle / held)
            angle = min(found / left, LARGEST_FAULT)
        return angle - found

    def speaks(self, factor):
        known = self.largest > 0 and self.samples - self.held_since <= self.known_for
        return known or self.statistic >= factor * self.threshold

    def is_clear(self, factor):
        return not self.speaks(RELEASE * factor)

    def estimate(self, factor):
        """Fault, its bound, the samples since its onset and what it is, or None."""
        fault, variance, onset = self.held, self.variance, self.held_onset
        known = self.largest > 0
        if self.statistic >= factor * self.threshold and (found := self.likeliest(self.hypotheses)) is not None:
            fault, variance = fault + found[2][0] / found[3][0], variance + 1 / found[3][0]
            onset = onset if known else found[0]
        elif not known:
            return None
        disturbed = self.estimate_factor * (np.sqrt(variance) + self.looks)
        return fault, disturbed + self.slid(abs(fault)), self.samples - onset, self.hypothesis
