"""Runs a detector FMU over a table of signals, prints the first alarm and draws J with its threshold.

    python detect.py SteeringFaultDetector.fmu run.csv detection.png

The table is a CSV with a column for each of time, v_x, r, u.T_eng and u.delta, in s, m/s, rad/s, N m and rad; others
are passed over: those that `steerguard simulate` writes will do. Needs fmpy and matplotlib.
"""

import sys

import fmpy
import matplotlib
import numpy as np

matplotlib.use("Agg")  # no window
from matplotlib import pyplot

INPUTS = ["v_x", "r", "u.T_eng", "u.delta"]
OUTPUTS = ["J_rms", "J_th", "alarm", "state"]


def read(path):
    """The table's inputs, as fmpy takes them."""
    table = np.genfromtxt(path, delimiter=",", names=True, dtype=None, encoding="utf-8", deletechars="")
    inputs = np.zeros(len(table), dtype=[(name, float) for name in ["time", *INPUTS]])
    for name in inputs.dtype.names:
        if name not in table.dtype.names:
            sys.exit(f"{path}: no column {name}; there are {', '.join(table.dtype.names)}")
        inputs[name] = table[name]
    return inputs


def draw(result, path):
    """J and its threshold over time; where the alarm stands is shaded."""
    time, alarm = result["time"], result["alarm"].astype(bool)
    figure, axes = pyplot.subplots(figsize=(8, 4), layout="constrained")
    axes.semilogy(time, np.maximum(result["J_rms"], 1e-6), label="J")
    axes.semilogy(time, np.maximum(result["J_th"], 1e-6), "--", label="J_th")
    axes.fill_between(time, 0, 1, where=alarm, transform=axes.get_xaxis_transform(), alpha=0.15, label="alarm")
    axes.set(xlabel="time, s", ylabel="J", xlim=(time[0], time[-1]))
    axes.legend(loc="lower right")
    figure.savefig(path, dpi=120)


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    fmu, table, picture = sys.argv[1:]
    inputs = read(table)
    description = fmpy.read_model_description(fmu)
    period = float(description.defaultExperiment.stepSize)
    result = fmpy.simulate_fmu(
        fmu, stop_time=inputs["time"][-1], step_size=period, output_interval=period, input=inputs, output=OUTPUTS
    )
    alarm = result["alarm"].astype(bool)
    print(f"first alarm at {result['time'][alarm][0]:.2f} s" if alarm.any() else "no alarm")
    draw(result, picture)


if __name__ == "__main__":
    main()
