"""Command line of `steerguard-campaign`."""

import argparse
import logging
import os
import sys

from .cluster import connection, drive
from .command import Campaign
from .failure import Failure

EXAMPLES = """\
Examples:
  steerguard-campaign design.json --drives 100000 -o campaign
  steerguard-campaign design.json --drives 1000000 --scheduler tcp://10.0.0.1:8786 -o campaign

All other arguments are those of `steerguard campaign`, whose results these are, byte for byte. A
campaign that was cut short goes on when the command is given again, here or there.
"""

# Of `steerguard campaign`: what this command decides.
TAKEN = ("--shard", "--drive", "--prepare", "--signals")


def parser():
    parser = argparse.ArgumentParser(
        prog="steerguard-campaign",
        usage="%(prog)s DESIGN [OPTIONS]",
        description="Drives a campaign of steerguard on a Dask cluster.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument(
        "design", metavar="DESIGN", help="design file, or a specification to be designed first"
    )
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="scheduler of a cluster, such as tcp://10.0.0.1:8786",
    )
    parser.add_argument(
        "--jobs", metavar="J", type=count, help="number of local workers; default: one a processor"
    )
    parser.add_argument(
        "--shards", metavar="N", type=count, help="number of parts; default: eight a worker"
    )
    parser.add_argument(
        "--command",
        metavar="PATH",
        default="steerguard",
        help="the steerguard command, here and on the workers; default: the one on PATH",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="DIR",
        default="steerguard-campaign",
        help="folder of the campaign; default: %(default)s",
    )
    parser.add_argument("--json", action="store_true", help="print the result as JSON")
    return parser


def count(text):
    number = int(text)
    if number < 1:
        raise ValueError
    return number


def arguments(argv):
    """Arguments of this command, and those of `steerguard campaign`."""
    own = parser()
    if argv and argv[0].startswith("-") and not {"-h", "--help"} & set(argv):
        own.error("DESIGN comes first")
    here, further = own.parse_known_args(argv)
    for argument in further:
        if argument.split("=")[0] in TAKEN:
            own.error(f"{argument} is for `steerguard campaign`: this command makes the parts")
    if here.scheduler and here.jobs:
        own.error("--jobs is the number of local workers: a scheduler has its own")
    return here, further


def show(done, to_do):
    if sys.stderr.isatty():
        end = "\n" if done == to_do else ""
        print(f"\r{done} of {to_do} shards", end=end, file=sys.stderr, flush=True)


def main(argv=None):
    """Runs the command and ends the process with its exit code."""
    here, further = arguments(sys.argv[1:] if argv is None else argv)
    logging.disable()  # what goes wrong is told below
    try:
        with Campaign(here.command, here.design, further, here.output) as campaign:
            blocks, missing = campaign.prepare()
            if missing:
                jobs = here.jobs or os.cpu_count()
                with connection(here.scheduler, jobs) as client:
                    drive(client, campaign, blocks, missing, here.shards, show)
            campaign.merge(*["--json"] * here.json)
    except Failure as failure:
        print(failure.text(), file=sys.stderr)
        sys.exit(failure.exit_code)
    except KeyboardInterrupt:
        print("stopped: give the same command again and it goes on", file=sys.stderr)
        sys.exit(130)


if __name__ == "__main__":
    main()
