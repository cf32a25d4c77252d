"""The shards of a campaign on a Dask cluster."""

import pickle
import sys
from contextlib import contextmanager, suppress

import cloudpickle
from distributed import Client, LocalCluster, as_completed, wait
from distributed.client import FutureCancelledError
from distributed.scheduler import KilledWorker

from . import shard
from .failure import Failure

CONNECT_S = 5
WORKERS_S = 60
SHARDS_PER_THREAD = 8  # of the workers: keeps them busy to the end, and a killed one loses little
RETRIES = 3  # of a shard whose command did not end by itself

SAME_BUILD = (
    "workers need the same build of `steerguard` as the main process, on their PATH or at "
    "--command PATH"
)
KEPT = "what is done is kept: give the same command again and it goes on"

cloudpickle.register_pickle_by_value(shard)


@contextmanager
def connection(scheduler, jobs):
    """A client of the cluster at the address `scheduler`; without one, of `jobs` local workers."""
    if scheduler is None:
        with (
            LocalCluster(
                n_workers=jobs, threads_per_worker=1, memory_limit=0, dashboard_address=None
            ) as cluster,
            Client(cluster) as client,
        ):
            yield client
        return
    try:
        client = Client(scheduler, timeout=CONNECT_S)
    except (OSError, ValueError) as error:
        raise Failure(
            f"no scheduler answers at `{scheduler}`: {error}",
            "start one with `dask scheduler` and name the address that it prints",
        ) from error
    with client:
        yield client


def shards(blocks, number):
    """The blocks of shards 1 to `number`, as `steerguard campaign --shard K/N` divides them."""
    return {
        k: range(blocks * (k - 1) // number, blocks * k // number) for k in range(1, number + 1)
    }


def drive(client, campaign, blocks, missing, number, progress):
    """Drives the blocks `missing`, of `blocks` in all, and stores them in the folder of `campaign`.

    `number` is that of the shards, None for a choice by the number of workers. `progress` is told
    the numbers of shards done and to do.
    """
    wait_for_workers(client)
    check(client, campaign)
    if number is None:
        number = SHARDS_PER_THREAD * sum(client.nthreads().values())
    number = min(number, blocks)
    to_do = [k for k, part in shards(blocks, number).items() if not missing.isdisjoint(part)]
    futures = {}
    for k in to_do:
        arguments = ["--jobs", "1", "--shard", f"{k}/{number}"]
        futures[submit(client, campaign, arguments, retries=RETRIES)] = k
    for done, future in enumerate(as_completed(list(futures)), start=1):
        campaign.store(result(future, f"{futures.pop(future)}/{number}"))
        progress(done, len(to_do))


class Call:
    """A call that takes place where it is unpickled."""

    def __init__(self, function, *arguments):
        self.parts = function, arguments

    def __reduce__(self):
        return self.parts


def submit(client, campaign, arguments, **options):
    """The future of `shard.drive` with further `arguments`.

    Scheduler and workers see bytes and a function of the standard library only, so that they need
    nothing of this package.
    """
    call = Call(
        shard.drive,
        campaign.command,
        [*campaign.arguments, *arguments],
        campaign.design.read_bytes(),
        campaign.manifest(),
    )
    return client.submit(pickle.loads, cloudpickle.dumps(call), pure=False, **options)


def wait_for_workers(client):
    """Until there are workers; they must speak the main process's Python."""
    try:
        client.wait_for_workers(1, timeout=WORKERS_S)
    except TimeoutError as error:
        raise Failure(
            f"no worker has joined within {WORKERS_S} s",
            "start some with `dask worker ADDRESS`, where the `steerguard` command is",
        ) from error
    here = list(sys.version_info[:2])
    for worker, versions in client.get_versions()["workers"].items():
        there = [int(part) for part in versions["host"]["python"].split(".")[:2]]
        if there != here:
            raise Failure(
                f"worker {worker} runs Python {there[0]}.{there[1]}, not {here[0]}.{here[1]}",
                "Dask needs the same Python version everywhere",
            )


def check(client, campaign):
    """Whether every worker has the command, of the same build."""
    answers = {w: submit(client, campaign, ["--prepare"], workers=[w]) for w in client.nthreads()}
    with suppress(TimeoutError):
        wait(list(answers.values()), timeout=WORKERS_S)
    refusals = []
    for worker in client.nthreads():  # those that have gone since are nobody's concern
        answer = answers.get(worker)
        if answer is None or answer.status == "finished" and answer.result() == {}:
            continue
        known = {"finished": answer.result, "error": answer.exception}
        why = known[answer.status]() if answer.status in known else "no answer"
        refusals.append(f"worker {worker}: {why}")
    if refusals:
        raise Failure("\n".join(refusals), SAME_BUILD)


def result(future, name):
    """Blocks of the shard called `name`."""
    try:
        blocks = future.result()
    except KilledWorker as error:
        last = error.last_worker.address
        raise Failure(
            f"shard {name}: workers died of it again and again, last {last}", KEPT
        ) from error
    except RuntimeError as error:
        raise Failure(f"shard {name}: {error}", KEPT) from error
    except FutureCancelledError as error:
        raise Failure("the scheduler has gone", KEPT) from error
    if isinstance(blocks, str):  # of a worker that joined later
        raise Failure(f"shard {name}: {blocks}", SAME_BUILD)
    return blocks
