"""A constant offset of a sensor shows in the residual as the analysis of method 5 says.

The offset enters by the injection, by E y, and by the measured premise (K). Without K the analysis
would predict no residual at all, which is tested too.
"""

import numpy as np
import pytest

OFFSET = np.array([0.05, 0.002])  # m/s, rad/s
SPEED = 15.0
DURATION_S = 12.0


def steady(plant, detector, period, steering_angle, offset):
    """Residual at the end of a drive with a constant steering angle, and the plant's state there."""
    with plant.instance() as vehicle, detector.instance() as monitor:
        vehicle.initialise({"initial.v_x": SPEED})
        monitor.initialise()
        drag = vehicle.get(["vehicle.C_x"])["vehicle.C_x"]
        for k in range(round(DURATION_S / period)):
            state = vehicle.get(["v_x", "true.v_y", "r"])
            # Holds the speed against drag and the turn.
            u = {"u.T_eng": drag * SPEED**2 + 4000.0 * (SPEED - state["v_x"]), "u.delta": steering_angle}
            monitor.set({"v_x": state["v_x"] + offset[0], "r": state["r"] + offset[1]} | u)
            vehicle.set(u)
            monitor.doStep(k * period, period)
            vehicle.doStep(k * period, period)
        outputs = monitor.get(["residual.v_x", "residual.r"])
        return np.array(list(outputs.values())), list(state.values())


def premise_sensitivity(reference, v_x, v_y, r):
    """K, 3 x 2."""
    ref = reference
    force = 2 * (ref.c_f + ref.c_r) / ref.mass
    coupling = 2 * (ref.c_r * ref.l_r - ref.c_f * ref.l_f)
    damping = 2 * (ref.c_f * ref.l_f**2 + ref.c_r * ref.l_r**2) / ref.yaw_inertia
    return ref.period * np.array(
        [
            [-2 * ref.c_x / ref.longitudinal_inertia * v_x, v_y],
            [(force * v_y - coupling * r / ref.mass) / v_x**2 - r, coupling / (ref.mass * v_x) - v_x],
            [(damping * r - coupling * v_y / ref.yaw_inertia) / v_x**2, -damping / v_x],
        ]
    )


def predicted(reference, state, with_k):
    """Steady residual of the offset at a state."""
    v_x, v_y, r = state
    h = reference.membership(np.array([v_x, r]) + OFFSET)
    m, e, c = reference.M, reference.E, reference.C
    g_rho = np.outer(reference.G, [0.0, 1.0, 0.0]) * 2 * v_y
    k = premise_sensitivity(reference, v_x, v_y, r) if with_k else np.zeros((3, 2))
    n = np.tensordot(h, reference.N, 1) + m @ g_rho
    injected = -np.tensordot(h, reference.L, 1) + m @ g_rho @ e - m @ k
    error = np.linalg.solve(np.eye(3) - n, injected @ OFFSET)
    return c @ error + (np.eye(2) + c @ e) @ OFFSET


@pytest.mark.parametrize("steering_angle", [0.0, 0.03])
def test_offset_shows_as_the_analysis_says(plant, detector, reference, steering_angle):
    without, state = steady(plant, detector, reference.period, steering_angle, np.zeros(2))
    measured, _ = steady(plant, detector, reference.period, steering_angle, OFFSET)
    change = measured - without
    expected = predicted(reference, state, with_k=True)
    assert np.linalg.norm(change - expected) <= 0.02 * np.linalg.norm(expected), (change, expected)
    assert np.linalg.norm(change) > 1e-5
    blind = predicted(reference, state, with_k=False)
    assert np.linalg.norm(change - blind) > 0.5 * np.linalg.norm(change), "K must matter"
