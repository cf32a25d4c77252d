"""Inputs of commands that are quick: a specification designed in two seconds, a recorded drive, what is known of its car."""

import subprocess

# Blind: the threshold is a number, so that no drive is simulated for it.
QUICK = """
[noise.v_x]
white_std_m_per_s = 0.0

[noise.r]
white_std_rad_per_s = 0.0

[design]
method = "paper"
decay = 0.97

[evaluation]
threshold = "constant"
constant = 0.01
"""
# The vehicle of the paper, all but its sensors.
KNOWN = """
[vehicle]
mass_kg = 1476.0
yaw_inertia_kg_m2 = 1810.0
effective_longitudinal_inertia_kg_m = 442.8
front_axle_distance_m = 1.13
rear_axle_distance_m = 1.49
front_cornering_stiffness_n_per_rad = 57000.0
rear_cornering_stiffness_n_per_rad = 59000.0
longitudinal_drag_n_m_s2_per_m2 = 0.35
lateral_drag_n_s2_per_m2 = 0.45
centre_of_gravity_height_m = 0.0
"""


def recorded(steerguard, fixtures):
    """A drive of a minute in the simulated world, as CSV: a step of the steering at 6.3 m/s."""
    drives = ["--drives", "1", "--duration", "60", "--faults", "none", "--nominal", "--drive", "0"]
    command = [steerguard, "campaign", fixtures / "design.json", *drives]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def write_inputs(steerguard, fixtures, folder, speeds):
    """Writes drive.csv, known.toml, quick.toml and short.toml, a scenario of 8 s at `speeds` in m/s, into `folder`."""
    (folder / "drive.csv").write_text(recorded(steerguard, fixtures), encoding="utf-8")
    (folder / "known.toml").write_text(KNOWN, encoding="utf-8")
    (folder / "quick.toml").write_text(QUICK, encoding="utf-8")
    (folder / "short.toml").write_text(f"duration_s = 8\ninitial_speeds_m_per_s = {speeds}\n", encoding="utf-8")
