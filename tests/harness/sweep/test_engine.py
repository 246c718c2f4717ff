"""Jobs in processes that crash, hang and are killed: each costs its own job only."""

import os
import signal
import threading
import time
from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import psutil
import pytest

from analytic import Mechanism, Pose, condensed_frequencies
from analytic.model import Model
from harness.sweep.cluster import engine
from harness.sweep.engine import AHEAD, Engine, Patience, run
from harness.sweep.jobs import BATCH, Answer, Job, Sweep
from harness.workers import Children, Failure
from reference_models import Named

FINE, SLOW, CRASH, HANG, REFUSE, FLAKY, BUG, EXIT = range(1, 9)
Z = np.array([0.4, 0.5, 0.6])
GOOD = Pose(Z, 0.1, 0.1)
ONE_BAD = Pose(Z, 0.1, [0.1, -0.1, 0.1])


def jobs(model: Model, mechanism: Mechanism, poses: Pose, count: int) -> Iterator[Job]:
    return Sweep(mechanism, poses, [model], range(1, count + 1), None, None, None).jobs(model)


def trial(elements: int, poses: Pose = ONE_BAD) -> list[Job]:
    return list(jobs(Named("trial", elements), Mechanism.paper(), poses, 4))


@contextmanager
def local(cores: int = 2, patience: Patience = Patience(5.0, 2)) -> Iterator[Engine]:  # noqa: B008
    with engine(cores, None, patience) as chosen:
        yield chosen


@pytest.mark.slow
@pytest.mark.usefixtures("plugin")
def test_a_failing_job_costs_itself_only_and_says_why() -> None:
    expected = {
        CRASH: "its process was ended by SIGSEGV (2 of 2 tries)",
        HANG: "gave no answer within the time limit of 3 s (2 of 2 tries)",
        REFUSE: "trial: will not",
        BUG: "ZeroDivisionError: a bug",
        EXIT: "its process ended by itself with status 7 (2 of 2 tries)",
    }
    tasks = [job for elements in expected for job in trial(elements)]
    with local(patience=Patience(3.0, 2)) as chosen:
        results = {(job.model.elements, job.start): found for job, found in run(chosen, tasks)}
    assert len(results) == len(tasks)
    for (elements, start), found in results.items():
        if start == 1:
            assert isinstance(elements, int)
            assert found == Failure(expected[elements])
        else:
            assert isinstance(found, Answer)
            wanted = 1.0001 * condensed_frequencies(Mechanism.paper(), GOOD[start], count=4)
            np.testing.assert_allclose(found.frequencies[0], wanted, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.usefixtures("plugin")
def test_a_job_whose_process_died_is_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TRIAL_TRIED", str(tmp_path))
    with local(1) as chosen:
        found = [result for _, result in run(chosen, trial(FLAKY))]
    assert all(isinstance(result, Answer) for result in found)
    assert len(list(tmp_path.glob("0.*"))) == 1  # it did die once


@pytest.mark.slow
@pytest.mark.usefixtures("plugin")
def test_a_program_of_another_version_than_planned_is_not_believed() -> None:
    (job, *_) = trial(FINE)
    with local(1) as chosen:
        ((_, found),) = run(chosen, [replace(job, program="trial 2")])
    assert isinstance(found, Failure)
    assert found.reason.startswith("trial 1 (rps-bench ")
    assert found.reason.endswith(" runs here, not trial 2 as planned")


@pytest.mark.usefixtures("plugin")
def test_closing_ends_what_is_under_way_and_leaves_no_process() -> None:
    children = Children()
    (_, job, _) = trial(HANG)
    answers: list[object] = []
    others = set(psutil.Process().children())
    thread = threading.Thread(target=lambda: answers.append(children.attempt(job, 600.0, 3)))
    thread.start()
    deadline = time.monotonic() + 300
    while not (new := set(psutil.Process().children()) - others) and time.monotonic() < deadline:
        time.sleep(0.01)
    (process,) = new
    children.close()
    thread.join(20)
    assert answers == [Failure("interrupted")]
    assert not process.is_running()


def test_no_more_jobs_are_handed_out_than_are_needed() -> None:
    """A million poses are a generator, and stay one."""
    given: list[Future[str]] = []
    drawn = 0

    class Idle:
        cores = 2

        def submit(self, task: object) -> Future[str]:
            given.append(Future())
            return given[-1]

        def check(self) -> None:
            pass

    def many() -> Iterator[Job]:
        nonlocal drawn
        for job in jobs(
            Named("euler-bernoulli", None), Mechanism.paper(), Pose(np.full(10**5, 0.5)), 6
        ):
            drawn += 1
            yield job

    results = run(Idle(), many())

    def finish() -> None:
        while len(given) < AHEAD * Idle.cores:
            time.sleep(0.01)
        given[3].set_result("done")

    finisher = threading.Thread(target=finish)
    finisher.start()
    job, found = next(results)
    finisher.join()
    assert (job.start, found) == (3 * BATCH, "done")
    assert drawn == AHEAD * Idle.cores


@pytest.mark.slow
@pytest.mark.parametrize("elements", [None, 3])
def test_a_block_has_the_same_bits_whatever_was_solved_before(
    elements: int | None, robot: Mechanism
) -> None:
    """Blocks forwards, and backwards in another process; a pose in other company to 1e-11."""
    random = np.random.default_rng(5)
    tilt = np.where(np.arange(BATCH + 700) % 7, random.uniform(0, 0.3, BATCH + 700), 0.0)
    z, azimuth = random.uniform([[0.35], [-3]], [[0.7], [3]], (2, BATCH + 700))
    poses, model = Pose(z, azimuth, tilt), Named("timoshenko", elements)
    blocks = list(jobs(model, robot, poses, 6))
    assert [len(block.poses) for block in blocks] == [BATCH, 700]
    here = [block.solve().frequencies for block in blocks]
    children = Children()
    for block, first in reversed(list(zip(blocks, here, strict=True))):
        again = children.attempt(block, 60.0, 1)
        assert isinstance(again, Answer)
        assert again.frequencies.tobytes() == first.tobytes()
    children.close()
    some = random.permutation(BATCH + 700)[:300]
    alone = condensed_frequencies(robot, poses[some], elements, beam="timoshenko")
    np.testing.assert_allclose(np.concatenate(here)[some], alone, rtol=1e-11)


def test_keys_are_of_content(robot: Mechanism) -> None:
    """All that the answer depends on changes the key, and nothing else does."""
    (job,) = jobs(Named("timoshenko", 3), robot, GOOD, 6)
    same = replace(job, start=7, poses=Pose(Z.copy(), 0.1, 0.1))
    assert same.key == job.key
    others = [
        replace(job, model=Named("timoshenko", 3, (("shear", 0.9),))),
        replace(job, model=Named("timoshenko", None)),
        replace(job, program="rps-bench 0"),
        replace(job, mechanism=Mechanism.paper(inertia="printed")),
        replace(job, count=5),
        replace(job, poses=Pose(np.nextafter(Z, 1), 0.1, 0.1)),
        replace(job, poses=GOOD[:2]),
    ]
    assert len({job.key, *(other.key for other in others)}) == 8


@pytest.mark.slow
@pytest.mark.usefixtures("plugin")
def test_processes_killed_at_random_lose_no_job() -> None:
    """SIGKILL to any of the processes at any moment, idle ones too; every job is answered once."""
    tasks = trial(SLOW, Pose(np.linspace(0.4, 0.6, 120), 0.1, 0.1))
    random = np.random.default_rng(3)
    results = []
    others = set(psutil.Process().children())  # a browser of other tests, say
    with local(patience=Patience(20.0, 10)) as chosen:
        for result in run(chosen, tasks):
            results.append(result)
            if len(results) % 15 == 0:
                time.sleep(random.uniform(0, 0.05))
                alive = sorted(set(psutil.Process().children()) - others, key=lambda p: p.pid)
                os.kill(alive[random.integers(len(alive))].pid, signal.SIGKILL)
    assert sorted(job.start for job, _ in results) == list(range(120))
    assert all(isinstance(found, Answer) for _, found in results)
