"""Run a sweep on a Dask cluster; the rows are the same as with worker processes of this computer.

Each thread of a worker runs its tasks in a separate process, because Dask cannot stop a run that exceeds the time
limit.  Dask repeats the run of a lost worker on another worker.
"""

import atexit
import pickle
import socket
from collections.abc import Iterable, Iterator
from contextlib import suppress
from queue import Empty, SimpleQueue
from threading import get_ident
from typing import Any, Self
from urllib.parse import urlsplit

from axistwin.errors import UsageError, require
from axistwin.sweeps.job import Job, Row, Runner
from axistwin.sweeps.workers import LIMIT_S, Task, Workers
from axistwin.version import VERSION

CONNECT_S = 10
PER_THREAD = 4
"""Number of submitted tasks for each thread of the cluster, so that no worker is idle."""
_POLL_S = 0.5
_processes: dict[int, tuple[bytes, Workers]] = {}
"""Pickled job and process by thread of a Dask worker."""


class Cluster:
    """The workers of a Dask scheduler.  Raises UsageError if the scheduler or a worker cannot be used."""

    def __init__(self, runner: Runner, scheduler: str, limit_s: float = LIMIT_S) -> None:
        require("distributed", "cluster")
        self._runner, self._address, self._limit_s = runner, scheduler, limit_s
        self._setup = pickle.dumps(runner.job)
        self._client: Any = None

    def __enter__(self) -> Self:
        from distributed import Client  # lazy import: takes a second

        try:
            _connect(self._address)
            self._client = Client(self._address, timeout=CONNECT_S, set_as_default=False)
        except (OSError, ValueError) as error:
            told = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise UsageError(f"no scheduler at {self._address}: expected e.g. tcp://127.0.0.1:8786 ({told})") from None
        self._check_workers()
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(Exception):  # the scheduler may have ended already
            self._client.close()

    def _check_workers(self) -> None:
        try:
            versions = self._client.run(version)
        except Exception as error:  # noqa: BLE001  # of the worker
            raise UsageError(f"a worker of {self._address} has no axistwin: install {VERSION} ({error})") from None
        if not versions:
            raise UsageError(f"{self._address} has no workers: start one, e.g. dask worker {self._address}")
        for worker, found in versions.items():
            if found != VERSION:
                raise UsageError(f"{worker} has axistwin {found}: expected {VERSION}, as here")

    def map(self, tasks: Iterable[Task]) -> Iterator[Row]:
        """Run the tasks; yield the row of results of each task as soon as its run ends."""
        waiting = iter(tasks)
        under_way: dict[Any, Task] = {}
        ended: SimpleQueue[Any] = SimpleQueue()
        while True:
            room = max(1, PER_THREAD * sum(self._client.nthreads().values())) - len(under_way)
            for task in (task for _, task in zip(range(room), waiting, strict=False)):
                future = self._client.submit(perform, self._setup, task, self._limit_s, pure=False)
                under_way[future] = task
                future.add_done_callback(ended.put)
            if not under_way:
                return
            try:
                future = ended.get(timeout=_POLL_S)
            except Empty:
                if self._client.status != "running" or not self._client.nthreads():
                    raise UsageError(
                        f"{self._address} has no workers left: the same command continues the sweep"
                    ) from None
                continue
            yield self._row(future, under_way.pop(future))

    def _row(self, future: Any, task: Task) -> Row:
        if future.status == "finished":
            row: Row = future.result()
            return row
        told = "the worker was killed" if future.status == "error" else f"the run was {future.status}"
        return {**self._runner.empty_row(*task), "ended": "killed", "notes": told}


def _connect(address: str) -> None:
    """Raise OSError or ValueError at once if no program listens at the address of a scheduler."""
    found = urlsplit(address)
    if not found.hostname or found.port is None:
        raise ValueError("invalid address of a scheduler")
    with socket.create_connection((found.hostname, found.port), CONNECT_S):
        pass


def version() -> str:
    """Return the version of axistwin on a worker."""
    from axistwin.version import VERSION as HERE

    return HERE


def perform(setup: bytes, task: Task, limit_s: float) -> Row:
    """Run a task on a worker, in the process of this thread."""
    from distributed import get_worker

    if not _processes:
        atexit.register(end_processes)
    known, process = _processes.get(get_ident(), (b"", None))
    if process is None or known != setup:
        if process is not None:
            process.__exit__()
        job: Job = pickle.loads(setup)  # noqa: S301  # from the user's own sweep
        process = Workers(Runner(job), 1, limit_s).__enter__()
        _processes[get_ident()] = setup, process
    (row,) = process.map([task])
    return {**row, "worker": str(get_worker().address)}


def end_processes() -> None:
    """End the processes that this Dask worker has started."""
    while _processes:
        _, (_, process) = _processes.popitem()
        process.__exit__()
