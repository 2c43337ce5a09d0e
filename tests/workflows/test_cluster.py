"""`compute-lut` on a real Dask scheduler with workers in other processes."""

import logging
import socket
import subprocess
import sys

import pytest
from dask_cluster import Cluster
from patience import PATIENCE
from table_runs import StoppedError, compiled, stop_after

from trackctl.errors import MissingLibraryError, UsageError, WorkerError
from trackctl.workflows import cluster as module
from trackctl.workflows.cluster import cluster

OTHER_BUILD = "import trackctl.lut.crew\ntrackctl.lut.crew.build = lambda: 'trackctl 0.0.1'\n"


@pytest.fixture(scope="module")
def machines(tmp_path_factory):
    with Cluster(tmp_path_factory.mktemp("cluster")) as started:
        yield started


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    output = tmp_path_factory.mktemp("whole") / "lut.h5"
    compiled(output)
    return output.read_bytes()


def await_workers(crew, count):
    crew.executor._client.wait_for_workers(count, timeout=PATIENCE)


def refusal(address):
    with pytest.raises(UsageError) as refused, cluster(address, pytest.fail):
        pass
    return str(refused.value)


@pytest.fixture
def unused_address():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        yield f"127.0.0.1:{free.getsockname()[1]}"


def test_a_worker_dies_half_way_and_the_bytes_are_those_of_threads(tmp_path, machines, whole):
    def kill_one(done, total):
        if done == 3:
            machines.staff("two")

    machines.staff("one", "two")
    with cluster(machines.address, pytest.fail) as crew:
        await_workers(crew, 2)
        compiled(tmp_path / "lut.h5", crew=crew, progress=kill_one)
    assert (tmp_path / "lut.h5").read_bytes() == whole


def test_what_a_cluster_began_threads_finish(tmp_path, machines, whole):
    output = tmp_path / "lut.h5"
    machines.staff("two")
    with cluster(machines.address, print) as crew, pytest.raises(StoppedError):
        compiled(output, crew=crew, progress=stop_after(3))
    compiled(output, resume=True)
    assert output.read_bytes() == whole


def test_workers_may_all_go_and_come_back(tmp_path, machines, whole):
    told = []

    def come_back(text):
        told.append(text)
        machines.staff("again")

    def kill_all(done, total):
        if done == 2:
            machines.staff()

    machines.staff("two")
    with cluster(machines.address, come_back) as crew:
        await_workers(crew, 1)
        compiled(tmp_path / "lut.h5", crew=crew, progress=kill_all)
    assert told == [f"no worker at {machines.address}; waiting up to 300 s for one"]
    assert (tmp_path / "lut.h5").read_bytes() == whole


def test_a_worker_of_another_version_is_refused(tmp_path, machines):
    preload = tmp_path / "older.py"
    preload.write_text(OTHER_BUILD)
    machines.staff()
    machines.start_worker("older", "--preload", preload)
    problem = r"runs trackctl 0\.0\.1, this is trackctl .* on all machines; .*--resume continues"
    with cluster(machines.address, print) as crew, pytest.raises(WorkerError, match=problem):
        compiled(tmp_path / "lut.h5", crew=crew)


def test_a_worker_is_no_scheduler(machines):
    machines.staff("two")
    with cluster(machines.address, print) as crew:
        await_workers(crew, 1)
        worker = next(iter(crew.executor._client.nthreads()))
    assert "running Dask scheduler, [tcp://]HOST:PORT, no Worker" in refusal(worker)


def test_without_workers_it_gives_up_after_a_while_and_without_its_scheduler_at_once(tmp_path, monkeypatch):
    told = []
    monkeypatch.setattr(module, "WORKERLESS_TIMEOUT", 2.0)
    with Cluster(tmp_path) as machines, cluster(machines.address, told.append) as crew:
        with pytest.raises(WorkerError, match=r"no worker at tcp://.* for 2 s; start one: dask worker; .*--resume"):
            compiled(tmp_path / "lut.h5", crew=crew)
        assert told == [f"no worker at {machines.address}; waiting up to 2 s for one"]
        machines.kill("scheduler")
        with pytest.raises(WorkerError):
            compiled(tmp_path / "lut.h5", crew=crew, resume=True)


TROUBLE = """
import asyncio, sys
from trackctl.workflows.cluster import cluster

def trouble():
    raise RuntimeError("words of a library")

async def tried():
    asyncio.get_running_loop().call_exception_handler({"message": "more words"})
    await asyncio.sleep(0.0)

with cluster(sys.argv[1], print) as crew:
    client = crew.executor._client
    client.loop.add_callback(trouble)
    client.sync(tried)
print("done")
"""


def test_what_goes_wrong_within_the_library_is_not_printed(machines):
    run = subprocess.run([sys.executable, "-c", TROUBLE, machines.address], capture_output=True, text=True)
    assert (run.returncode, run.stdout, run.stderr) == (0, "done\n", "")


def test_loggers_are_as_before(machines):
    levels = [logging.getLogger(name).level for name in module.LOGGERS]
    with cluster(machines.address, print):
        assert logging.getLogger("distributed.core").getEffectiveLevel() > logging.CRITICAL
    assert [logging.getLogger(name).level for name in module.LOGGERS] == levels


@pytest.mark.parametrize("address", ["", "nonsense", "host:port", "ftp://127.0.0.1:1", "tcp://"])
def test_what_is_no_address_is_refused_at_once(address):
    assert "allowed: the address of a running Dask scheduler" in refusal(address)


def test_nobody_there_is_told_soon(monkeypatch, unused_address):
    monkeypatch.setattr(module, "CONNECT_TIMEOUT", 0.5)
    assert refusal(unused_address).startswith(f"--scheduler: '{unused_address}' is not allowed")


def test_a_silent_stranger_is_told_soon(monkeypatch):
    monkeypatch.setattr(module, "CONNECT_TIMEOUT", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as stranger:
        assert "--scheduler" in refusal(f"127.0.0.1:{stranger.getsockname()[1]}")


def test_without_dask_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    named = r"--scheduler needs distributed.*pip install 'trackctl\[cluster\]'"
    with pytest.raises(MissingLibraryError, match=named), cluster("127.0.0.1:1", pytest.fail):
        pass
