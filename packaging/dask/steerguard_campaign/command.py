"""The `steerguard` command on this machine, and the folder of the campaign."""

import hashlib
import json
import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from .failure import Failure, Refusal

OF_WORKERS = "workers need the `steerguard` command of this build, and memory and disks that are sound"


class Campaign:
    """A campaign and its folder, as the `steerguard` command sees them."""

    def __init__(self, command, design, arguments, output):
        """`arguments` are those of `steerguard campaign` beside the design and the folder."""
        self.command = command
        self.arguments = arguments
        self.output = Path(output)
        self._scratch = tempfile.TemporaryDirectory(prefix="steerguard-campaign-")
        self.design = self._design_file(Path(design))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._scratch.cleanup()

    def _design_file(self, path):
        """`path`, or the design made of the specification there."""
        try:
            is_design = path.read_bytes().lstrip().startswith(b"{")
        except OSError as error:
            raise Failure(f"cannot read `{path}`: {error.strerror}", "check the path") from error
        if is_design:
            return path
        made = Path(self._scratch.name, "design.json")
        self._call("design", path, "-o", made, stdout=subprocess.DEVNULL)
        return made

    def prepare(self):
        """Makes the folder, or finds that it is this campaign's.

        Returns the number of blocks and the set of those missing.
        """
        try:
            text = self._campaign("--prepare", "--json", stdout=subprocess.PIPE)
        except Refusal as refusal:
            raise Refusal(drawn(str(refusal)), refusal.exit_code) from refusal
        prepared = json.loads(text)
        return prepared["blocks"], set(prepared["missing_blocks"])

    def manifest(self):
        """Bytes of `campaign.json`, which say everything that the results depend on."""
        return (self.output / "campaign.json").read_bytes()

    def store(self, blocks):
        """Writes blocks, bytes by file name: each is there whole or not at all.

        They come from other machines, so names and digests are looked at first.
        """
        folder = self.output / "blocks"
        for name, data in blocks.items():
            if not re.fullmatch(r"\d{6,}\.json", name) or not is_whole(data):
                raise Failure(f"a worker sent {name!r}, which is no block", OF_WORKERS)
        try:
            for name, data in blocks.items():
                temporary = folder / f".steerguard.{os.getpid()}-{name}"
                with open(temporary, "wb") as file:
                    file.write(data)
                    file.flush()
                    os.fsync(file.fileno())
                os.replace(temporary, folder / name)
        except OSError as error:
            raise Failure(f"cannot write to `{folder}`: {error.strerror}") from error

    def merge(self, *further):
        """Drives what is missing, here, and writes and prints the results."""
        self._campaign(*further)

    def _campaign(self, *further, **streams):
        return self._call(
            "campaign", self.design, *self.arguments, "-o", self.output, *further, **streams
        )

    def _call(self, *arguments, **streams):
        """Output of the command; its refusal if it refuses."""
        found = shutil.which(self.command)
        if found is None:
            raise Failure(
                f"there is no `{self.command}` command",
                "install it (cargo install --path packaging), or name it: --command PATH",
            )
        done = subprocess.run([found, *arguments], stderr=subprocess.PIPE, text=True, **streams)
        if done.returncode != 0:
            raise Refusal(done.stderr.strip(), exit_code=max(1, done.returncode))
        return done.stdout


def drawn(refusal):
    """What the command says with `--json`, as lines for people; any other text as it is."""
    try:
        diagnostics = json.loads(refusal)["diagnostics"]
    except (ValueError, KeyError, TypeError):
        return refusal
    lines = []
    for diagnostic in diagnostics:
        place = f"{diagnostic['place']}: " if diagnostic.get("place") else ""
        lines.append(f"{diagnostic['level']}: {place}{diagnostic['message']}")
        for kind in ("notes", "help"):
            lines += [f"{kind.rstrip('s')}: {text}" for text in diagnostic.get(kind) or []]
    return "\n".join(lines)


def is_whole(block):
    """Whether the bytes of a block, as the command writes it, end with their own digest."""
    rows, mark, end = block.rstrip().rpartition(b',"sha256":"')
    return bool(mark) and end == hashlib.sha256(rows).hexdigest().encode() + b'"}'
