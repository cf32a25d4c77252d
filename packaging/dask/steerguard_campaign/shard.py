"""What a worker does: `steerguard campaign` on a shard, in a folder that is gone afterwards.

Conventions
- This module travels to the workers by value: they need not have this package. It takes and
  returns built-in types only.
- A refusal is a text: the same command refuses again wherever it runs. An exception is bad luck, such
  as a command that was killed, and worth another try.
"""

import shutil
import subprocess
import tempfile
from pathlib import Path

from distributed import get_worker

REFUSED = (1, 2)  # exit codes of the command: the answer is no, bad usage or input


def drive(command, arguments, design, campaign):
    """Gives `arguments` to `steerguard campaign`.

    `design` and `campaign` are the bytes of design.json and campaign.json. Returns the blocks in
    the folder afterwards, bytes by file name, or the text of a refusal.
    """
    found = shutil.which(command)
    if found is None:
        return f"there is no `{command}` command"
    # Dask removes what a killed worker leaves in this folder.
    with tempfile.TemporaryDirectory(dir=get_worker().local_directory) as path:
        design_file, folder = Path(path, "design.json"), Path(path, "campaign")
        design_file.write_bytes(design)
        folder.mkdir()
        # The command refuses to work in the folder of another campaign, or of another build.
        (folder / "campaign.json").write_bytes(campaign)
        line = [found, "campaign", design_file, *arguments, "-o", folder]
        done = subprocess.run(
            [*tether(), *line], stdin=subprocess.DEVNULL, capture_output=True, text=True
        )
        if done.returncode in REFUSED:
            return done.stderr.strip()
        if done.returncode != 0:
            raise RuntimeError(f"`{command}` ended with {done.returncode}: {done.stderr.strip()}")
        return {block.name: block.read_bytes() for block in (folder / "blocks").glob("*.json")}


def tether():
    """What makes the command die with its worker, where the system (util-linux) can."""
    return ["setpriv", "--pdeathsig", "KILL"] if shutil.which("setpriv") else []
