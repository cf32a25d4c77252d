"""The plant FMU against scipy's integration of the same equations at tight tolerance."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

GRAVITY_M_PER_S2 = 9.81
STEP_S = 0.01
STEPS = 400
# The plant's Runge-Kutta steps of 1 ms, at |eigenvalue| x step up to 0.05, are good to about 1e-8.
TOLERANCE = 1e-7
VEHICLE = ["M_v", "I_z", "I_e", "l_f", "l_r", "C_f", "C_r", "C_x", "C_y"]


def derivative(p, excitation, state):
    """(1)-(2) of the paper with fault, disturbances, bank, friction and a lagging actuator."""
    v_x, v_y, r, delta_w = state
    t_eng, delta, fault, side_force, yaw_moment = excitation
    wheel = (delta_w if p["lag"] > 0 else delta) + fault
    forces = np.array(
        [
            2 * p["C_f"] * (wheel - (v_y + p["l_f"] * r) / v_x),
            2 * p["C_r"] * (p["l_r"] * r - v_y) / v_x,
        ]
    )
    if p["friction"] is not None:
        loads = p["M_v"] * GRAVITY_M_PER_S2 * np.array([p["l_r"], p["l_f"]]) / (p["l_f"] + p["l_r"])
        forces = p["friction"] * loads * np.tanh(forces / (p["friction"] * loads))
    front, rear = forces
    bank = GRAVITY_M_PER_S2 * np.sin(p["bank"])
    return [
        (t_eng - p["C_x"] * v_x**2) / p["I_e"] + v_y * r,
        (front + rear - p["C_y"] * v_y**2 + side_force) / p["M_v"] - v_x * r + bank,
        (p["l_f"] * front - p["l_r"] * rear + yaw_moment) / p["I_z"],
        (delta - delta_w) / p["lag"] if p["lag"] > 0 else 0.0,
    ]


@pytest.mark.parametrize("speed", [6.0, 15.0, 28.0])
@pytest.mark.parametrize("realistic", [False, True])
def test_motion(plant, speed, realistic):
    rng = np.random.default_rng(31)
    limits = np.array([1000.0, 0.05, 0.01, 500.0, 500.0])
    excitations = np.repeat(rng.uniform(-limits, limits, (STEPS // 20, 5)), 20, axis=0)
    excitations[:40, 1] = 0.0  # the actuator starts at rest
    names = ["u.T_eng", "u.delta", "fault", "disturbance.side_force", "disturbance.yaw_moment"]
    start = {"initial.v_x": speed, "initial.v_y": 0.5, "initial.r": -0.1}
    if realistic:
        start |= {
            "vehicle.M_v": 1700.0,
            "tyre.friction_limited": True,
            "tyre.friction": 0.7,
            "actuator.lag": 0.08,
            "road.bank": 0.03,
        }
    with plant.instance() as instance:
        instance.initialise(start)
        p = {n: instance.get([f"vehicle.{n}"])[f"vehicle.{n}"] for n in VEHICLE}
        found = instance.record(
            dict(zip(names, excitations.T, strict=True)), ["v_x", "r", "true.v_y"], STEP_S
        )
    p |= {"friction": None, "lag": 0.0, "bank": 0.0}
    if realistic:
        p |= {"friction": 0.7, "lag": 0.08, "bank": 0.03}

    state = np.array([speed, 0.5, -0.1, 0.0])
    expected = []
    for excitation in excitations:
        solution = solve_ivp(
            lambda _, x: derivative(p, excitation, x), (0, STEP_S), state, rtol=1e-11, atol=1e-12
        )
        state = solution.y[:, -1]
        expected.append(state)
    expected = np.array(expected)
    assert np.ptp(expected[:, 2]) > 0.1, "the vehicle must turn"
    for name, column in [("v_x", 0), ("true.v_y", 1), ("r", 2)]:
        worst = np.max(np.abs(found[name] - expected[:, column]))
        assert worst < TOLERANCE, f"{name} differs by {worst:.1e}"


def test_noise_is_reproducible_and_off_by_default(plant):
    inputs = {"u.delta": np.zeros(2000)}

    def measure(parameters):
        with plant.instance() as instance:
            instance.initialise({"initial.v_x": 15.0} | parameters)
            return instance.record(inputs, ["v_x", "r", "true.v_x", "true.r"], STEP_S)

    quiet = measure({})
    np.testing.assert_array_equal(quiet["v_x"], quiet["true.v_x"])
    noisy, again, other = (
        measure({"noise.v_x": 0.02, "noise.r": 0.002, "noise.seed": seed}) for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(noisy["r"], again["r"])
    assert (noisy["r"] != other["r"]).any()
    for name, std in [("v_x", 0.02), ("r", 0.002)]:
        error = noisy[name] - noisy[f"true.{name}"]
        # Five standard errors of a standard deviation from 2000 independent values.
        assert abs(error.std() / std - 1) < 5 / np.sqrt(2 * 2000)
