"""The packaged reference vehicle drives a packaged detector, as a driver does it.

Conventions: times in s, speeds in m/s, angles at the road wheel in rad; noise of the default specification.
"""

import numpy as np

PERIOD_S = 0.01
OUTPUTS = ["alarm", "state", "J_ratio"]


def weave(speed, lateral, hertz=0.2):
    """Commanded angle of a weave with a steady lateral acceleration, rad."""
    angle = lateral * (2.62 / speed**2 + 0.0017)
    return lambda t: angle * np.sin(2 * np.pi * hertz * t) if t > 1 else 0.0


def drive(plant, detector, speed, *, steering=lambda t: 0.0, told=lambda t, told: told, fault=lambda t: 0.0,
          moment=lambda t: 0.0, turned=lambda angle: angle, slope=lambda t: 0.0, duration=10.0, parameters=None,
          vehicle=None):  # fmt: skip
    """Runs both FMUs from `speed`, which the driver holds or changes by `slope`, m/s^2 at t. `told` changes what the
    detector is told at t; `turned` is the wheel's angle for the commanded one; `moment` a yaw moment, N m; `vehicle` and
    `parameters` are set in plant and detector. Returns the records by name, and the detector's messages."""
    with plant.instance() as car, detector.instance() as monitor:
        noise = {"noise.v_x": 0.02, "noise.r": 0.002, "noise.seed": 7, "noise.sample_period": PERIOD_S}
        car.initialise({"initial.v_x": speed} | noise | (vehicle or {}))
        monitor.initialise(parameters)
        data = car.get(["vehicle.I_e", "vehicle.C_x"])
        rows = []
        for k in range(round(duration / PERIOD_S)):
            t = k * PERIOD_S
            y = car.get(["v_x", "r"])
            torque = data["vehicle.C_x"] * speed**2 + data["vehicle.I_e"] * (slope(t) + speed - y["v_x"])
            speed += slope(t) * PERIOD_S
            u = {"u.T_eng": torque, "u.delta": steering(t)}
            monitor.set(told(t, y | u))
            wheel = {"u.T_eng": torque, "u.delta": turned(steering(t)), "fault": fault(t)}
            car.set(wheel | {"disturbance.yaw_moment": moment(t)})
            monitor.doStep(t, PERIOD_S)
            car.doStep(t, PERIOD_S)
            rows.append({"time": t} | monitor.get(OUTPUTS))
        texts = [text for _, _, text in monitor.messages]
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}, texts
