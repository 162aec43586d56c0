"""Run a sweep on a Dask cluster; the rows are the same as with worker processes of this computer.

Tasks are sent in batches, because a message takes some milliseconds.  Each thread of a worker runs its tasks in a
separate process, because Dask cannot stop a run that exceeds the time limit.  Dask repeats the batch of a lost worker
on another worker.
"""

import atexit
import logging
import pickle
import socket
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from itertools import islice
from queue import Empty, SimpleQueue
from threading import get_ident
from time import monotonic
from typing import Any, Self
from urllib.parse import urlsplit

from axistwin.core.errors import UsageError, require
from axistwin.core.version import VERSION
from axistwin.sweeps.job import Job, Row, Runner
from axistwin.sweeps.workers import LIMIT_S, Task, Workers

CONNECT_S = 10
PER_THREAD = 3  # Number of submitted batches for each thread of the cluster, so that no worker is idle.
BATCH_S, MOST_TASKS = 0.2, 32  # Real time of a batch, and its largest number of tasks.
_POLL_S = 0.5
_processes: dict[int, tuple[bytes, Workers]] = {}  # Pickled job and process by thread of a Dask worker.


class Cluster:
    """Engine that runs tasks on a Dask cluster.  Raises UsageError if the scheduler or a worker cannot be used."""

    def __init__(self, runner: Runner, scheduler: str, limit_s: float = LIMIT_S) -> None:
        require("distributed", "cluster")
        self._runner, self._address, self._limit_s = runner, scheduler, limit_s
        self._setup = pickle.dumps(runner.job)
        self._client: Any = None
        self._run_s: float = BATCH_S  # Real time of a run, on average over the latest runs.

    def __enter__(self) -> Self:
        from distributed import Client  # Only a sweep on a cluster imports Dask, which loads slowly.

        self._levels = _silence()
        try:
            _connect(self._address)
            self._client = Client(self._address, timeout=CONNECT_S, set_as_default=False)
        except (OSError, ValueError) as error:
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise UsageError(
                f"no scheduler answers at {self._address} ({reason}): expected e.g. tcp://127.0.0.1:8786"
            ) from None
        self._check_workers()
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(Exception):  # Closing the connection fails if the Dask scheduler has ended.
            self._client.close()
        for logger, level in self._levels.items():
            logger.setLevel(level)

    def _check_workers(self) -> None:
        try:
            versions = self._client.run(version)
        except Exception as error:  # noqa: BLE001  # of the worker
            raise UsageError(
                f"a worker of {self._address} cannot import axistwin ({error}): install axistwin {VERSION}"
            ) from None
        if not versions:
            raise UsageError(
                f"the scheduler {self._address} has no workers: start a worker, e.g. dask worker {self._address}"
            )
        for worker, version_found in versions.items():
            if version_found != VERSION:
                raise UsageError(
                    f"worker {worker} has axistwin {version_found}, but this computer has axistwin {VERSION}: "
                    "install the same version on both"
                )

    def map(self, tasks: Iterable[Task]) -> Iterator[Row]:
        """Yield each run's results when it ends.  Raises UsageError if the connection to the cluster is lost."""
        try:
            yield from self._rows(iter(tasks))
        except UsageError:
            raise
        except Exception:  # noqa: BLE001  # of Dask: several errors of the connection
            raise self._lost() from None

    def _lost(self) -> UsageError:
        what = "has no workers left" if self._client.status == "running" else "does not answer any more"
        return UsageError(f"{self._address} {what}: start it again, and the same command continues the sweep")

    def _rows(self, waiting: Iterator[Task]) -> Iterator[Row]:
        under_way: dict[Any, list[Task]] = {}
        again: list[Task] = []  # Tasks to be sent one by one, because their batch failed.
        ended: SimpleQueue[Any] = SimpleQueue()
        counted_s, threads = 0.0, 0
        while True:
            if monotonic() - counted_s > _POLL_S:
                counted_s, threads = monotonic(), sum(self._client.nthreads().values())
                if not threads or self._client.status != "running":
                    raise self._lost()
            while len(under_way) < PER_THREAD * threads:
                size = max(1, min(MOST_TASKS, int(BATCH_S / self._run_s)))
                batch = [again.pop()] if again else list(islice(waiting, size))
                if not batch:
                    break
                future = self._client.submit(perform, self._setup, batch, self._limit_s, pure=False)
                under_way[future] = batch
                future.add_done_callback(ended.put)
            if not under_way:
                return
            with suppress(Empty):
                future = ended.get(timeout=_POLL_S)
                batch = under_way.pop(future)
                if future.status == "error" and len(batch) > 1:
                    again += batch
                else:
                    yield from self._ended(future, batch)

    def _ended(self, future: Any, batch: Sequence[Task]) -> Iterator[Row]:
        if future.status == "finished":
            for row in future.result():
                self._run_s += (max(row["wall_s"], 1e-3) - self._run_s) / 8
                yield row
        elif future.status == "error":
            lost = type(future.exception()).__name__ == "KilledWorker"
            told = {"ended": "killed", "notes": "the worker was killed"}
            told = told if lost else {"ended": "error", "notes": str(future.exception())}
            yield from ({**self._runner.empty_row(*task), **told} for task in batch)
        else:
            raise self._lost()


def _silence() -> dict[logging.Logger, int]:
    known = [logging.getLogger(name) for name in logging.root.manager.loggerDict if name.startswith("distributed")]
    levels = {logger: logger.level for logger in known}
    for logger in known:
        logger.setLevel(logging.CRITICAL + 1)
    return levels


def _connect(address: str) -> None:
    """Raise OSError or ValueError if no Dask scheduler listens: Dask itself would try again without end."""
    found = urlsplit(address)
    if not found.hostname or found.port is None:
        raise ValueError("invalid address of a scheduler: expected a host and a port")
    with socket.create_connection((found.hostname, found.port), CONNECT_S) as connection:
        # A Dask scheduler sends data to each new client; a program that sends no data is not a Dask scheduler.
        if found.scheme == "tcp" and not connection.recv(1):
            raise OSError(f"the program at {address} is not a Dask scheduler")


def version() -> str:
    from axistwin.core.version import VERSION as HERE

    return HERE


def perform(setup: bytes, tasks: list[Task], limit_s: float) -> list[Row]:
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
    where = str(get_worker().address)
    return [{**row, "worker": where} for row in process.map(tasks)]


def end_processes() -> None:
    while _processes:
        _, (_, process) = _processes.popitem()
        process.__exit__()
