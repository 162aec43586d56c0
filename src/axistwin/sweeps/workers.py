"""Worker processes on this computer.  Each worker runs one point at a time.

A killed worker is replaced and its run is repeated; a run is tried three times.  A worker whose run exceeds the time
limit is killed, and this run is not repeated.  Rows are yielded in the order in which their runs end.
"""

import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Lock, Thread
from time import monotonic
from typing import Any, BinaryIO, Protocol, Self

from axistwin.sweeps.job import Job, Row, Runner
from axistwin.sweeps.values import Value

Task = tuple[int, Sequence[Value]]
"""One task of a worker: the number of a run, and its values."""
TRIES = 3
LIMIT_S = 600.0
_POLL_S = 0.2


class Engine(Protocol):
    """Interface of `Workers` and `ThisProcess`: a context manager that runs tasks."""

    def __enter__(self) -> Self:
        """Start the workers."""

    def __exit__(self, *_: object) -> None:
        """Stop the workers; unfinished runs are lost."""

    def map(self, tasks: Iterable[Task]) -> Iterator[Row]:
        """Run the tasks; yield the row of results of each task, in any order."""


class ThisProcess:
    """Engine that runs tasks in this process, one after the other, without a time limit."""

    def __init__(self, runner: Runner) -> None:
        self._runner = runner

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Do nothing."""

    def map(self, tasks: Iterable[Task]) -> Iterator[Row]:
        """Run the tasks; yield the row of results of each task."""
        for number, values in tasks:
            yield self._runner.row(number, values)


class Workers:
    """Engine that runs the tasks of one job in worker processes."""

    def __init__(
        self, runner: Runner, count: int, limit_s: float = LIMIT_S, tell: Callable[[str], None] = print
    ) -> None:
        self._runner, self._limit_s, self._tell = runner, limit_s, tell
        self._setup = pickle.dumps(runner.job)
        self._workers = [_Worker(f"worker {n + 1}", self._setup) for n in range(count)]
        self._lock = Lock()
        self._ended = False

    def __enter__(self) -> Self:
        for worker in self._workers:
            worker.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended = True
        for worker in self._workers:
            worker.kill()

    @property
    def processes(self) -> list[int]:
        """Process IDs of the workers."""
        return [worker.process.pid for worker in self._workers if worker.process is not None]

    def map(self, tasks: Iterable[Task]) -> Iterator[Row]:
        """Run the tasks; yield the row of results of each task as soon as its run ends."""
        waiting, rows = iter(tasks), SimpleQueue[Row | BaseException | None]()
        threads = [Thread(target=self._serve, args=(worker, waiting, rows), daemon=True) for worker in self._workers]
        for thread in threads:
            thread.start()
        running = len(threads)
        while running:
            try:
                row = rows.get(timeout=_POLL_S)
            except Empty:
                self._end_late_runs()
                continue
            if isinstance(row, BaseException):
                raise row
            if row is None:
                running -= 1
            else:
                yield row

    def _end_late_runs(self) -> None:
        for worker in self._workers:
            if worker.busy_s() > self._limit_s:
                worker.late = True
                worker.interrupt()

    def _serve(
        self, worker: "_Worker", waiting: Iterator[Task], rows: "SimpleQueue[Row | BaseException | None]"
    ) -> None:
        """Send tasks to a worker until all tasks are taken."""
        try:
            while not self._ended:
                with self._lock:
                    task = next(waiting, None)
                if task is None:
                    break
                row = self._perform(worker, task)
                if row is not None:
                    rows.put(row)
        except BaseException as error:  # noqa: BLE001  # `map` raises the error in the caller's thread
            rows.put(error)
        rows.put(None)

    def _perform(self, worker: "_Worker", task: Task) -> Row | None:
        for _ in range(TRIES):
            with suppress(EOFError, OSError, pickle.UnpicklingError):
                return worker.perform(task)
            if self._ended:
                return None
            worker.kill()
            late, worker.late = worker.late, False
            worker.start()
            if late:
                note = f"not finished after {self._limit_s:g} s of real time"
                return {**self._runner.empty_row(*task, worker.name), "ended": "limit", "notes": note}
            self._tell(f"{worker.name} was killed in run {task[0]}: the run is repeated")
        return {**self._runner.empty_row(*task, worker.name), "ended": "killed", "notes": "the worker was killed"}


class _Worker:
    """One worker process, which receives tasks on its standard input."""

    def __init__(self, name: str, setup: bytes) -> None:
        self.name, self.late = name, False
        self.process: subprocess.Popen[bytes] | None = None
        self._setup = setup
        self._since_s: float | None = None

    def start(self) -> None:
        """Start the process; do not wait until it is ready."""
        package = str(Path(__file__).resolve().parents[2])
        path = os.pathsep.join(dict.fromkeys((package, *(part or os.getcwd() for part in sys.path))))
        self.process = subprocess.Popen(
            [sys.executable, "-c", "from axistwin.sweeps.workers import work; work()", self.name],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, env={**os.environ, "PYTHONPATH": path},
            start_new_session=True,  # Ctrl-C must interrupt only the parent process
        )  # fmt: skip
        with suppress(OSError):
            self._pipe(self.process.stdin).write(self._setup)

    def perform(self, task: Task) -> Row:
        """Run a task in the process.  Raises EOFError or OSError if the process ends."""
        assert self.process is not None, "the worker has been started"
        pickle.dump(task, self._pipe(self.process.stdin))
        self._pipe(self.process.stdin).flush()
        self._since_s = monotonic()
        row: Row = pickle.load(self._pipe(self.process.stdout))  # noqa: S301  # our own process
        self._since_s = None
        return row

    def busy_s(self) -> float:
        """Return the seconds since the start of the current run; 0 if the process is idle."""
        since_s = self._since_s
        return 0.0 if since_s is None else monotonic() - since_s

    def interrupt(self) -> None:
        """Kill the process; `perform` then raises EOFError in its thread."""
        self._since_s = None
        if self.process is not None:
            self.process.kill()

    def kill(self) -> None:
        """Kill the process and close its pipes; no other thread may be using them."""
        self._since_s = None
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            for pipe in (self.process.stdin, self.process.stdout):
                with suppress(OSError):
                    self._pipe(pipe).close()

    def _pipe(self, pipe: Any) -> BinaryIO:
        assert pipe is not None, "the process has pipes"
        stream: BinaryIO = pipe
        return stream


def work() -> None:
    """Run tasks until the end of standard input: the main function of a worker process."""
    with suppress(ValueError):
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    tasks, rows = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # the output of the user's host must not mix with the rows
    job: Job = pickle.load(tasks)  # noqa: S301  # from our own parent process
    runner = Runner(job)
    prepare(runner)
    with suppress(EOFError, BrokenPipeError):  # the parent process has ended
        while True:
            number, values = pickle.load(tasks)  # noqa: S301
            pickle.dump(runner.row(number, values, sys.argv[1]), rows)
            rows.flush()


def prepare(runner: Runner) -> None:
    """Compile the code of the servo loop, which is needed once per process."""
    controllers = runner.variation.base.build().controllers.values()
    for made in {controller.product.model: controller.product for controller in controllers}.values():
        made.prepare(None, len(controllers))
