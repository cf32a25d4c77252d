"""An extended Kalman filter that is told what the design is told, and the two tests for a fault with it.

What is uncertain are states: bank, gust, and relative errors of mass, yaw inertia and both stiffnesses. The
tests: the fault as one state more, a walk that begins at 0, in standard deviations (`fault_state`); and the
likelihood ratio over onsets of a constant fault (`onset_ratio`; Willsky and Jones 1976).

Conventions
- State x = [v_x, v_y, r, b, w, mass, inertia, front, rear, fault]: b and w lateral accelerations in m/s^2 by
  the bank and by a gust, which acts ahead of the centre of gravity too; the fault in rad; else those of
  kalman.py, all drives at once.
- Bank and parameters are kept where the filter starts anew: the car and, for a while, the road are the same.
- Axle loads shift with the torque at once.
- Deviations of walks are per root of s, of accelerations per root of Hz.
"""

from dataclasses import dataclass

import numpy as np
from kalman import INITIAL_V_Y_STD, SLOWEST

GRAVITY = 9.80665
V_X, V_Y, R, BANK, GUST, MASS, YAW_INERTIA, FRONT, REAR, FAULT = range(10)
STATES = 10
LEARNED = [BANK, MASS, YAW_INERTIA, FRONT, REAR]
GUST_S = 0.5  # in which a gust is forgotten
ACCELERATION = 0.05  # m/s^2 and rad/s^2
OF_FORCE = 0.02  # of the axle forces
PARAMETER_WALK = 0.001
UNIFORM = 1 / np.sqrt(3)  # standard deviation over bound
AGES = [(5, 50), (20, 200), (100, 1000)]  # onsets every so many samples, up to so old
SETTLED = 50  # samples: no onset before


@dataclass(frozen=True)
class Setting:
    """What a filter is tuned by: the bank's walk, the wind's and the fault's standard deviation."""

    bank: float  # m/s^2
    wind: float  # m/s
    fault: float = 0.0  # rad; 0: no state


class ToldVehicle:
    """The design's vehicle with what is uncertain of it."""

    def __init__(self, detector, height):
        self.vehicle, uncertainty = detector["model"]["vehicle"], detector["deviations"]["uncertainty"]
        parameters = ["mass", "yaw_inertia", "front_cornering_stiffness", "rear_cornering_stiffness"]
        self.parameters = np.array([uncertainty[name] for name in parameters])  # bounds
        self.bank, self.gust = uncertainty["bank_m_per_s2"], uncertainty["gust"]
        self.height = height

    def axle_forces(self, x, u):
        """Front and rear, N, of x (..., 10) and u (..., 2), and the loads that shift with the torque."""
        v = self.vehicle
        l_f, l_r = v["front_axle_distance_m"], v["rear_axle_distance_m"]
        v_x, v_y, r = x[..., V_X], x[..., V_Y], x[..., R]
        drive = u[..., 0] - v["longitudinal_drag_n_m_s2_per_m2"] * np.real(v_x) ** 2
        shift = self.height * drive / v["effective_longitudinal_inertia_kg_m"] / GRAVITY
        front = 2 * v["front_cornering_stiffness_n_per_rad"] * (1 - shift / l_r) * (1 + x[..., FRONT])
        rear = 2 * v["rear_cornering_stiffness_n_per_rad"] * (1 + shift / l_f) * (1 + x[..., REAR])
        slip = u[..., 1] + x[..., FAULT] - (v_y + l_f * r) / v_x
        return front * slip, rear * (l_r * r - v_y) / v_x

    def derivative(self, x, u):
        v = self.vehicle
        front, rear = self.axle_forces(x, u)
        mass = v["mass_kg"] * (1 + x[..., MASS])
        inertia = v["yaw_inertia_kg_m2"] * (1 + x[..., YAW_INERTIA])
        drive = u[..., 0] - v["longitudinal_drag_n_m_s2_per_m2"] * x[..., V_X] ** 2
        drag = v["lateral_drag_n_s2_per_m2"] * x[..., V_Y] ** 2
        moment = v["front_axle_distance_m"] * front - v["rear_axle_distance_m"] * rear
        gust = self.gust["acting_ahead_m"] * v["mass_kg"] / v["yaw_inertia_kg_m2"] * x[..., GUST]
        slope = np.zeros_like(x)
        slope[..., V_X] = x[..., V_Y] * x[..., R] + drive / (
            v["effective_longitudinal_inertia_kg_m"] * (1 + x[..., MASS])
        )
        slope[..., V_Y] = (front + rear - drag) / mass - x[..., V_X] * x[..., R] + x[..., BANK] + x[..., GUST]
        slope[..., R] = moment / inertia + gust
        slope[..., GUST] = -x[..., GUST] / GUST_S
        return slope

    def jacobian(self, x, u):
        """d x' / d x, D x 10 x 10, by complex steps."""
        step = 1e-20
        ahead = x[None] + 1j * step * np.eye(STATES)[:, None]
        return (self.derivative(ahead, u[None]).imag / step).transpose(1, 2, 0)

    def gust_std(self, wind, v_x):
        """Of the lateral acceleration by a wind of standard deviation `wind`, m/s^2."""
        return self.gust["coefficient_n_s2_per_m2"] * wind * np.sqrt(v_x**2 + wind**2) / self.vehicle["mass_kg"]


class Filter:
    """The filter of D drives."""

    def __init__(self, vehicle, setting, noise, period, drives):
        self.vehicle, self.setting, self.period = vehicle, setting, period
        self.R = np.diag(np.square(noise))
        self.x = np.zeros((drives, STATES))
        deviations = np.zeros(STATES)
        deviations[BANK], deviations[MASS:FAULT] = UNIFORM * vehicle.bank, UNIFORM * vehicle.parameters
        self.P = np.tile(np.diag(deviations**2), (drives, 1, 1))

    def start(self, starts, y):
        """Where `starts`, from the measurement; what has been learned of road and car is kept."""
        kept = np.zeros(STATES)
        kept[LEARNED] = 1
        x, P = self.x * kept, self.P * np.outer(kept, kept)
        x[:, V_X], x[:, R] = y[:, 0], y[:, 1]
        P[:, V_X, V_X], P[:, V_Y, V_Y], P[:, R, R] = self.R[0, 0], INITIAL_V_Y_STD**2, self.R[1, 1]
        P[:, GUST, GUST] = self.vehicle.gust_std(self.setting.wind, y[:, 0]) ** 2
        self.x = np.where(starts[:, None], x, self.x)
        self.P = np.where(starts[:, None, None], P, self.P)

    def update(self, y, goes):
        """Takes in the measurement where `goes`; innovation, inverse of its covariance, gain."""
        innovation = y - self.x[:, [V_X, R]]
        S = self.P[:, [V_X, R]][:, :, [V_X, R]] + self.R
        inverse = np.linalg.inv(S)
        gain = self.P[:, :, [V_X, R]] @ inverse
        H = np.zeros((2, STATES))
        H[0, V_X] = H[1, R] = 1
        left = np.eye(STATES) - gain @ H
        P = left @ self.P @ left.transpose(0, 2, 1) + gain @ self.R @ gain.transpose(0, 2, 1)
        x = self.x + (gain @ innovation[:, :, None])[:, :, 0]
        self.x = np.where(goes[:, None], x, self.x)
        self.P = np.where(goes[:, None, None], P, self.P)
        return innovation, inverse, gain

    def predict(self, u):
        """Goes on by a period; the transition and what a fault of 1 rad adds meanwhile."""
        x, period = self.x, self.period
        x[:, V_X] = np.maximum(x[:, V_X], SLOWEST)
        A = period * self.vehicle.jacobian(x, u)
        series = np.eye(STATES) + A / 2 + A @ A / 6
        transition = np.eye(STATES) + A @ series
        front, rear = self.vehicle.axle_forces(x, u)
        v = self.vehicle.vehicle
        lateral = np.abs(front) + np.abs(rear)
        Q = np.zeros_like(self.P)
        Q[:, V_X, V_X] = ACCELERATION**2
        Q[:, V_Y, V_Y] = ACCELERATION**2 + (OF_FORCE * lateral / v["mass_kg"]) ** 2
        arm = max(v["front_axle_distance_m"], v["rear_axle_distance_m"])
        Q[:, R, R] = ACCELERATION**2 + (OF_FORCE * arm * lateral / v["yaw_inertia_kg_m2"]) ** 2
        Q[:, BANK, BANK] = self.setting.bank**2
        Q[:, GUST, GUST] = 2 / GUST_S * self.vehicle.gust_std(self.setting.wind, x[:, V_X]) ** 2
        for k in range(MASS, FAULT):
            Q[:, k, k] = PARAMETER_WALK**2
        Q[:, FAULT, FAULT] = self.setting.fault**2
        slope = self.vehicle.derivative(x, u)
        self.x = x + period * (series @ slope[:, :, None])[:, :, 0]
        self.P = transition @ self.P @ transition.transpose(0, 2, 1) + period * Q
        return transition


def filtered(vehicle, setting, noise, period, y, u, running):
    """Runs the filter on y and u, T x D x 2, where `running`, T x D; yields after every sample its number,
    where it has just started, the filter, innovation, inverse covariance, gain and the transition from it."""
    filter_ = Filter(vehicle, setting, noise, period, running.shape[1])
    was_running = np.zeros(running.shape[1], dtype=bool)
    for k in range(len(running)):
        starts = ~(running[k] & was_running)
        filter_.start(starts, y[k])
        innovation, inverse, gain = filter_.update(y[k], ~starts)
        innovation = np.where(starts[:, None], 0.0, innovation)
        gain = np.where(starts[:, None, None], 0.0, gain)
        fault = filter_.x[:, FAULT].copy(), filter_.P[:, FAULT, FAULT].copy()
        transition = filter_.predict(u[k])
        yield k, starts, fault, innovation, inverse, gain, transition
        was_running = running[k]


def fault_state(vehicle, setting, noise, period, y, u, running):
    """|fault| over its standard deviation, T x D."""
    found = np.zeros(running.shape)
    for k, _, (fault, variance), *_ in filtered(vehicle, setting, noise, period, y, u, running):
        found[k] = np.abs(fault) / np.sqrt(np.maximum(variance, 1e-20))
    return np.where(running, found, 0.0)


def onset_ratio(vehicle, setting, noise, period, y, u, running):
    """|f^| over its standard deviation of the likeliest onset, and f^, each T x D."""
    drives = running.shape[1]
    found, estimates = np.zeros(running.shape), np.zeros(running.shape)
    onsets = np.zeros(0, dtype=int)
    error = np.zeros((drives, STATES, 0))  # of the state by a fault of 1 rad since each onset
    a, c = np.zeros((drives, 0)), np.zeros((drives, 0))
    started = np.zeros(drives, dtype=int)
    by_fault = np.zeros(STATES)
    by_fault[FAULT] = 1
    for k, starts, _, innovation, inverse, gain, transition in filtered(
        vehicle, setting, noise, period, y, u, running
    ):
        started = np.where(starts, k, started)
        kept = np.array([is_kept(k - onset, onset) for onset in onsets], dtype=bool)
        onsets, error, a, c = onsets[kept], error[:, :, kept], a[:, kept], c[:, kept]
        shown = error[:, [V_X, R]]  # 2 per hypothesis
        weighed = inverse @ shown
        a = np.where(starts[:, None], 0.0, a + np.einsum("dih,di->dh", weighed, innovation))
        c = np.where(starts[:, None], 0.0, c + np.einsum("dih,dih->dh", weighed, shown))
        if len(onsets):
            ratio = np.abs(a) / np.sqrt(np.maximum(c, 1e-12))
            ratio = np.where(onsets >= started[:, None] + SETTLED, ratio, 0.0)
            likeliest = ratio.argmax(axis=1)
            of_each = np.arange(drives), likeliest
            found[k] = ratio[of_each]
            estimates[k] = a[of_each] / np.maximum(c[of_each], 1e-12)
        error = error - gain @ shown
        error = np.where(starts[:, None, None], 0.0, error)
        # The filter itself has no fault as a state here: what one of 1 rad adds stands in its column.
        error = transition @ error + transition[:, :, FAULT, None] * (1 - by_fault)[:, None]
        if k % AGES[0][0] == 0:
            onsets = np.append(onsets, k)
            new = transition[:, :, FAULT, None] * (1 - by_fault)[:, None]
            error = np.concatenate([error, new], axis=2)
            a, c = (np.concatenate([of, np.zeros((drives, 1))], axis=1) for of in (a, c))
    return np.where(running, found, 0.0), estimates


def is_kept(age, onset):
    return any(onset % every == 0 and age <= oldest for every, oldest in AGES)
