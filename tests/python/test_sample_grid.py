"""The detector samples on its own grid, whatever the communication step."""

import numpy as np
import pytest
from signals import OUTPUTS, assert_agree, expected, random_drive

DURATION_S = 60.0


@pytest.mark.parametrize("start_time", [0.0, -3.7, 1234.5])
@pytest.mark.parametrize("step", ["T_s", "2 T_s", "8 T_s", "T_s / 3", "1/60 s", "0.37 T_s"])
def test_any_communication_step(detector, reference, step, start_time):
    period = reference.period
    step_s = {
        "T_s": period,
        "2 T_s": 2 * period,
        "8 T_s": 8 * period,
        "T_s / 3": period / 3,
        "1/60 s": 1 / 60,
        "0.37 T_s": 0.37 * period,
    }[step]
    duration_s = DURATION_S if step_s >= period else DURATION_S / 4
    inputs = random_drive(3, round(duration_s / step_s), step_s)
    with detector.instance() as instance:
        instance.initialise(start_time=start_time)
        found = instance.record(inputs, OUTPUTS, step_s, start_time)
        assert not instance.complaints(), instance.complaints()
    results = expected(reference, inputs, step_s, start_time)
    assert_agree(found, results, inputs, reference.weights)
    assert results["alarm_latched"][-1]


def test_steps_may_vary(detector, reference):
    """The results after a step are those of the last sample in it, however the time was divided."""
    period = reference.period
    rng = np.random.default_rng(5)
    held = {"v_x": 15.0, "r": 0.05, "u.T_eng": 78.75, "u.delta": 0.01}
    divisions = np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 4.0, 300))]) * period
    with detector.instance() as even, detector.instance() as uneven:
        even.initialise()
        uneven.initialise()
        uneven.set(held)
        even.set(held)
        samples = 0
        for t, t_next in zip(divisions, divisions[1:]):
            uneven.doStep(t, t_next - t)
            while samples < np.ceil(t_next / period - 1e-6):
                even.doStep(samples * period, period)
                samples += 1
            assert uneven.get(OUTPUTS) == even.get(OUTPUTS)


def test_nothing_has_run_before_the_first_step(detector, reference):
    with detector.instance() as instance:
        instance.initialise({"v_x": 15.0})
        before = instance.get(OUTPUTS)
    assert before["state"] == 1, "Starting"
    assert before["residual.v_x"] == before["residual.r"] == before["J_rms"] == 0.0
    assert before["J_th"] == pytest.approx(reference.threshold, rel=1e-15)
    assert not before["alarm"] and before["first_alarm_time"] == -1.0


def test_input_derivatives_carry_inputs_through_a_long_step(detector, reference):
    """Inputs that are parabolas of time, with their derivatives set, as if sampled every T_s."""
    samples_per_step, steps = 8, 100
    period = reference.period
    # name: value at t = 0, first and second derivative
    courses = {
        "v_x": (12.0, 0.6, -0.02),
        "r": (-0.1, 0.03, 0.001),
        "u.T_eng": (100.0, -20.0, 5.0),
        "u.delta": (0.0, 0.004, -0.0002),
    }

    def at(t):
        return {n: x + t * v + t * t / 2 * a for n, (x, v, a) in courses.items()}

    results = {name: [] for name in OUTPUTS}
    with detector.instance() as instance:
        instance.initialise()
        for k in range(steps):
            t = k * samples_per_step * period
            instance.set(at(t))
            for n, (_, v, a) in courses.items():
                value_reference = instance.variables[n].valueReference
                instance.setRealInputDerivatives([value_reference] * 2, [1, 2], [v + t * a, a])
            instance.doStep(t, samples_per_step * period)
            for name, value in instance.get(OUTPUTS).items():
                results[name].append(value)
    inputs = at(period * np.arange(samples_per_step * steps))
    last = slice(samples_per_step - 1, None, samples_per_step)
    every = {name: column[last] for name, column in expected(reference, inputs).items()}
    assert_agree({n: np.array(v) for n, v in results.items()}, every, inputs, reference.weights)
    assert np.ptp(every["J_rms"]) > 0
