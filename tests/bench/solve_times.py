"""Time of one synthesis: the designer against the same problem in a modelling language.

    python tests/bench/solve_times.py [ROUNDS]

Needs numpy, cvxpy with clarabel, and matplotlib. Both sides minimise gamma at 0.97 of the bound on
beta, method 4, in turn: what else the machine does meets both alike. Both use the solver
Clarabel. Counted is all from the problem's data to its gains: on this side assembly and solver, on
the other building the expressions, canonicalisation and solver. Ends with an error where the optima
differ or the ratio is below FASTER. Then draws how the designer's time grows with the problem:
target/solve_times.png.
"""

import json
import os
import pathlib
import platform
import re
import statistics
import subprocess
import sys
import time
import warnings
from importlib.metadata import version

import cvxpy as cp
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "designer/tests/fixtures"))
import synthesis_optima as reference  # noqa: E402

FASTER = 5
SAME_OPTIMUM = 2e-3
CARGO = ["cargo", "run", "--quiet", "--release", "-p", "steerguard-designer", "--example", "solve_times", "--"]
PROBLEMS = {"paper": reference.SIDE_WIND, "two disturbances": reference.LATERAL_AND_YAW}


def designer(*arguments):
    output = subprocess.run([*CARGO, *arguments], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return [json.loads(line) for line in output.splitlines()]


def modelled(d):
    """Seconds, those of the solver alone, and gamma."""
    solved = []
    solve = cp.Problem.solve
    # The reference keeps its problem to itself: note it when it is solved.
    cp.Problem.solve = lambda problem, **options: (solved.append(problem), solve(problem, **options))[1]
    try:
        start = time.perf_counter()
        beta = 0.97 * np.linalg.norm(reference.C @ reference.F) / 2
        result = reference.solve(d, 2.0, 1.0, reference.F.T, 0.97, beta=beta)
        seconds = time.perf_counter() - start
    finally:
        cp.Problem.solve = solve
    return seconds, solved[0].solver_stats.solve_time, result["optimum"]


def conditions(rounds):
    """What was measured, where and with what."""
    try:
        model = re.search("model name\\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())[1]
    except (OSError, TypeError):
        model = platform.processor()
    lock = (ROOT / "Cargo.lock").read_text()
    clarabel = re.search('name = "clarabel"\nversion = "(.*)"', lock)[1]
    print(f"problem    smallest gamma at 0.97 of the bound on beta: {', '.join(PROBLEMS)}")
    print(f"machine    {model}, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}, {platform.system()}")
    print(f"method     median of {rounds} rounds, both in turn, release build; wall clock; solvers' own default settings")
    print(f"versions   clarabel {clarabel} (designer); clarabel {version('clarabel')}, cvxpy {cp.__version__},"
          f" numpy {np.__version__}, Python {platform.python_version()}\n")


def compare(rounds):
    ours = {name: [] for name in PROBLEMS}
    theirs = {name: [] for name in PROBLEMS}
    for _ in range(rounds):
        for line in designer():
            ours[line["series"]].append((line["seconds"], line["gamma"]))
        for name, d in PROBLEMS.items():
            theirs[name].append(modelled(d))
    failed = False
    for name in PROBLEMS:
        seconds = statistics.median(x[0] for x in ours[name])
        modelled_seconds, solver = (statistics.median(x[k] for x in theirs[name]) for k in (0, 1))
        ratio = modelled_seconds / seconds
        # S1's disturbances count in units of their bounds on both sides.
        gammas = ours[name][0][1], theirs[name][0][2]
        print(f"{name}: designer {seconds:.3f} s, cvxpy {modelled_seconds:.2f} s (its solver {solver:.2f} s),"
              f" ratio {ratio:.1f}; gamma {gammas[0]:.6f}, {gammas[1]:.6f}")
        failed |= ratio < FASTER or abs(gammas[0] / gammas[1] - 1) > SAME_OPTIMUM
    return failed


def draw(rounds):
    times = {}
    for _ in range(rounds):
        for line in designer("growth"):
            times.setdefault(line["series"], {}).setdefault(line["size"], []).append(line["seconds"])
    figure, all_axes = plt.subplots(1, len(times), sharey=True, figsize=(10, 3.6), layout="constrained")
    print()
    for axes, (series, points) in zip(all_axes, times.items()):
        sizes = sorted(points)
        medians = [statistics.median(points[size]) for size in sizes]
        for size in sizes:
            axes.plot([size] * len(points[size]), points[size], ".", color="0.7")
        axes.plot(sizes, medians, "o-", color="C0")
        axes.set_xlabel(f"number of {series}")
        axes.set_xticks(sizes)
        axes.grid(alpha=0.3)
        print(f"{series}:", ", ".join(f"{size}: {x:.3f} s" for size, x in zip(sizes, medians)))
    all_axes[0].set_ylim(bottom=0)
    all_axes[0].set_ylabel("time of a synthesis, s")
    figure.suptitle("Time of a synthesis: runs (grey) and their median")
    path = ROOT / "target/solve_times.png"
    path.parent.mkdir(exist_ok=True)
    figure.savefig(path, dpi=120)
    print(f"\nDrawn: {path.relative_to(ROOT)}")


def main():
    # "Solution may be inaccurate": beta is near its bound. The optima are compared instead.
    warnings.filterwarnings("ignore", message="Solution may be inaccurate")
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 7
    designer()  # Builds it, and warms up.
    conditions(rounds)
    failed = compare(rounds)
    draw(rounds)
    sys.exit(f"below {FASTER} times as fast, or another optimum" if failed else 0)


if __name__ == "__main__":
    main()
