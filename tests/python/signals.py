"""Names of the detector's variables, input signals, and the comparison with the reference.

Conventions: inputs and results are mappings of names to arrays with one row for each communication
step; row k of the results is what the detector shows after step k.
"""

import numpy as np

INPUTS = ["v_x", "r", "u.T_eng", "u.delta"]
OUTPUTS = [
    "residual.v_x", "residual.r", "v_y_hat", "J_rms", "J_th", "J_ratio",
    "detectability", "excited", "alarm", "alarm_latched", "first_alarm_time",
    "alarm_cause", "fault_hypothesis", "state", "state_cause",
    "second_ratio", "fault_estimate", "fault_estimate_bound", "fault_onset_time",
]  # fmt: skip
RELATIVE_TOLERANCE = 1e-12
SECOND_RELATIVE_TOLERANCE = 1e-9  # of the second test, which sums up over samples


def random_drive(seed, n, period, v_x=(4.0, 31.5), r=(-0.65, 0.65)):
    """Smooth measurements that range over the intervals and beyond what the vehicle would do."""
    rng = np.random.default_rng(seed)
    t = period * np.arange(n)

    def wander(low, high):
        """A sum of sines, scaled to touch both ends."""
        frequency_hz, phase = rng.uniform(0.02, 0.4, 6), rng.uniform(0, 2 * np.pi, 6)
        x = np.sin(2 * np.pi * np.outer(t, frequency_hz) + phase).sum(axis=1)
        return low + (high - low) * (x - x.min()) / np.ptp(x)

    return {
        "v_x": wander(*v_x),
        "r": wander(*r),
        "u.T_eng": wander(-2000.0, 2000.0),
        "u.delta": wander(-0.05, 0.05),
    }


def expected(reference, inputs, step=None, start_time=0.0, **parameters):
    """The reference's results for `inputs` that change at the communication points only.

    `inputs` may hold `enabled`.

    Sample k runs in the communication step that holds its time k T_s, a millionth of T_s early
    counting as there.
    """
    n = len(inputs["v_x"])
    points = np.arange(n + 1) * (step or reference.period)
    first = np.ceil(points / reference.period - 1e-6).astype(int)  # first sample not before a point
    row = np.searchsorted(first, np.arange(first[-1]), side="right") - 1  # step of each sample
    y = np.column_stack([inputs["v_x"], inputs["r"]])[row]
    u = np.column_stack([inputs["u.T_eng"], inputs["u.delta"]])[row]
    if "enabled" in inputs:
        parameters["enabled"] = np.asarray(inputs["enabled"])[row]
    columns = reference.run(y, u, **parameters).columns(reference.period, start_time)
    return {name: column[first[1:] - 1] for name, column in columns.items()}


def assert_agree(found, expected, inputs, weights):
    """Compares two records of the detector's results.

    Truth values and states are equal at every row. Reals agree to 1e-12 of their largest value, and
    to the rounding of what they are computed from, which matters where a signal is small: a residual
    is the difference of a measurement and its estimate, both of the size of v_x, computed in another
    order of operations here than there. 16 roundings of v_x are allowed for (6e-14 m/s at 15 m/s),
    times the weights for J, over J_th for J_ratio.
    """
    exact = ["excited", "alarm", "alarm_latched", "alarm_cause", "fault_hypothesis", "state", "state_cause"]
    for name in exact:
        different = np.flatnonzero(np.asarray(found[name]) != expected[name])
        assert different.size == 0, f"{name} differs first at row {different[0]}"
    with np.errstate(invalid="ignore"):
        speeds = np.abs(inputs["v_x"])
        rounding = 16 * np.finfo(float).eps * np.max(speeds[speeds < 100.0])
    roundings = {
        "residual.v_x": rounding,
        "residual.r": rounding,
        "v_y_hat": rounding,
        "J_rms": rounding * max(weights),
        "J_th": 0.0,
        "J_ratio": rounding * max(weights) / np.min(expected["J_th"]),
        "detectability": 0.0,
        "first_alarm_time": 0.0,
    }
    for name, rounding in roundings.items():
        allowed = RELATIVE_TOLERANCE * np.max(np.abs(expected[name])) + rounding
        worst = np.max(np.abs(found[name] - expected[name]))
        assert worst <= allowed, f"{name} differs by {worst:.1e}, more than {allowed:.1e}"
    for name in ["second_ratio", "fault_estimate", "fault_estimate_bound", "fault_onset_time"]:
        allowed = SECOND_RELATIVE_TOLERANCE * np.max(np.abs(expected[name]))
        worst = np.max(np.abs(found[name] - expected[name]))
        assert worst <= allowed, f"{name} differs by {worst:.1e}, more than {allowed:.1e}"
