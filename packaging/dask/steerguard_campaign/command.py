"""The `steerguard` command on this machine, and the folder of the campaign."""

import hashlib
import json
import os
import re
import shutil
import subprocess
import tempfile
from contextlib import suppress
from pathlib import Path

try:
    import fcntl
except ImportError:  # no POSIX: nothing is locked, and nothing swept
    fcntl = None

from .failure import Failure, Refusal

TEMPORARY = ".steerguard-"  # what names of temporary files begin with, here as of the command
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
        sweep(self.output / "blocks")
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
                with tempfile.NamedTemporaryFile(prefix=TEMPORARY, dir=folder, delete=False) as file:
                    try:
                        lock(file, wait=True)
                        file.write(data)
                        file.flush()
                        os.fsync(file.fileno())
                        os.chmod(file.name, 0o666 & ~umask())
                        os.replace(file.name, folder / name)
                    except BaseException:
                        Path(file.name).unlink(missing_ok=True)
                        raise
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


def lock(file, wait):
    """Whether this process now holds the lock of an open file; as the command does for what is temporary."""
    if fcntl is None:
        return wait
    try:
        fcntl.flock(file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except OSError:
        return wait  # a file system without locks
    return True


def umask():
    """The permissions that new files do not get."""
    mask = os.umask(0)
    os.umask(mask)
    return mask


def sweep(folder):
    """Removes temporary files in `folder` that nobody holds: a process that was killed left them."""
    for path in folder.glob(f"{TEMPORARY}*"):
        with suppress(OSError), open(path, "rb") as file:
            if lock(file, wait=False):
                path.unlink()


def is_whole(block):
    """Whether the bytes of a block, as the command writes it, end with their own digest."""
    rows, mark, end = block.rstrip().rpartition(b',"sha256":"')
    return bool(mark) and end == hashlib.sha256(rows).hexdigest().encode() + b'"}'
