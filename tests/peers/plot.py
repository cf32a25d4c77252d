"""Probability and delay of detection by size of the bias, with what some pair of drives hides from any detector (limit.py).

Conventions: sizes in classes of 0.05 deg, a class needs five drives; delays are medians, those of misses infinite.
"""

import matplotlib

matplotlib.use("Agg")

import numpy as np  # noqa: E402
from matplotlib import pyplot  # noqa: E402

CLASS_DEG, UP_TO_DEG, FEWEST = 0.05, 1.0, 5
CONDITION = "perturbed"


def by_size(detector):
    """Middle of each class of sizes, share detected, median delay (infinite where most are missed)."""
    sizes = np.array(detector["sizes_deg"])
    delays = np.array([np.inf if delay is None else delay for delay in detector["delays_s"]])
    for low in np.arange(0, UP_TO_DEG - CLASS_DEG / 2, CLASS_DEG):
        of_class = delays[(sizes >= low) & (sizes < low + CLASS_DEG)]
        if len(of_class) >= FEWEST:
            yield low + CLASS_DEG / 2, np.isfinite(of_class).mean(), np.median(of_class)


def draw(result, path):
    """Draws `result` of compare.py into the file at `path`."""
    [condition] = [c for c in result["conditions"] if c["driven"] == c["set_on"] == CONDITION]
    hidden = [limit[of] for limit in result["limits"] for of in ("known_car_deg", "two_cars_deg")]
    figure, (share, delay) = pyplot.subplots(2, 1, sharex=True, figsize=(8, 7), layout="constrained")
    lines = ["-", "--", "-.", ":"]
    for k, detector in enumerate(condition["detectors"]):
        sizes, shares, delays = np.array(list(by_size(detector))).reshape(-1, 3).T
        style = {"linestyle": lines[k % len(lines)], "marker": "osv^<>dx"[k % 8], "markersize": 4}
        share.plot(sizes, 100 * shares, label=detector["detector"], **style)
        seen = np.isfinite(delays)
        delay.plot(sizes[seen], np.maximum(delays[seen], 0.01), **style)
    for axes in (share, delay):
        axes.axvspan(min(hidden), max(hidden), color="0.85", zorder=0)
        axes.grid(alpha=0.3)
    share.axvspan(np.nan, np.nan, color="0.85", label="some pair of drives hides it from any detector")
    share.set(ylabel="detected, %", ylim=(-3, 103))
    share.legend(fontsize=8, loc="lower right")
    delay.set(xlabel="bias of the road wheel, deg", ylabel="median delay, s", yscale="log", ylim=(0.01, 20), xlim=(0, UP_TO_DEG))
    settings = result["settings"]
    figure.suptitle(
        "Uncertain vehicles, bank and gusts; {drives} drives of {duration:.0f} s, seed {seed};\n"
        "thresholds but those as shipped let {allowed} fault-free drives alarm in {hours:.1f} h".format(
            allowed=condition["drives_with_alarm"], hours=condition["fault_free_hours"], **settings
        ),
        fontsize=10,
    )
    figure.savefig(path)
    pyplot.close(figure)
