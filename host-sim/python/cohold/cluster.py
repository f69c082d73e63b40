"""A sweep on the workers of a Dask cluster: a laptop's processes, machines by SSH, or a batch system's jobs (docs/guides/sweeps.md).

Workers keep nothing: each gets a few runs and sends their rows back, and this process alone writes them to the folder. So a worker may
die or come at any time, and the runs that a dead one had are done by others.
"""

import math
import os
import pickle
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from ._native import Sweep, keys

if TYPE_CHECKING:
    from distributed import Client

    Runs = list[tuple[int, list[int]]]

# Ticks of a task: some 0.5 s of work, so that a task is hundreds of times what Dask needs to hand it out.
_TICKS = 4_000_000


def run(
    client: "Client",
    sweep: Sweep,
    folder: str | os.PathLike[str],
    runs_per_task: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Any]:
    """Runs a sweep on the client's workers and gives its table: to the last bit that of `sweep.run(folder)`, but for `spectral_radius`,
    which depends on the processor (to 1e-9 the same).

    What is in the folder already is not run again; the folder is that of `cohold study sweep --out`. `progress` is told how many runs have
    come back, and of how many. A task that fails on every worker raises its error here after all others have been kept.
    """
    with sweep.open(folder) as journal:
        missing = journal.missing()
        total = sum(len(seeds) for _, seeds in missing)
        if total:
            _check_laws(client, sweep)
            workers = max(1, sum(client.nthreads().values()))
            size = runs_per_task or _size(sweep, total, workers)
            _keep(client, sweep, list(_tasks(missing, size)), journal.append, progress, total)
        return journal.finish()


def _check_laws(client: "Client", sweep: Sweep) -> None:
    """Each process knows the laws that were written in it: a worker that lacks one is named before anything is run."""
    points = range(sweep.points) if "coordination.comm" in sweep.keys else range(1)
    laws = sorted({str(sweep.scene_at(point)["coordination.comm"]) for point in points})
    for worker, unknown in client.run(_unknown, laws).items():
        if unknown:
            raise ValueError(
                f"worker {worker} does not know the law {unknown[0]}: add it there as well, with client.run for workers that are "
                "there, with a preload (`dask worker --preload`) for those that come"
            )


def _unknown(laws: list[str]) -> list[str]:
    """On a worker: which of these laws nobody has told it."""
    known = keys()["coordination.comm"]["allowed"]
    return [law for law in laws if law not in known]


def _size(sweep: Sweep, runs: int, workers: int) -> int:
    """Runs of a task: so that it takes about half a second, and there are ten for each worker."""
    ticks = sweep.seconds / float(sweep.scene_at(0)["timing.control_period_s"])
    return max(1, min(math.ceil(runs / (10 * workers)), round(_TICKS / ticks)))


def _tasks(runs: "Runs", size: int) -> "Iterator[Runs]":
    """The runs in their order, so many at a time; a point with many seeds is divided."""
    task: Runs = []
    room = size
    for point, seeds in runs:
        while seeds:
            task.append((point, seeds[:room]))
            seeds, room = seeds[room:], room - len(task[-1][1])
            if room == 0:
                yield task
                task, room = [], size
    if task:
        yield task


def _keep(
    client: "Client",
    sweep: Sweep,
    tasks: "list[Runs]",
    append: Callable[[bytes], None],
    progress: Callable[[int, int], None] | None,
    total: int,
) -> None:
    from distributed import as_completed

    # As bytes, which the task itself reads: what a worker cannot read is then an error of the task.
    futures = client.map(_rows, tasks, asked=pickle.dumps(sweep), made=sweep.made, pure=False)
    sizes = {future.key: sum(len(seeds) for _, seeds in task) for future, task in zip(futures, tasks)}
    done, error = 0, None
    try:
        for future in as_completed(futures):
            try:
                # Not by its status: where a worker died with what it had done, this waits until another has done it again.
                rows = future.result()
            except Exception as cause:
                error = error or cause
            else:
                append(rows)
                done += sizes[future.key]
                if progress:
                    progress(done, total)
            future.release()
    except BaseException:
        client.cancel(futures)
        raise
    if error:
        raise error


def _rows(runs: "Runs", asked: bytes, made: list[str]) -> bytes:
    """On a worker: the rows of these runs of a pickled sweep, if it is the same program with the same traces that was asked."""
    sweep: Sweep = pickle.loads(asked)
    if sweep.made != made:
        raise RuntimeError(f"this worker would give other rows: it has {sweep.made}, the sweep was asked by {made}")
    return sweep.rows(runs)
