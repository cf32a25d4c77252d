"""Every result of the packaged detector against the equations in numpy, on the same inputs."""

import dataclasses

import numpy as np
import pytest
from reference import (
    DISABLED,
    DRIVE_TORQUE,
    INVALID_INPUT,
    LATERAL_SPEED,
    LIMITS,
    MONITORING,
    NO_ALARM,
    NOTHING,
    OUT_OF_RANGE,
    RANGE,
    RESIDUAL,
    SPEED,
    STALE_INPUT,
    STEERING_ANGLE,
    YAW_RATE,
)
from signals import INPUTS, OUTPUTS, assert_agree, expected, random_drive

SAMPLES = 3000


def compare(detector, reference, inputs, parameters=None, **reference_parameters):
    """Runs both on `inputs`, compares, and returns the reference's results."""
    with detector.instance() as instance:
        instance.initialise(parameters)
        found = instance.record(inputs, OUTPUTS, reference.period)
    results = expected(reference, inputs, **reference_parameters)
    assert_agree(found, results, inputs, reference.weights)
    return results


@pytest.mark.parametrize("seed", range(4))
def test_wandering_in_and_out_of_the_range(detector, reference, seed):
    results = compare(detector, reference, random_drive(seed, SAMPLES, reference.period))
    assert set(results["state"]) == {MONITORING, OUT_OF_RANGE}
    assert results["alarm"].any() and not results["alarm"].all()


@pytest.mark.parametrize("seed", range(3))
def test_adaptive_threshold(example, seed):
    detector, reference = example
    inputs = random_drive(seed, SAMPLES, reference.period)
    results = compare(detector, reference, inputs)
    assert {MONITORING} <= set(results["state"]) <= {MONITORING, OUT_OF_RANGE}
    monitoring = results["state"] == MONITORING
    # Past the start-up, too, no constant: J_th follows the drive.
    assert np.ptp(results["J_th"][monitoring]) > reference.threshold
    assert results["excited"][monitoring].any() and not results["excited"][monitoring].all()


@pytest.mark.parametrize("seed", range(4))
def test_invalid_inputs(detector, reference, seed):
    inputs = random_drive(seed, SAMPLES, reference.period)
    rng = np.random.default_rng(1000 + seed)
    for start in rng.integers(0, SAMPLES, 40):
        length = rng.integers(1, 20)
        signal = rng.integers(len(INPUTS))
        beyond = np.nextafter(LIMITS[signal], np.inf)
        bad = rng.choice([np.nan, np.inf, -np.inf, beyond, -beyond, -1e300])
        inputs[INPUTS[signal]][start : start + length] = bad
    for signal, limit in zip(INPUTS, LIMITS):  # a limit itself is valid
        inputs[signal][rng.integers(0, SAMPLES, 3)] = rng.choice([limit, -limit])
    inputs["u.delta"][:3] = np.nan  # not even a first result
    results = compare(detector, reference, inputs)
    assert set(results["state"]) == {MONITORING, OUT_OF_RANGE, INVALID_INPUT}
    causes = {NOTHING, SPEED, YAW_RATE, DRIVE_TORQUE, STEERING_ANGLE}
    assert causes <= set(results["state_cause"])


def in_parts(rng, n, shortest, longest):
    """1 and 0 in turn, each for a random number of samples."""
    lengths = rng.integers(shortest, longest, n // shortest + 1)
    return (np.repeat(np.arange(len(lengths)), lengths) + 1)[:n] % 2


@pytest.mark.parametrize("seed", range(3))
def test_switched_off_and_on(example, seed):
    detector, reference = example
    rng = np.random.default_rng(2000 + seed)
    inputs = random_drive(seed, SAMPLES, reference.period)
    inputs["enabled"] = in_parts(rng, SAMPLES, 10, 400)
    inputs["u.delta"][rng.integers(0, SAMPLES, 5)] = np.nan  # invalid comes before switched off
    results = compare(detector, reference, inputs)
    assert set(results["state"]) | {OUT_OF_RANGE} == {MONITORING, OUT_OF_RANGE, DISABLED, INVALID_INPUT}
    off = results["state"] == DISABLED
    assert results["alarm"].any() and not results["alarm"][off].any()
    assert results["alarm_latched"][off].any(), "what was once raised stays latched"


@pytest.mark.parametrize("stale_after_s", [0.0, 0.05, 0.5])
@pytest.mark.parametrize("seed", range(3))
def test_measurements_that_stop(detector, reference, stale_after_s, seed):
    """Both stop for a while and go on where they were or elsewhere, or one of them stops alone."""
    rng = np.random.default_rng(3000 + seed)
    inputs = random_drive(seed, SAMPLES, reference.period, v_x=(3.0, 32.0))
    for start in rng.integers(0, SAMPLES, 15):
        stop = start + rng.integers(3, 200)
        for name in [("v_x", "r"), ("v_x", "r"), ("v_x",), ("r",)][rng.integers(4)]:
            inputs[name][start:stop] = inputs[name][start]
    parameters = {"stale_after_s": stale_after_s}
    results = compare(detector, reference, inputs, parameters, **parameters)
    assert (STALE_INPUT in results["state"]) == (stale_after_s > 0)
    stale = results["state"] == STALE_INPUT
    assert not results["detectability"][stale].any()
    assert not np.diff(results["alarm"])[stale[1:]].any(), "none begins, none ends"


@pytest.mark.parametrize("alarm_hold_s", [0.0, 0.3, 2.0])
def test_alarm_hold(detector, reference, alarm_hold_s):
    """Alarms end only after a time of monitoring below the threshold; what hides J delays that."""
    inputs = random_drive(14, SAMPLES, reference.period)
    rng = np.random.default_rng(4000)
    for start in rng.integers(0, SAMPLES, 10):
        inputs["v_x"][start : start + rng.integers(1, 30)] = np.nan
    # As high as J goes, so that it sinks below now and then.
    parameters = {"alarm_hold_s": alarm_hold_s, "threshold_factor": 10.0}
    results = compare(detector, reference, inputs, parameters, **parameters)
    alarm, state = results["alarm"], results["state"]
    assert alarm[state == OUT_OF_RANGE].any(), "held out of range"
    assert alarm[state == INVALID_INPUT].any(), "held while invalid"
    held = alarm & (state == MONITORING) & (results["J_rms"] < results["J_th"])
    assert held.any()


@pytest.mark.parametrize("seed", range(3))
def test_everything_uncertain(everything, seed):
    """Every cause, actuator and zero; invalid commands, which the actuator bridges; switched off."""
    detector, reference = everything
    rng = np.random.default_rng(5000 + seed)
    inputs = random_drive(seed, SAMPLES, reference.period)
    inputs["enabled"] = in_parts(rng, SAMPLES, 100, 600)
    for start in rng.integers(0, SAMPLES, 20):
        signal = rng.choice(INPUTS)
        inputs[signal][start : start + rng.integers(1, 15)] = rng.choice([np.nan, 1e9])
    inputs["u.delta"][:2] = np.nan
    results = compare(detector, reference, inputs)
    assert set(results["state"]) == {MONITORING, OUT_OF_RANGE, DISABLED, INVALID_INPUT}
    assert results["alarm"].any() and not results["alarm"].all()


@pytest.mark.parametrize("cause", ["mass", "friction", "load_transfer", "steering_ratio", "v_x_scale"])
def test_everything_has_a_part(everything, cause):
    """What the comparison would miss, did the reference not know a cause."""
    _, reference = everything
    inputs = random_drive(0, 500, reference.period, v_x=(8.0, 28.0), r=(-0.3, 0.3))
    j_th = expected(reference, inputs)["J_th"]
    bounds = reference.uncertainty
    without = np.inf if cause == "friction" else 0.0
    reference.uncertainty = dataclasses.replace(bounds, **{cause: without})
    try:
        lower = expected(reference, inputs)["J_th"]
    finally:
        reference.uncertainty = bounds
    assert np.max(j_th / lower) > 1 + 1e-6


def test_zeros_of_sensors(example):
    detector, reference = example
    inputs = random_drive(15, SAMPLES, reference.period)
    inputs["u.delta"][100:110] = 1e9
    zeros = {"steering_offset": 0.02, "yaw_rate_bias": -0.015}
    shifted = compare(detector, reference, inputs, zeros, **zeros)
    assert np.max(np.abs(shifted["J_rms"] - expected(reference, inputs)["J_rms"])) > 0


@pytest.mark.parametrize("debounce", [1, 2, 7, 1000])
def test_debounce(detector, reference, debounce):
    inputs = random_drive(11, SAMPLES, reference.period, v_x=(8.0, 28.0), r=(-0.3, 0.3))
    results = compare(
        detector, reference, inputs, {"debounce_samples": debounce}, debounce=debounce
    )
    assert results["alarm"].any() or debounce > 7


@pytest.mark.parametrize("factor", [0.25, 1.0, 40.0])
def test_threshold_factor(detector, reference, factor):
    inputs = random_drive(12, SAMPLES, reference.period)
    compare(detector, reference, inputs, {"threshold_factor": factor}, threshold_factor=factor)


@pytest.mark.parametrize("z_0", [(0.0, 0.0, 0.0), (14.0, -0.3, 0.1)])
def test_given_initial_state(detector, reference, z_0):
    inputs = random_drive(13, SAMPLES, reference.period, v_x=(8.0, 28.0), r=(-0.3, 0.3))
    given = {"initialisation": 2} | {f"z_0[{i + 1}]": z for i, z in enumerate(z_0)}
    compare(detector, reference, inputs, given, z_0=z_0)


def straight(n, v_x):
    return {
        "v_x": np.full(n, v_x),
        "r": np.zeros(n),
        "u.T_eng": np.full(n, 78.75),
        "u.delta": np.zeros(n),
    }


def test_estimate_out_of_range_and_back(detector, reference):
    """A steering angle that the measured yaw rate does not follow drives the estimate out."""
    phase = np.arange(SAMPLES) % 1000

    def inputs(angle):
        return straight(SAMPLES, 15.0) | {"u.delta": np.where(phase < 500, 0.0, angle)}

    def left(angle):
        return expected(reference, inputs(angle))["state"] == OUT_OF_RANGE

    # How large the angle must be depends on the gains.
    angle = next(angle for angle in np.linspace(0.1, LIMITS[3], 16) if left(angle).any())
    results = compare(detector, reference, inputs(angle))
    assert LATERAL_SPEED in results["state_cause"][left(angle)]
    assert results["alarm"][left(angle)].all(), "what raised an alarm before holds it"
    assert results["state"][phase == 499].tolist() == [MONITORING] * 3, "must come back"
    assert not results["alarm"][phase == 499].any()


@pytest.mark.parametrize("debounce", [1, 20])
def test_range_alarm(detector, reference, debounce):
    """The yaw rate leaves S_x at once while the command holds straight: no residual is left to tell."""
    phase = np.arange(SAMPLES) % 1000
    inputs = straight(SAMPLES, 15.0)
    inputs["r"] = np.where(phase < 500, 0.0, reference.bounds[2, 1] + 0.1)
    # From the start, too: motions that begin there tell nothing for a window.
    inputs["r"][:100] = reference.bounds[2, 1] + 0.1
    inputs["r"][505:510] = np.nan
    results = compare(detector, reference, inputs, {"debounce_samples": debounce}, debounce=debounce)
    begins = reference.window + debounce - 1  # the sample after the window, and those that debounce
    assert results["alarm_cause"][begins - 1] == NO_ALARM and results["alarm_cause"][begins] == RANGE
    out = phase >= 510 + begins
    assert set(results["alarm_cause"][out]) == {RANGE}
    assert results["state_cause"][999] == YAW_RATE
    assert results["alarm_cause"][499] == NO_ALARM


def test_command_that_leads_out_is_no_alarm(detector, reference):
    """Where the reference motions leave S_x too, the driver has asked for it."""
    n = 1000
    inputs = straight(n, 15.0)
    wheelbase = reference.l_f + reference.l_r
    turn = 2 * reference.bounds[2, 1] * wheelbase / 15.0  # without understeer twice what S_x holds
    inputs["u.delta"] = turn * np.clip(np.arange(n) / 500, 0, 1)
    y = np.column_stack([inputs["v_x"], inputs["r"]])
    nobody = np.zeros(n, dtype=bool)
    torque, angle = inputs["u.T_eng"], inputs["u.delta"]
    obeying = reference.follow(~nobody, y, torque, angle, nobody).motions[:, 0]
    inputs["r"] = obeying[:, 1]
    high = {"threshold_factor": 1000.0}  # J is not what this is about
    results = compare(detector, reference, inputs, high, **high)
    assert (results["state"][-100:] == OUT_OF_RANGE).all()
    assert set(results["alarm_cause"]) == {NO_ALARM}


def test_both_causes_of_an_alarm(detector, reference):
    """A residual's alarm keeps its cause where the range would raise one."""
    inputs = straight(SAMPLES, 15.0)
    inputs["u.delta"][500:] = 0.02  # not followed
    inputs["r"][700:] = reference.bounds[2, 1] + 0.1
    results = compare(detector, reference, inputs)
    assert results["alarm_cause"][-1] == RESIDUAL and results["state"][-1] == OUT_OF_RANGE
