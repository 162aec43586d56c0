"""Worker processes on this computer.  Each worker runs one point at a time.

While runs are short, a worker already has its next task, so that the worker does not wait for this process.  A killed
worker is replaced and its run is repeated; a run is tried three times.  A worker whose run exceeds the time limit is
killed, and this run is not repeated.  Rows are yielded in the order in which their runs end.
"""

import pickle
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from queue import Empty, SimpleQueue
from threading import Lock, Thread
from time import monotonic
from typing import Protocol, Self

from axistwin.core.child import Child, pipes
from axistwin.sweeps.job import Job, Row, Runner
from axistwin.sweeps.values import Value

Task = tuple[int, Sequence[Value]]  # One task of a worker: the number of a run, and its values.
TRIES = 3
LIMIT_S = 600.0
SHORT_S = 0.1  # Longest real time of a run after which a worker gets its next task in advance.
_POLL_S = 0.2


class Engine(Protocol):
    """Interface of `Workers` and `ThisProcess`: a context manager that runs tasks."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *_: object) -> None:
        """Stop the worker processes; the results of unfinished runs are lost."""

    def map(self, tasks: Iterable[Task]) -> Iterator[Row]:
        """Execute all runs of a sweep, and yield the results of each run.  The results can come in any order."""


class ThisProcess:
    """Engine that performs runs in this process, one after the other, without a time limit."""

    def __init__(self, runner: Runner) -> None:
        self._runner = runner

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None: ...

    def map(self, tasks: Iterable[Task]) -> Iterator[Row]:
        for number, values in tasks:
            yield self._runner.row(number, values)


class Workers:
    """Engine that performs the runs of a sweep in worker processes."""

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
        return [worker.process.pid for worker in self._workers if worker.process is not None]

    def map(self, tasks: Iterable[Task]) -> Iterator[Row]:
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
        try:
            while not self._ended:
                while len(worker.tasks) < worker.ahead:
                    with self._lock:
                        task = next(waiting, None)
                    if task is None:
                        break
                    worker.send(task)
                if not worker.tasks:
                    break
                row = self._row(worker)
                if row is not None:
                    rows.put(row)
        except BaseException as error:  # noqa: BLE001  # `map` raises the error in the caller's thread
            rows.put(error)
        rows.put(None)

    def _row(self, worker: "_Worker") -> Row | None:
        """Return the current task's results; None, e.g. if a killed worker process repeats the task."""
        with suppress(EOFError, OSError, pickle.UnpicklingError):
            return worker.receive()
        if self._ended:
            return None
        worker.kill()
        late, worker.late = worker.late, False
        task, worker.tries = worker.tasks[0], worker.tries + 1
        row = None
        if late:
            note = f"not finished after {self._limit_s:g} s of real time"
            row = {**self._runner.empty_row(*task, worker.name), "ended": "limit", "notes": note}
        elif worker.tries == TRIES:
            note = "the worker was killed"
            row = {**self._runner.empty_row(*task, worker.name), "ended": "killed", "notes": note}
        else:
            self._tell(f"{worker.name} was killed in run {task[0]}: the run is repeated")
        if row is not None:
            worker.drop()
        if worker.tasks:
            worker.start()
        else:
            worker.stopped = True
        return row


class _Worker:
    def __init__(self, name: str, setup: bytes) -> None:
        self.name, self.late = name, False
        self.process: Child | None = None
        self.tasks: deque[Task] = deque()  # Tasks that the process has; the first one runs.
        self.tries = 0  # Number of times that the process was killed in the first task.
        self.ahead = 1  # Number of tasks that the process may have.
        self.stopped = False  # True if the process was killed and is not needed until the next task.
        self._setup, self._ready = setup, False
        self._since_s: float | None = None
        """Time at which the first task began; None: the process is not ready, or has no task."""

    def start(self) -> None:
        """Start the process, and write the queued tasks to its standard input, without waiting for it."""
        self._ready = self.stopped = False
        self.process = Child(__name__, "work", self.name)
        for each in (self._setup, *map(pickle.dumps, self.tasks)):
            self._write(each)

    def send(self, task: Task) -> None:
        """Send a task to the worker process, which is started again if it has stopped."""
        self.tasks.append(task)
        if self.stopped:
            self.start()
        else:
            self._write(pickle.dumps(task))
        if self._ready and self._since_s is None:
            self._since_s = monotonic()

    def _write(self, pickled: bytes) -> None:
        assert self.process is not None, "the worker has been started"
        with suppress(OSError):  # If the worker process has ended, the next read of results raises an error.
            self.process.send(pickled)

    def receive(self) -> Row:
        """Return the row of the first task.  Raises EOFError or OSError if the process ends."""
        assert self.process is not None, "the worker has been started"
        if not self._ready:
            self._ready = self.process.receive()
            self._since_s = monotonic()
        row: Row = self.process.receive()
        self.drop()
        self.late = False
        self._since_s = monotonic() if self.tasks else None
        self.ahead = 2 if row["wall_s"] < SHORT_S else 1
        return row

    def drop(self) -> None:
        self.tasks.popleft()
        self.tries = 0

    def busy_s(self) -> float:
        """Return the seconds since the start of the worker's current run, or 0 if the worker is idle."""
        since_s = self._since_s
        return 0.0 if since_s is None else monotonic() - since_s

    def interrupt(self) -> None:
        """Kill the worker process.  A thread that waits in `receive` then gets an EOFError."""
        self._since_s = None
        if self.process is not None:
            self.process.interrupt()

    def kill(self) -> None:
        """Kill the worker process, and close its pipes.  No other thread may use the pipes at the same time."""
        self._since_s = None
        if self.process is not None:
            self.process.end()


def work() -> None:
    tasks, rows = pipes()
    job: Job = pickle.load(tasks)  # noqa: S301  # from our own parent process
    runner = Runner(job)
    compile_servos(runner)
    # EOFError or BrokenPipeError means that the parent process has ended.
    with suppress(EOFError, BrokenPipeError):
        pickle.dump(True, rows)  # Report to the parent process that the worker process is ready.
        rows.flush()
        while True:
            number, values = pickle.load(tasks)  # noqa: S301
            pickle.dump(runner.row(number, values, sys.argv[1]), rows)
            rows.flush()


def compile_servos(runner: Runner) -> None:
    """Compile the simulation code of the scene's controllers before the first run, if necessary."""
    controllers = runner.variation.base.build().controllers.values()
    for made in {controller.product.model: controller.product for controller in controllers}.values():
        made.prepare(None, len(controllers))
