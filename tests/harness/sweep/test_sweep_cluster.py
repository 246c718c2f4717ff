"""`rps-bench sweep` on a Dask cluster: what is lost with it; results do not depend on it."""

import json
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Thread
from typing import Any

import psutil
import pytest


@contextmanager
def cluster(workers: int = 2) -> Iterator[tuple[str, psutil.Popen]]:
    """A Dask cluster of worker processes, as people run it; its address and process.

    The process ends all workers at a first line of input, and itself where the input ends.
    """
    script = (
        "import sys, json\n"
        "from distributed import LocalCluster\n"
        "if __name__ == '__main__':\n"
        f"    with LocalCluster(n_workers={workers}, threads_per_worker=1,\n"
        "                      dashboard_address=None) as c:\n"
        "        print(json.dumps(c.scheduler_address), flush=True)\n"
        "        sys.stdin.readline()\n"
        "        c.scale(0)\n"
        "        sys.stdin.read()\n"
    )
    pipe = subprocess.PIPE
    process = psutil.Popen(
        [sys.executable, "-c", script],
        stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, text=True,
    )  # fmt: skip
    try:
        yield json.loads(process.stdout.readline()), process
    finally:
        process.communicate(timeout=60)


@pytest.mark.parametrize(
    ("address", "why"),
    [
        ("tcp://127.0.0.1:1", "Timed out"),
        ("nonsense", "missing port"),
        ("ftp://127.0.0.1:1", "unknown address scheme"),
        ("", "missing port"),
    ],
)
def test_an_address_without_a_scheduler_is_one_sentence(
    rps_bench: Callable[..., Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    address: str,
    why: str,
) -> None:
    monkeypatch.setattr("harness.sweep.cluster.REACH", 0.3)
    given = ("--poses", "pose:490,0,0", "--models", "rayleigh@1", "--scheduler", address)
    answer = rps_bench("sweep", *given, "--output", str(tmp_path / "out"))
    assert answer.status == 2
    expected = "the address of a running Dask scheduler, tcp://HOST:PORT"
    assert answer.err.startswith(f"rps-bench: --scheduler = {address!r}: expected {expected} (")
    assert why in answer.err
    assert len(answer.err.splitlines()) == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_a_cluster_without_workers_is_one_sentence(
    started: Callable[..., subprocess.Popen[str]],
    ended: Callable[..., tuple[int, str, str]],
    tmp_path: Path,
) -> None:
    with cluster(workers=0) as (address, _):
        given = ("--poses", "pose:490,0,0", "--models", "rayleigh@1", "--scheduler", address)
        status, _, err = ended(started(*given, "--output", str(tmp_path / "out")))
    assert status == 2
    expected = "a Dask cluster with at least one worker"
    assert err == f"rps-bench: --scheduler = {address!r}: expected {expected}\n"
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("lost", ["its scheduler", "every worker"])
def test_a_cluster_that_ends_loses_no_finished_job(slow_sweep: Any, lost: str) -> None:
    with cluster() as (address, dask):
        short = "import harness.sweep.cluster; harness.sweep.cluster.REACH = 3.0"
        process = slow_sweep.started("--scheduler", address, before=short)
        slow_sweep.wait_for(40)
        if lost == "its scheduler":
            dask.kill()
        else:
            dask.stdin.write("\n")
            dask.stdin.flush()
        status, _, err = slow_sweep.ended(process)
    assert status == 2
    assert err.startswith(f"rps-bench: --scheduler = {address!r}: expected a Dask cluster that ")
    assert f"({lost} has gone; finished jobs are kept" in err
    assert len(err.splitlines()) == 1, err
    kept = slow_sweep.kept()
    assert 30 <= kept < 150
    slow_sweep.goes_on(kept)


@pytest.mark.slow
def test_a_cluster_whose_workers_are_killed_leaves_every_row_once(slow_sweep: Any) -> None:
    """Kills a process that holds a job, then a Dask worker; both come back."""
    with cluster() as (address, dask):
        process = slow_sweep.started("--scheduler", address, "--tries", "10")
        for lines, of_harness in ((20, True), (60, False), (100, True)):
            slow_sweep.wait_for(lines)
            workers = [
                other
                for other in dask.children(recursive=True)
                if ("harness.child" in other.cmdline()) == of_harness
                and (of_harness or any("spawn_main" in word for word in other.cmdline()))
            ]
            workers[0].kill()
        status, _, err = slow_sweep.ended(process)
    assert status == 0, err
    slow_sweep.complete()


@pytest.mark.slow
def test_the_same_bytes_on_one_core_on_two_and_on_a_cluster(
    started: Callable[..., subprocess.Popen[str]],
    ended: Callable[..., tuple[int, str, str]],
    tmp_path: Path,
) -> None:
    """Analytic models and simulators; the order in which jobs finish does not matter."""
    models = "timoshenko@exact,euler-bernoulli@3,exudyn-cable@4,exudyn-beam@6,mujoco-cable@4+8"
    given = ("--models", models, "--poses", "random:12:5", "--against", "timoshenko@exact")
    files = ("frequencies.parquet", "error-map.parquet", "errors.csv", "worst.csv")
    found: dict[str, list[bytes]] = {}

    def sweep(name: str, *options: str) -> None:
        output = tmp_path / name
        status, _, err = ended(started(*given, "--output", str(output), *options))
        assert status == 0, err
        found[name] = [(output / file).read_bytes() for file in files]

    sweep("one", "--cores", "1")
    sweep("two", "--cores", "2")
    with cluster() as (address, _):
        sweep("dask", "--scheduler", address)
    assert found["one"] == found["two"]
    assert found["one"] == found["dask"]


@contextmanager
def port(answer: bytes) -> Iterator[str]:
    """A port of something else: it takes connections, and says `answer` or nothing for ever."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        held: list[socket.socket] = []

        def serve() -> None:
            with suppress(OSError):
                while True:
                    held.append(server.accept()[0])
                    if answer:
                        held[-1].sendall(answer)

        Thread(target=serve, daemon=True).start()
        yield f"tcp://127.0.0.1:{server.getsockname()[1]}"
        for one in held:
            one.close()


HTTP = b"HTTP/1.1 400 Bad Request\r\nContent-Type: text/html\r\nContent-Length: 0\r\n\r\n"


@pytest.mark.slow
@pytest.mark.parametrize("answer", [b"", HTTP], ids=["silent", "http"])
def test_a_port_that_is_no_scheduler_is_one_sentence(
    started: Callable[..., subprocess.Popen[str]],
    ended: Callable[..., tuple[int, str, str]],
    tmp_path: Path,
    answer: bytes,
) -> None:
    """Within the stated time: a process that still waits is ended by the test."""
    short = "import harness.sweep.cluster; harness.sweep.cluster.REACH = 1.0"
    with port(answer) as address:
        given = ("--poses", "pose:490,0,0", "--models", "rayleigh@1", "--scheduler", address)
        process = started(*given, "--output", str(tmp_path / "out"), before=short)
        status, _, err = ended(process)
    assert status == 2, err
    assert err.startswith(f"rps-bench: --scheduler = {address!r}: expected the address of a")
    assert len(err.splitlines()) == 1, err


@pytest.mark.slow
@pytest.mark.parametrize("stopped", ["its scheduler", "every worker"])
def test_a_cluster_that_is_stopped_loses_no_finished_job(slow_sweep: Any, stopped: str) -> None:
    """SIGSTOP: the connection stays, and nothing answers."""
    with cluster(workers=1) as (address, dask):
        short = "import harness.sweep.cluster; harness.sweep.cluster.REACH = 3.0"
        process = slow_sweep.started("--scheduler", address, before=short)
        slow_sweep.wait_for(20)
        workers = [one for one in dask.children() if "spawn_main" in " ".join(one.cmdline())]
        held = [dask] if stopped == "its scheduler" else workers
        assert held
        for one in held:
            one.suspend()
        try:
            status, _, err = slow_sweep.ended(process)
        finally:
            for one in held:
                one.resume()
    assert status == 2, err
    assert err.startswith(f"rps-bench: --scheduler = {address!r}: expected a Dask cluster that ")
    assert f"({stopped} has gone; finished jobs are kept" in err
    assert len(err.splitlines()) == 1, err
    assert 10 <= slow_sweep.kept() < 150
