"""What the command prints on a terminal, which is 80 columns wide, and in a pipe, which has no width."""

import fcntl
import os
import struct
import subprocess
import termios

import pytest

COLUMNS = 80


def on_terminal(steerguard, *arguments, columns=None, folder=None):
    """Standard output and standard error output of the command, both on a terminal."""
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
    assert process.wait(timeout=300) == 0, printed.decode()
    return printed.decode().replace("\r\n", "\n")


def read(terminal):
    try:
        return os.read(terminal, 65536)
    except OSError:
        return b""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("a_folder_whose_path_alone_is_nearly_as_long_as_a_line_of_a_terminal")


@pytest.mark.parametrize(
    "arguments",
    [
        ("verify", "{fixtures}/design.json"),
        ("package", "{fixtures}/design.json", "-o", "X.fmu"),
        ("check", "{fixtures}/SteeringFaultDetector.fmu"),
        ("campaign", "{fixtures}/design.json", "--drives", "4", "--duration", "5", "-o", "campaign"),
    ],
    ids=lambda arguments: arguments[0],
)
def test_no_line_is_longer_than_a_terminal(steerguard, fixtures, folder, arguments):
    text = on_terminal(steerguard, *(word.format(fixtures=fixtures) for word in arguments), folder=folder)
    words = [line for line in text.split("\n") if " " in line.strip()]
    assert words
    # A path is not broken, whatever its length.
    assert max(map(len, words)) <= COLUMNS or all("/" in line for line in words if len(line) > COLUMNS), text


def test_lines_in_a_pipe_stay_whole(steerguard, fixtures):
    environment = {**os.environ, "COLUMNS": "40"}
    command = [steerguard, "check", fixtures / "SteeringFaultDetector.fmu"]
    run = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    assert run.stdout == f"{fixtures / 'SteeringFaultDetector.fmu'}: no findings\n"


def test_columns_names_the_width(steerguard, fixtures):
    text = on_terminal(steerguard, "verify", fixtures / "design.json", columns=60)
    assert 40 < max(map(len, text.splitlines())) <= 60, text
