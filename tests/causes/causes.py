"""A table of causes: false alarms where one is driven and not stated, where it is stated, and what that costs.

Conventions
- The default specification otherwise; 60 s drives of the standard mix, seed 1; biases of up to 2 degrees, seed 2.
- "driven" widens the campaign by the cause alone; "stated" is a design whose [uncertainty] holds it, driven likewise.
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

CAUSES = [
    ("nothing", "", []),
    ("steering ratio 10 %", "uncertainty.steering_ratio_percent = [-10, 10]", ["--steering-ratio", "10"]),
    ("steering offset 0.3 deg", "uncertainty.steering_offset_deg = 0.3", ["--steering-offset", "0.3"]),
    ("yaw-rate bias 0.5 deg/s", "uncertainty.yaw_rate_bias_deg_per_s = 0.5", ["--r-bias", "0.00872664625997"]),
    ("speed scale 5 %", "uncertainty.v_x_scale_percent = 5", ["--v-x-scale", "5"]),
    ("friction 0.5", "uncertainty.friction = [0.5, 1.0]", ["--friction", "0.5..1"]),
    ("load transfer 100 %", "uncertainty.load_transfer_percent = 100", ["--load-transfer", "100"]),
    ("actuator lag 0.1 s", "uncertainty.actuator_lag_s = 0.1", ["--actuator-lag", "0.1"]),
]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steerguard", type=Path, required=True)
    parser.add_argument("--drives", type=int, default=600)
    a = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)

        def design(name, text):
            spec, path = folder / f"{name}.toml", folder / f"{name}.json"
            spec.write_text(text + "\n", encoding="utf-8")
            subprocess.run([a.steerguard, "design", spec, "-o", path], check=True, stdout=subprocess.DEVNULL)
            return path

        def campaign(path, name, *arguments):
            command = [a.steerguard, "campaign", path, "--drives", str(a.drives), "-o", folder / name, *arguments]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            return json.loads((folder / name / "report.json").read_text(encoding="utf-8"))

        def alarms(report):
            group = report["false_alarms"][0]
            return f"{group['episodes']} in {group['hours']:.1f} h, {group['largest_ratio']:.2f}"

        print(f"{a.drives} drives of 60 s each; false alarms and largest J/J_th; biases of up to 2 deg\n")
        print("| cause | driven, not stated | driven, stated | sure from deg | 1 deg, median / 95 % s |")
        print("|---|---|---|---|---|", flush=True)
        default = None
        for number, (cause, text, arguments) in enumerate(CAUSES):
            stated = design(f"design-{number}", text)
            default = default or stated
            none = ["--faults", "none", "--seed", "1", *arguments]
            unstated = alarms(campaign(default, f"unstated-{number}", *none)) if text else ""
            told = alarms(campaign(stated, f"stated-{number}", *none))
            biases = campaign(stated, f"biases-{number}", "--faults", "bias", "--fault-deg", "0..2", "--seed", "2")
            one = campaign(stated, f"one-{number}", "--faults", "bias", "--fault-deg", "1..1", "--seed", "2")
            sure = biases["detections"][0]["surely_detected_deg"]
            delays = [one["detections"][0][key] for key in ("delay_median_s", "delay_95_s")]
            shown = " / ".join("-" if delay is None else f"{delay:.2f}" for delay in delays)
            size = "none" if sure is None else f"{sure:.2f}"
            print(f"| {cause} | {unstated} | {told} | {size} | {shown} |", flush=True)


if __name__ == "__main__":
    main()
