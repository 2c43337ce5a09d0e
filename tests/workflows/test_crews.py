"""Tables solved by other crews than the threads of this process: the same bytes."""

from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context

import pytest
from table_runs import StoppedError, compiled, stop_after

from trackctl.errors import WorkerError
from trackctl.files.journal import journal_path
from trackctl.lut.crew import Crew, build, solve_for


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    output = tmp_path_factory.mktemp("whole") / "lut.h5"
    compiled(output)
    return output.read_bytes()


@contextmanager
def processes(count=2):
    with ProcessPoolExecutor(count, get_context("spawn")) as pool:
        yield pool, Crew(pool, lambda: count)


def test_processes_give_the_bytes_of_threads(tmp_path, whole):
    with processes() as (_, crew):
        compiled(tmp_path / "lut.h5", crew=crew)
    assert (tmp_path / "lut.h5").read_bytes() == whole


def test_a_process_that_dies_is_told_and_another_crew_goes_on(tmp_path, whole):
    output = tmp_path / "lut.h5"
    with processes(1) as (pool, crew):

        def kill_after_two(done, total):
            if done == 2:
                for process in pool._processes.values():
                    process.kill()
                    process.join()

        with pytest.raises(WorkerError, match=r"BrokenProcessPool.*lut\.h5\.partial keeps what is done, --resume"):
            compiled(output, crew=crew, progress=kill_after_two)
    assert not output.exists()
    compiled(output, resume=True)
    assert output.read_bytes() == whole


def test_what_threads_began_processes_finish(tmp_path, whole):
    output = tmp_path / "lut.h5"
    with pytest.raises(StoppedError):
        compiled(output, progress=stop_after(3))
    with processes(1) as (_, crew):
        compiled(output, crew=crew, resume=True)
    assert output.read_bytes() == whole


def test_an_executor_that_takes_no_work_is_told(tmp_path):
    with processes(1) as (_, crew):
        pass
    with pytest.raises(WorkerError, match="the workers failed: RuntimeError"):
        compiled(tmp_path / "lut.h5", crew=crew)
    assert [path.name for path in tmp_path.iterdir()] == ["lut.h5.partial"]


def test_a_defect_in_the_work_stays_one(tmp_path, monkeypatch):
    def defective(asking, sweep, column):
        raise ZeroDivisionError

    monkeypatch.setattr("trackctl.lut.crew.solve_for", defective)
    with pytest.raises(ZeroDivisionError):
        compiled(tmp_path / "lut.h5")


def test_a_worker_of_another_build_refuses():
    with pytest.raises(WorkerError, match=r"the worker on .* runs trackctl .*, this is trackctl 0\.0\.1; install"):
        solve_for("trackctl 0.0.1", None, 0)
    assert build().startswith("trackctl ")


def test_no_work_is_left_under_way_by_a_stopped_run(tmp_path):
    class Held:
        """Takes work and does the first piece only."""

        def __init__(self):
            self.futures = []

        def submit(self, function, *arguments):
            from concurrent.futures import Future

            future = Future()
            if not self.futures:
                future.set_result(function(*arguments))
            self.futures.append(future)
            return future

    held = Held()
    with pytest.raises(StoppedError):
        compiled(tmp_path / "lut.h5", crew=Crew(held, lambda: 1), progress=stop_after(1))
    assert all(future.cancelled() for future in held.futures[1:])
    assert len(held.futures) == 4
    assert journal_path(tmp_path / "lut.h5").exists()
