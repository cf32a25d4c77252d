"""The scenario of method 7 (the paper's Fig. 1): plant and detector as two FMUs.

Conventions
- At each communication point the detector gets the plant's outputs and the commanded input, then
  both step; so row k of a record holds the inputs of sample k and the detector's results of it.
- The drive torque is the one that holds the initial speed on a straight road.
"""

import numpy as np
from signals import OUTPUTS

DURATION_S = 20.0
FAULT_ONSET_S = 5.0
SIDE_WIND_LEVER_ARM_M = 0.25


def steering_angle_rad(t, speed):
    return 0.02 * np.sin(0.5 * t) * np.sqrt(5.0 / speed)


def side_wind_m_per_s2(t):
    return 0.1 * np.sin(-0.1 * np.pi * t)


def fault_rad(t):
    return np.radians(0.5 + 0.1 * np.sin(-0.1 * np.pi * t)) if t >= FAULT_ONSET_S - 1e-9 else 0.0


def drive(plant, detector, speed, period):
    """Runs both FMUs; a mapping of names to arrays, one row for each sample."""
    with plant.instance() as vehicle, detector.instance() as monitor:
        vehicle.initialise({"initial.v_x": speed, "initial.v_y": 1.0})
        monitor.initialise()
        data = vehicle.get(["vehicle.M_v", "vehicle.C_x"])
        rows = []
        for k in range(round(DURATION_S / period)):
            t = k * period
            u = {
                "u.T_eng": data["vehicle.C_x"] * speed**2,
                "u.delta": steering_angle_rad(t, speed),
            }
            force = data["vehicle.M_v"] * side_wind_m_per_s2(t)
            y = vehicle.get(["v_x", "r"])
            monitor.set(y | u)
            vehicle.set(
                u
                | {
                    "fault": fault_rad(t),
                    "disturbance.side_force": force,
                    "disturbance.yaw_moment": SIDE_WIND_LEVER_ARM_M * force,
                }
            )
            monitor.doStep(t, period)
            vehicle.doStep(t, period)
            rows.append({"time": t} | y | u | monitor.get(OUTPUTS))
        assert not monitor.complaints(), monitor.complaints()
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


