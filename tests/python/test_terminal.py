"""What the command prints on a terminal, which is 80 columns wide, and in a pipe, which has no width."""

import fcntl
import os
import re
import struct
import subprocess
import termios

import pytest
from quick import write_inputs

COLUMNS = 80
# What a progress bar does to its line before it draws it anew.
CLEARED = "\x1b[2K"


def on_terminal(steerguard, *arguments, columns=None, folder=None, status=0):
    """All that the command writes to standard output and standard error output, both on a terminal."""
    environment = {name: value for name, value in os.environ.items() if name != "COLUMNS"}
    if columns is not None:
        environment["COLUMNS"] = str(columns)
    ours, theirs = os.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, COLUMNS, 0, 0))
    process = subprocess.Popen(
        [steerguard, *map(str, arguments)], stdout=theirs, stderr=theirs, env=environment, cwd=folder
    )
    os.close(theirs)
    printed = b""
    # A terminal whose other side is closed cannot be read.
    while chunk := read(ours):
        printed += chunk
    os.close(ours)
    assert process.wait(timeout=300) == status, printed.decode()
    return printed.decode().replace("\r\n", "\n")


def left(text):
    """What is left to read once all is done: without what was cleared, and without colours."""
    lines = (line.rsplit(CLEARED, 1)[-1] for line in text.split("\n"))
    return "\n".join(re.sub(r"\x1b\[[0-9;?]*[A-Za-z]|\r", "", line) for line in lines)


def read(terminal):
    try:
        return os.read(terminal, 65536)
    except OSError:
        return b""


@pytest.fixture(scope="module")
def folder(steerguard, fixtures, tmp_path_factory):
    folder = tmp_path_factory.mktemp("a_folder_whose_path_alone_is_nearly_as_long_as_a_line_of_a_terminal")
    write_inputs(steerguard, fixtures, folder, [5, 15])
    return folder


FAULTS = ["--fault", "bias=0.5@30s", "--fault", "loss=0.3@30s"]
# Arguments, exit status, and whether it can take more than a second, so that it says meanwhile what it does.
COMMANDS = {
    "init": (["init", "car.toml"], 0, False),
    "identify": (["identify", "drive.csv", "--known", "known.toml", "-o", "found.toml"], 0, True),
    "design": (["design", "quick.toml", "-o", "quick.json"], 1, True),
    "verify": (["verify", "{fixtures}/design.json"], 0, True),
    "package": (["package", "{fixtures}/design.json", "-o", "X.fmu"], 0, True),
    "check": (["check", "{fixtures}/SteeringFaultDetector.fmu"], 0, True),
    "simulate": (["simulate", "--detector", "X.fmu", "--scenario", "short.toml"], 0, True),
    "campaign": (["campaign", "{fixtures}/design.json", "--drives", "20", "--duration", "10", "-o", "drives"], 0, True),
    "worst": (["campaign", "{fixtures}/design.json", "--worst", "--budget", "100", "-o", "worst"], 0, True),
    "replay": (["replay", "{fixtures}/design.json", "drive.csv", *FAULTS, "-o", "replay"], 0, True),
    "report": (["report", "{fixtures}/design.json", "--replay", "replay"], 0, True),
    "help": (["--help"], 0, False),
    "help of replay": (["replay", "-h"], 0, False),
    "help of campaign": (["campaign", "-h"], 0, False),
    "help of identify": (["identify", "-h"], 0, False),
}


@pytest.mark.parametrize("name", COMMANDS)
def test_no_line_is_longer_than_a_terminal(steerguard, fixtures, folder, name):
    arguments, status, slow = COMMANDS[name]
    arguments = (word.format(fixtures=fixtures) for word in arguments)
    printed = on_terminal(steerguard, *arguments, folder=folder, status=status)
    assert (CLEARED in printed) == slow, printed
    text = left(printed)
    words = [line for line in text.split("\n") if " " in line.strip()]
    assert words
    # A path is not broken, whatever its length.
    assert max(map(len, words)) <= COLUMNS or all("/" in line for line in words if len(line) > COLUMNS), text


@pytest.mark.parametrize("table", ["False alarms, with 95 % intervals", "Detections, with 95 % intervals"])
def test_a_row_of_a_table_is_one_line(steerguard, fixtures, folder, table):
    campaign = ["campaign", fixtures / "design.json", "--drives", "20", "--duration", "10", "-o", "drives"]
    text = left(on_terminal(steerguard, *campaign, folder=folder))
    rows = text.split(table)[1].split("\n\n")[0].splitlines()[1:]
    assert len(rows) > 3 and all(re.match(r"  \S", row) for row in rows), text


def test_what_is_made_for_a_shell_stays_whole(steerguard):
    text = on_terminal(steerguard, "completions", "bash")
    piped = subprocess.run([steerguard, "completions", "bash"], check=True, capture_output=True, text=True).stdout
    assert text == piped


def test_lines_in_a_pipe_stay_whole(steerguard, fixtures):
    environment = {**os.environ, "COLUMNS": "40"}
    command = [steerguard, "check", fixtures / "SteeringFaultDetector.fmu"]
    run = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    assert run.stdout == f"{fixtures / 'SteeringFaultDetector.fmu'}: no findings\n"


def test_columns_names_the_width(steerguard, fixtures):
    text = left(on_terminal(steerguard, "verify", fixtures / "design.json", columns=60))
    # The digest is one word.
    lines = [line for line in text.splitlines() if " " in line.strip()]
    assert 40 < max(map(len, lines)) <= 60, text
