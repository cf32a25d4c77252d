"""Vehicles that nobody here has written drive the packaged FMU: recordings of CommonRoad's BMW 320i (tests/commonroad).

Conventions: 21 s of varied driving with braking in turns on each model, and sines of 0.3 Hz at 18 m/s and 2 m/s^2 in
which the wheel stands 1 degree off from 6 s on. Made in tests/commonroad by
    record.py recorded --cars 2 --minutes 0.35 --seed 446 --degrees 1 --speeds 18 --laterals 2
"""

import hashlib
import sys
from pathlib import Path

import pytest

COMMONROAD = Path(__file__).resolve().parents[1] / "commonroad"
sys.path.insert(0, str(COMMONROAD))

import judge  # noqa: E402

RECORDED = COMMONROAD / "recorded"
DIGESTS = {
    "car2.toml": "10b11372c7ab38b50f776aa40a0a79e36dc5454039562b212803f75ab70ac474",
    "car2_st.parquet": "80a087f644fcaa13b007a8093787f23f4ff2956d435df3601f4948aa885ac792",
    "car2_st_sines.parquet": "3167145ad6df4a4bb2f7763b92155260d1b321e88c0774474c4e2f0d4a0025aa",
    "car2_std.parquet": "743a369eb6e153253d93d08749969d6868c54e46c65a7f18e740f4a04286bf21",
    "car2_std_sines.parquet": "fc28b45bdccf7f6f23a91ec6f82a72607222c73e9cad4125357426f1ed1e3a37",
    "car2_mb.parquet": "63d0f8dc023414cc71282975a90cf0084ea4543ee47adb86a42a2d2bc6bd39fe",
    "car2_mb_sines.parquet": "346e7bb5afbd8854b71b6f534a14fa1cc749c71dde061e909fdf47257222afe3",
}
MODELS = ["st", "std", "mb"]


@pytest.fixture(scope="module")
def car(steerguard, tmp_path_factory):
    return judge.detector(steerguard, RECORDED / "car2.toml", tmp_path_factory.mktemp("commonroad") / "car2")


def test_recordings_are_those_of_the_command():
    found = {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in RECORDED.iterdir()}
    assert found == DIGESTS


@pytest.mark.parametrize("model", MODELS)
def test_varied_driving_raises_no_alarm_and_is_monitored(car, model):
    columns = judge.read(RECORDED / f"car2_{model}.parquet")
    slowing = (columns["v_x"][25:] - columns["v_x"][:-25]) / 0.25 < -1
    turning = abs(columns["v_x"] * columns["r"])[25:] > 1
    assert (slowing & turning).sum() > 70, "it brakes in a turn"
    seen = judge.watch(car, columns)
    assert not seen["alarm"].any()
    assert (seen["state"] == judge.MONITORING).mean() >= 0.97


@pytest.mark.parametrize("model", MODELS)
def test_a_degree_in_a_sine_is_found_within_a_quarter_of_a_second(car, model):
    drives = list(judge.sines(judge.read(RECORDED / f"car2_{model}_sines.parquet")))
    assert [drive["degrees"][0] for drive in drives] == [1, -1]
    for drive in drives:
        delay = judge.delay(car, drive)
        assert delay is not None and 0 <= delay <= 0.25, drive["degrees"][0]
