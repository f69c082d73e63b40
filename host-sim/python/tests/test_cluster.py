"""A sweep on Dask: worker processes on loopback, one of them killed in the middle; nothing is missing, and every bit is one process's."""

import os
import pickle
import signal

import distributed
import cohold
import cohold.cluster
import numpy as np
import pytest

SWEEP = cohold.Sweep(
    "paper-5.2-passive-wave-16ms",
    {"coordination.stiffness_n_per_m": "50..12000:50:log", "network.loss": [0, 0.05, 0.2]},
    seeds=2,
    seconds=5.0,
)


@pytest.fixture(scope="module")
def client():
    options = {"n_workers": 2, "threads_per_worker": 1, "host": "127.0.0.1", "dashboard_address": None}
    with distributed.LocalCluster(processes=True, **options) as cluster, distributed.Client(cluster) as client:
        yield client


def equal(one, other):
    assert list(one) == list(other)
    for name, column in one.items():
        if name == "spectral_radius":
            # Its last bits depend on the processor.
            assert np.allclose(column, other[name], rtol=0, atol=1e-9)
        else:
            assert np.array_equal(column, other[name], equal_nan=column.dtype == float), name


def test_a_killed_worker_costs_nothing(client, tmp_path):
    before = set(client.run(os.getpid).values())
    killed = []

    def progress(done, total):
        assert total == SWEEP.runs
        if done >= 60 and not killed:
            killed.append(before.pop())
            os.kill(killed[0], signal.SIGKILL)

    table = cohold.cluster.run(client, SWEEP, tmp_path / "far", runs_per_task=5, progress=progress)
    assert killed and killed[0] not in client.run(os.getpid).values()
    equal(table, SWEEP.run(tmp_path / "near"))
    lines = (tmp_path / "far" / "rows-1-of-1.csv").read_text().splitlines()
    assert len(lines) == 1 + SWEEP.runs == len(set(lines))
    assert (tmp_path / "far" / "sweep.csv").read_bytes() == (tmp_path / "near" / "sweep.csv").read_bytes()


def test_what_is_there_is_not_run_again(client, tmp_path):
    with SWEEP.open(tmp_path) as journal:
        journal.append(SWEEP.rows(journal.missing()[:140]))
    told = []
    table = cohold.cluster.run(client, SWEEP, tmp_path, progress=lambda done, total: told.append((done, total)))
    assert told[-1] == (20, 20)
    cohold.cluster.run(client, SWEEP, tmp_path, progress=lambda *_: pytest.fail("nothing was missing"))
    equal(table, SWEEP.run())


def test_tasks_are_all_the_runs_in_their_order():
    missing = [(0, [1, 2, 3]), (1, [2]), (4, list(range(10)))]
    flat = [(point, seed) for point, seeds in missing for seed in seeds]
    for size in (1, 2, 3, 5, 100):
        tasks = list(cohold.cluster._tasks(missing, size))
        assert [(point, seed) for task in tasks for point, seeds in task for seed in seeds] == flat
        sizes = [sum(len(seeds) for _, seeds in task) for task in tasks]
        assert set(sizes[:-1]) <= {size} and 0 < sizes[-1] <= size
    assert cohold.cluster._size(SWEEP, SWEEP.runs, 2) == 15
    assert cohold.cluster._size(SWEEP, 10_000_000, 2) == 800


def test_a_worker_with_another_program_is_refused():
    with pytest.raises(RuntimeError, match="this worker would give other rows"):
        cohold.cluster._rows([(0, [1])], pickle.dumps(SWEEP), ['version = "0.0.0"'])


def test_a_task_that_fails_raises_after_the_others(client, tmp_path, monkeypatch):
    # A seed that is not the sweep's is none of its rows: the task of a point that there is not.
    tasks = cohold.cluster._tasks
    monkeypatch.setattr(cohold.cluster, "_tasks", lambda runs, size: [*tasks(runs, size), [(10_000, [1])]])
    with pytest.raises(ValueError, match="point = 10000 is not allowed"):
        cohold.cluster.run(client, SWEEP, tmp_path)
    with SWEEP.open(tmp_path) as journal:
        assert journal.missing() == []


def test_a_batch_systems_job_is_made_as_the_page_says(tmp_path):
    from dask_jobqueue.slurm import SLURMJob

    job = SLURMJob(
        scheduler="tcp://127.0.0.1:1", name="w", cores=1, processes=1, memory="1GB", walltime="01:00:00",
        job_extra_directives=["--requeue"], worker_extra_args=["--no-dashboard"],
    )
    script = job.job_script()
    assert "#SBATCH --requeue" in script and "dask" in script and "--no-dashboard" in script


def test_a_result_that_died_with_its_worker_is_waited_for(monkeypatch, tmp_path):
    class Lost:
        """As a future is whose worker died after it had told that it was done."""

        status = "pending"

        def __init__(self, key, task):
            self.key, self.task = key, task

        def result(self):
            return SWEEP.rows(self.task)

        def exception(self):
            return None

        def release(self):
            pass

    class Workers:
        def nthreads(self):
            return {"one": 1}

        def run(self, asked, laws):
            return {"one": asked(laws)}

        def map(self, _, tasks, **__):
            return [Lost(key, task) for key, task in enumerate(tasks)]

    monkeypatch.setattr(distributed, "as_completed", iter)
    equal(cohold.cluster.run(Workers(), SWEEP, tmp_path), SWEEP.run())
