"""The plant FMU as importers meet it: against scipy's integration of the same equations at tight
tolerance, its declared dependencies against what changes, and what it does with absurd inputs."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from scipy.integrate import solve_ivp

GRAVITY_M_PER_S2 = 9.80665
STEP_S = 0.01
STEPS = 400
# The plant's Runge-Kutta steps of 1 ms, at |eigenvalue| x step up to 0.05, are good to about 1e-8.
TOLERANCE = 1e-7
VEHICLE = ["M_v", "I_z", "I_e", "l_f", "l_r", "C_f", "C_r", "C_x", "C_y"]


def derivative(p, excitation, state):
    """(1)-(2) with fault, disturbances, bank, load transfer, friction and a lagging actuator.

    The lateral drag opposes the motion to either side: the paper's C_y v_y^2 pushes to the right only.
    """
    v_x, v_y, r, delta_w = state
    t_eng, delta, fault, side_force, yaw_moment = excitation
    command = delta - p["offset"]
    a_x = (t_eng - p["C_x"] * v_x**2) / p["I_e"]
    wheelbase = p["l_f"] + p["l_r"]
    shift = a_x * p["h"] / GRAVITY_M_PER_S2
    distances = np.array([p["l_r"], p["l_f"]])
    loads = p["M_v"] * GRAVITY_M_PER_S2 * (distances + [-shift, shift]) / wheelbase
    wheel = (delta_w if p["lag"] > 0 else command) + fault
    forces = np.array(
        [
            2 * p["C_f"] * (wheel - (v_y + p["l_f"] * r) / v_x),
            2 * p["C_r"] * (p["l_r"] * r - v_y) / v_x,
        ]
    ) * (1 + np.array([-shift, shift]) / distances)
    if p["friction"] is not None:
        forces = p["friction"] * loads * np.tanh(forces / (p["friction"] * loads))
    front, rear = forces
    bank = -GRAVITY_M_PER_S2 * np.sin(p["bank"])
    return [
        a_x + v_y * r,
        (front + rear - p["C_y"] * v_y * abs(v_y) + side_force) / p["M_v"] - v_x * r + bank,
        (p["l_f"] * front - p["l_r"] * rear + yaw_moment) / p["I_z"],
        (command - delta_w) / p["lag"] if p["lag"] > 0 else 0.0,
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
            "steering.offset": 0.01,
            "vehicle.h": 0.6,
            "road.bank": 0.03,
        }
    with plant.instance() as instance:
        instance.initialise(start)
        p = {n: instance.get([f"vehicle.{n}"])[f"vehicle.{n}"] for n in VEHICLE}
        found = instance.record(
            dict(zip(names, excitations.T, strict=True)), ["v_x", "r", "true.v_y"], STEP_S
        )
    p |= {"friction": None, "lag": 0.0, "offset": 0.0, "h": 0.0, "bank": 0.0}
    if realistic:
        p |= {"friction": 0.7, "lag": 0.08, "offset": 0.01, "h": 0.6, "bank": 0.03}

    state = np.array([speed, 0.5, -0.1, -p["offset"]])
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


def test_sensors_err_as_their_parameters_say(plant):
    errors = {
        "sensor.v_x_bias": 0.1,
        "sensor.r_bias": -0.002,
        "sensor.v_x_scale": 0.01,
        "sensor.r_scale": -0.02,
    }
    resolutions = {"sensor.v_x_resolution": 0.25, "sensor.r_resolution": 0.01}
    inputs = {"u.delta": np.full(200, 0.02)}
    names = ["v_x", "r", "true.v_x", "true.r"]

    def measure(parameters, step):
        with plant.instance() as instance:
            instance.initialise(parameters)
            return instance.record(inputs, names, step)

    found = measure(errors, STEP_S)
    np.testing.assert_allclose(found["v_x"], 1.01 * found["true.v_x"] + 0.1, rtol=1e-15)
    np.testing.assert_allclose(found["r"], 0.98 * found["true.r"] - 0.002, rtol=1e-14)
    found = measure(resolutions, STEP_S)
    for name, resolution in [("v_x", 0.25), ("r", 0.01)]:
        steps = found[name] / resolution
        np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
        assert np.abs(found[name] - found[f"true.{name}"]).max() <= resolution / 2 * (1 + 1e-12)
    # Held for 10 ms, read each millisecond.
    found = measure({"sensor.held": True}, 1e-3)
    begins = np.arange(9, 199, 10)
    np.testing.assert_array_equal(found["r"][begins], found["true.r"][begins])
    for k in begins[:-1]:
        assert (found["r"][k : k + 10] == found["r"][k]).all()
        assert found["r"][k + 10] != found["r"][k]


def test_the_wheel_stays_between_its_end_stops(plant):
    with plant.instance() as instance:
        instance.initialise({"actuator.angle_limit": 0.5, "actuator.rate_limit": 2.0})
        inputs = {"u.delta": np.repeat([1.2, -1.2], 100)}
        found = instance.record(inputs, ["true.delta"], STEP_S)["true.delta"]
    assert found[99] == pytest.approx(0.5, abs=1e-12)
    assert found[199] == pytest.approx(-0.5, abs=1e-12)
    assert np.abs(found).max() <= 0.5 + 1e-12


def test_outputs_follow_the_parameters_before_and_inside_initialization_mode(plant):
    values = {"initial.v_x": 25.0, "initial.v_y": 1.5, "initial.r": 0.2, "u.delta": 0.03, "fault": 0.01}
    expected = {
        "v_x": 25.0,
        "r": 0.2,
        "true.v_x": 25.0,
        "true.v_y": 1.5,
        "true.r": 0.2,
        "true.delta": 0.03 + 0.01,
    }
    for inside in [False, True]:
        with plant.instance() as instance:
            if not inside:
                instance.set(values)
            instance.setupExperiment(startTime=0.0)
            instance.enterInitializationMode()
            if inside:
                instance.set(values)
            assert instance.get(expected) == expected
            instance.exitInitializationMode()
            assert instance.get(expected) == expected


def dependencies(plant, group):
    """What modelDescription.xml says an output depends on, by names."""
    root = ElementTree.parse(Path(plant.folder, "modelDescription.xml")).getroot()
    names = [v.get("name") for v in root.find("ModelVariables")]
    unknowns = root.find(f"ModelStructure/{group}")
    return {
        names[int(u.get("index")) - 1]: {names[int(i) - 1] for i in u.get("dependencies").split()}
        for u in unknowns
    }


def test_dependencies_are_declared_as_they_are(plant):
    """Each input and parameter is changed alone; what changes with it depends on it."""
    variables = {v.name: v for v in plant.description.modelVariables}
    outputs = [name for name, v in variables.items() if v.causality == "output"]
    inputs = [name for name, v in variables.items() if v.causality == "input"]
    parameters = [name for name, v in variables.items() if v.causality == "parameter"]
    base = {"u.delta": 0.1, "actuator.angle_limit": 0.09, "noise.v_x": 0.02}
    base |= {"noise.r": 0.002, "initial.v_y": 1.0, "initial.r": 0.1}

    def changed(name, instance):
        value, row = instance.get([name])[name], variables[name]
        if name == "u.delta":
            return 0.05  # an angle beyond the end stop would show nothing
        kinds = {"Boolean": lambda: not value, "Integer": lambda: value + 1}
        return kinds.get(row.type, lambda: 0.5 * (value + float(row.max)))()

    for group, names in [("Outputs", inputs), ("InitialUnknowns", inputs + parameters)]:
        found = {output: set() for output in outputs}
        for name in names:
            with plant.instance() as instance:
                if group == "Outputs":
                    instance.initialise(base)
                    instance.doStep(0.0, STEP_S)
                else:
                    instance.setupExperiment(startTime=0.0)
                    instance.set(base)
                    instance.enterInitializationMode()
                before = instance.get(outputs)
                instance.set({name: changed(name, instance)})
                after = instance.get(outputs)
            for output in outputs:
                if before[output] != after[output]:
                    found[output].add(name)
        assert found == dependencies(plant, group), group


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("u.delta", 1e4),
        ("u.delta", np.nan),
        ("u.T_eng", 1e13),
        ("fault", -2.0),
        ("disturbance.side_force", np.inf),
        ("disturbance.yaw_moment", -1e7),
    ],
)
def test_absurd_inputs_are_refused_by_name(plant, name, value):
    outputs = ["v_x", "r", "true.v_x", "true.v_y", "true.r", "true.delta"]
    with plant.instance() as instance:
        instance.initialise()
        instance.doStep(0.0, STEP_S)
        before = instance.get(outputs)
        instance.set({name: value})
        assert instance.get(outputs) == before
        with pytest.raises(FMICallException):
            instance.doStep(STEP_S, STEP_S)
        assert instance.get(outputs) == before
    (text,) = instance.complaints()
    row = next(v for v in plant.description.modelVariables if v.name == name)
    limits = [np.format_float_positional(float(x), trim="-") for x in (row.min, row.max)]
    for part in [f'"{name}"', *limits]:
        assert part in text, text


def test_a_motion_beyond_the_finite_numbers_is_refused(plant):
    """Parameters within their limits whose modes are far faster than the plant's steps."""
    outputs = ["v_x", "r", "true.v_x", "true.v_y", "true.r", "true.delta"]
    with plant.instance() as instance:
        instance.initialise({"vehicle.M_v": 1.0, "vehicle.C_f": 1e8, "u.delta": 1.0})
        with pytest.raises(FMICallException):
            for k in range(1000):
                instance.doStep(k * STEP_S, STEP_S)
        assert np.isfinite(list(instance.get(outputs).values())).all()
    (text,) = instance.complaints()
    assert "finite" in text


@pytest.mark.parametrize(("r", "v_y"), [(-0.5, 1.4), (0.3, 1.0)])
def test_a_master_that_hands_over_in_initialization_mode_raises_no_alarm(plant, detector, r, v_y):
    """29 m/s in the middle of a turn: the detector is told so from the beginning."""
    speed = 29.0
    shared = [v.name for v in detector.description.modelVariables if v.name.startswith("vehicle.")]
    with plant.instance() as vehicle, detector.instance() as monitor:
        for instance in (vehicle, monitor):
            instance.setupExperiment(startTime=0.0)
        vehicle.set(monitor.get(shared))
        vehicle.set({"initial.v_x": speed, "initial.v_y": v_y, "initial.r": r})
        for instance in (vehicle, monitor):
            instance.enterInitializationMode()
        u = {"u.T_eng": monitor.get(["vehicle.C_x"])["vehicle.C_x"] * speed**2, "u.delta": 0.0}
        vehicle.set(u)
        monitor.set(vehicle.get(["v_x", "r"]) | u)
        for instance in (vehicle, monitor):
            instance.exitInitializationMode()
        for k in range(500):
            for instance in (vehicle, monitor):
                instance.doStep(k * STEP_S, STEP_S)
            found = monitor.get(["alarm", "J_rms", "J_th"])
            assert not found["alarm"] and found["J_rms"] < found["J_th"], f"{k * STEP_S} s: {found}"
            monitor.set(vehicle.get(["v_x", "r"]) | u)
