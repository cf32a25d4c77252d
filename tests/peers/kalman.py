"""An extended Kalman filter of the single-track model, and the two tests on its innovation.

Conventions
- Model: (1)-(2) of method 1, of the vehicle that the design knows, with the input
  held over a sampling period. State x = [v_x, v_y, r], input u = [T_eng, delta], measurement
  y = [v_x, r]; SI units.
- All drives at once: arrays have a leading axis for the drives (D), records one before it for the
  samples (T). filterpy's filter, which this one is tested against, takes one drive and one sample
  at a time, and so about 80 times as long.
- NIS: normalised innovation squared, Bar-Shalom, Li and Kirubarajan (2001), 5.4. CUSUM: Page
  (1954), two-sided, on the normalised innovation of the yaw rate, where a steering fault shows.
"""

from dataclasses import dataclass

import numpy as np

H = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
INITIAL_V_Y_STD = 0.5  # m/s
SLOWEST = 1.0  # m/s: the model divides by v_x, also while nobody looks at the result


@dataclass(frozen=True)
class Vehicle:
    """The single-track model of a design's vehicle, continuous."""

    mass: float
    yaw_inertia: float
    longitudinal_inertia: float
    l_f: float
    l_r: float
    c_f: float
    c_r: float
    c_x: float
    c_y: float

    @classmethod
    def of(cls, model):
        vehicle = model["vehicle"]
        return cls(
            mass=vehicle["mass_kg"],
            yaw_inertia=vehicle["yaw_inertia_kg_m2"],
            longitudinal_inertia=vehicle["effective_longitudinal_inertia_kg_m"],
            l_f=vehicle["front_axle_distance_m"],
            l_r=vehicle["rear_axle_distance_m"],
            c_f=vehicle["front_cornering_stiffness_n_per_rad"],
            c_r=vehicle["rear_cornering_stiffness_n_per_rad"],
            c_x=vehicle["longitudinal_drag_n_m_s2_per_m2"],
            c_y=vehicle["lateral_drag_n_s2_per_m2"],
        )

    def derivative(self, x, u):
        """x' of (1)-(2), D x 3, for x D x 3 and u D x 2."""
        v_x, v_y, r = x.T
        torque, delta = u.T
        front = 2 * self.c_f * (delta - (v_y + self.l_f * r) / v_x)  # axle forces, N
        rear = 2 * self.c_r * (self.l_r * r - v_y) / v_x
        return np.stack(
            [
                v_y * r + (torque - self.c_x * v_x**2) / self.longitudinal_inertia,
                (front + rear - self.c_y * v_y**2) / self.mass - v_x * r,
                (self.l_f * front - self.l_r * rear) / self.yaw_inertia,
            ],
            axis=-1,
        )

    def jacobian(self, x):
        """d x' / d x, D x 3 x 3; no derivative of it depends on u."""
        v_x, v_y, r = x.T
        front = (
            2
            * self.c_f
            * np.stack([(v_y + self.l_f * r) / v_x, -np.ones_like(r), -self.l_f + 0 * r])
        )
        rear = (
            2
            * self.c_r
            * np.stack([(v_y - self.l_r * r) / v_x, -np.ones_like(r), self.l_r + 0 * r])
        )
        front, rear = front / v_x, rear / v_x
        lateral = (front + rear) / self.mass
        lateral[0] -= r
        lateral[1] -= 2 * self.c_y * v_y / self.mass
        lateral[2] -= v_x
        longitudinal = np.stack([-2 * self.c_x * v_x / self.longitudinal_inertia, r, v_y])
        yaw = (self.l_f * front - self.l_r * rear) / self.yaw_inertia
        return np.stack([longitudinal, lateral, yaw]).transpose(2, 0, 1)

    def step(self, x, u, period):
        """x after a period (Runge-Kutta, fourth order) and its derivative by x."""
        k_1 = self.derivative(x, u)
        k_2 = self.derivative(x + period / 2 * k_1, u)
        k_3 = self.derivative(x + period / 2 * k_2, u)
        k_4 = self.derivative(x + period * k_3, u)
        after = x + period / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4)
        # The exponential of the Jacobian, to the same order.
        scaled = period * self.jacobian(x)
        transition = term = np.broadcast_to(np.eye(3), scaled.shape)
        for order in range(1, 5):
            term = term @ scaled / order
            transition = transition + term
        return after, transition


@dataclass(frozen=True)
class Tuning:
    """Standard deviations: of the noise of v_x (m/s) and r (rad/s), and of what accelerates the
    vehicle beside the model, in m/s^2 (both axes) and rad/s^2, held over a sampling period."""

    v_x_noise: float
    r_noise: float
    acceleration: float
    yaw_acceleration: float

    def process(self, period):
        return (
            np.diag(
                [
                    self.acceleration * period,
                    self.acceleration * period,
                    self.yaw_acceleration * period,
                ]
            )
            ** 2
        )

    def measurement(self):
        return np.diag([self.v_x_noise, self.r_noise]) ** 2


@dataclass
class Innovations:
    """Of each sample and drive, T x D; 0 where the filter starts or does not run."""

    nis: np.ndarray
    yaw_rate: np.ndarray  # in standard deviations


def innovations(vehicle, tuning, period, y, u, running):
    """Runs the filter on y and u, T x D x 2, where `running`, T x D.

    It starts anew, from the measurement, where `running` begins.
    """
    samples, drives = running.shape
    Q, R = tuning.process(period), tuning.measurement()
    start_P = np.diag([R[0, 0], INITIAL_V_Y_STD**2, R[1, 1]])
    x = np.zeros((drives, 3))
    P = np.broadcast_to(start_P, (drives, 3, 3))
    was_running = np.zeros(drives, dtype=bool)
    found = Innovations(np.zeros((samples, drives)), np.zeros((samples, drives)))
    for k in range(samples):
        starts = running[k] & ~was_running | ~running[k]
        measured = np.stack([y[k, :, 0], np.zeros(drives), y[k, :, 1]], axis=-1)
        x = np.where(starts[:, None], measured, x)
        P = np.where(starts[:, None, None], start_P, P)
        x, P, nis, yaw_rate = update(x, P, y[k], R)
        found.nis[k] = np.where(starts, 0.0, nis)
        found.yaw_rate[k] = np.where(starts, 0.0, yaw_rate)
        x[:, 0] = np.maximum(x[:, 0], SLOWEST)
        x, transition = vehicle.step(x, u[k], period)
        P = transition @ P @ transition.transpose(0, 2, 1) + Q
        was_running = running[k]
    return found


def update(x, P, y, R):
    """State and covariance after a measurement; NIS and normalised innovation of the yaw rate."""
    innovation = y - x @ H.T
    S = P[:, ::2, ::2] + R  # H picks v_x and r
    (a, b), (_, d) = S.transpose(1, 2, 0)
    inverse = np.stack([np.stack([d, -b]), np.stack([-b, a])]) / (a * d - b * b)
    inverse = inverse.transpose(2, 0, 1)
    gain = P[:, :, ::2] @ inverse
    nis = np.einsum("di,dij,dj->d", innovation, inverse, innovation)
    kept = np.eye(3) - gain @ H
    # Joseph's form stays positive definite.
    P = kept @ P @ kept.transpose(0, 2, 1) + gain @ R @ gain.transpose(0, 2, 1)
    x = x + (gain @ innovation[:, :, None])[:, :, 0]
    return x, P, nis, innovation[:, 1] / np.sqrt(d)


def windowed_mean(values, running, window):
    """Mean of the last `window` samples, T x D; those before the last start count 0."""
    samples = np.arange(len(values))[:, None]
    start = np.maximum.accumulate(np.where(running, 0, samples + 1))  # of the current run
    total = np.vstack(
        [np.zeros(values.shape[1]), np.cumsum(np.where(running, values, 0.0), axis=0)]
    )
    first = np.maximum(start, samples + 1 - window)
    return (
        np.where(
            running,
            total[1:] - np.take_along_axis(total, np.minimum(first, samples + 1), axis=0),
            0.0,
        )
        / window
    )


def cusum(values, running, drifts):
    """Larger of the two one-sided sums of `values` less a drift, for each drift: T x drifts x D."""
    drifts = np.asarray(drifts)[:, None]
    up = down = np.zeros((len(drifts), values.shape[1]))
    largest = np.empty((len(values), *up.shape))
    for k, value in enumerate(values):
        up = np.maximum(0.0, running[k] * (up + value - drifts))
        down = np.maximum(0.0, running[k] * (down - value - drifts))
        np.maximum(up, down, out=largest[k])
    return largest
