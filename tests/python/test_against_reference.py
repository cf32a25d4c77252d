"""Every result of the packaged detector against the equations in numpy, on the same inputs."""

import numpy as np
import pytest
from reference import INVALID_INPUT, MONITORING, OUT_OF_RANGE
from signals import OUTPUTS, assert_agree, expected, random_drive

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
    assert set(results["state"]) == {MONITORING, OUT_OF_RANGE}
    monitoring = results["state"] == MONITORING
    # Past the start-up, too, no constant: J_th follows the drive.
    assert np.ptp(results["J_th"][monitoring]) > reference.threshold
    assert results["excited"][monitoring].any() and not results["excited"][monitoring].all()


@pytest.mark.parametrize("seed", range(4))
def test_invalid_inputs(detector, reference, seed):
    inputs = random_drive(seed, SAMPLES, reference.period)
    rng = np.random.default_rng(1000 + seed)
    names = list(inputs)
    bad = [np.nan, np.inf, -np.inf, 1e9, -1e300]
    for start in rng.integers(0, SAMPLES, 40):
        length = rng.integers(1, 20)
        inputs[rng.choice(names)][start : start + length] = rng.choice(bad)
    inputs["u.delta"][:3] = np.nan  # not even a first result
    results = compare(detector, reference, inputs)
    assert set(results["state"]) == {MONITORING, OUT_OF_RANGE, INVALID_INPUT}


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


def test_estimate_out_of_range_and_back(detector, reference):
    """A steering angle that the measured yaw rate does not follow drives the estimate out."""
    phase = np.arange(SAMPLES) % 1000

    def inputs(angle):
        return {
            "v_x": np.full(SAMPLES, 15.0),
            "r": np.zeros(SAMPLES),
            "u.T_eng": np.full(SAMPLES, 78.75),
            "u.delta": np.where(phase < 500, 0.0, angle),
        }

    def left(angle):
        return expected(reference, inputs(angle))["state"] == OUT_OF_RANGE

    # How large the angle must be depends on the gains.
    angle = next(angle for angle in 0.1 * 1.5 ** np.arange(20) if left(angle).any())
    results = compare(detector, reference, inputs(angle))
    assert not results["alarm"][left(angle)].any()
    assert results["state"][phase == 499].tolist() == [MONITORING] * 3, "must come back"
