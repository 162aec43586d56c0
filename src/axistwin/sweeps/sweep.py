"""A sweep: a scene with varied values, measures and claims; `run` returns a table of results.

from axistwin.sweeps import Sweep

found = (
    Sweep("scene.toml")
    .vary("table.X.load.torque", "0.05..0.4:8")
    .measure("lost", "final table.X.lost")
    .run(seconds=10)
)
found.to_pandas()
"""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Self

from axistwin.core.errors import UsageError, reason
from axistwin.core.lazy import pa
from axistwin.core.storage import write_whole
from axistwin.core.version import VERSION
from axistwin.scenes.scene import Scene
from axistwin.sweeps import journal, searching
from axistwin.sweeps.cluster import Cluster
from axistwin.sweeps.designs import Points, points
from axistwin.sweeps.job import Job, Row, Runner, check_names
from axistwin.sweeps.journal import Journal
from axistwin.sweeps.sentences import measure
from axistwin.sweeps.values import Value, Values, read_values
from axistwin.sweeps.workers import LIMIT_S, Engine, ThisProcess, Workers, compile_servos

KEPT = 20
"""Largest number of failing runs for which a scene is saved."""
Progress = Callable[[int, int, int], object]
"""Function that is called with three numbers of runs: finished, all, and runs in which a claim fails."""


@dataclass(frozen=True)
class Design:
    """Options that determine the runs' values, e.g. `--design grid`; `search`: runs for a search."""

    name: str = "grid"
    runs: int | None = None
    seed: int = 0
    search: int | None = None


class Sweep:
    """A sweep of a scene (a file, a `Scene` or a dict).  `program` and `host` are part of every run."""

    def __init__(
        self, scene: Scene | str | Path | Mapping[str, Any], program: str | Path | None = None, host: str | None = None
    ) -> None:
        if isinstance(scene, Scene):
            self.scene = scene
        else:
            self.scene = Scene.given(scene) if isinstance(scene, Mapping) else Scene.load(scene)
        self.scene.build()  # The method `build` also reads the scene's program files into memory.
        self.program, self.host = None if program is None else Path(program), host
        self.varied: dict[str, Values] = {}
        self.measures: dict[str, str] = {}
        self.claims: dict[str, str] = {}

    def vary(self, path: str, values: Value) -> Self:
        """Add a setting that the sweep varies, e.g. a load torque.

        For example, `.vary("table.X.load.torque", "0.05..0.4:8")` selects 8 values from 0.05 to 0.4.  Raises UsageError
        for invalid values, or if the setting is already varied.
        """
        if path in self.varied:
            raise UsageError(f"the setting {path} is given twice: expected only one --vary per setting")
        try:
            self.varied[path] = read_values(values)
        except UsageError as error_of_values:
            raise UsageError(f"invalid values for the setting {path}: {error_of_values}") from None
        return self

    def measure(self, name: str, sentence: str) -> Self:
        """Measure a value in each run, e.g. the number of lost steps: `.measure("lost", "final table.X.lost")`."""
        check_names([name], [*self.varied, *self.measures, *self.claims])
        self.measures[name] = sentence
        return self

    def claim(self, name: str, sentence: str) -> Self:
        """Add a claim (a condition for each run), e.g. `.claim("safe", "never table.X passes 12000")`."""
        check_names([name], [*self.varied, *self.measures, *self.claims])
        self.claims[name] = sentence
        return self

    def plan(self, design: Design, seconds: float | None) -> dict[str, Any]:
        """Return the plan of the sweep: everything that determines the results, e.g. the number of runs."""
        varied = {path: values.text for path, values in self.varied.items()}
        job = self._job(seconds)
        return {
            "version": VERSION, "scene": job.hash(), "varied": varied, "design": design.name, "runs": design.runs,
            "seed": design.seed, "search": design.search, "measures": self.measures, "claims": self.claims,
            "for": seconds, "program": self.program and self.program.name, "host": self.host,
        }  # fmt: skip

    def _job(self, seconds: float | None) -> Job:
        return Job(
            self.scene, tuple(self.varied), self.measures, self.claims, seconds, self.program, self.host,
            self.scene.device_files,
        )  # fmt: skip

    def check(self, design: Design | None = None, seconds: float | None = None) -> tuple[Runner, Points]:
        """Check the sweep before the first run, without importing its host.  Raises UsageError for an invalid sweep.

        Returns the object that performs the runs, and the varied values of each run.
        """
        design = design or Design()
        runner = Runner(self._job(seconds))
        if design.search is not None:
            searching.check(self.varied, self.claims)
        found = () if design.search is not None else points(design.name, self.varied, design.runs, design.seed)
        drawn: list[Sequence[Value]] = [*zip(*found, strict=True)] or [()] * len(self.varied)
        for number, (values, column) in enumerate(zip(self.varied.values(), drawn, strict=True)):
            for value in _checked(values, column):
                runner.variation.check(number, value)
        return runner, found

    def run(
        self, out: str | Path | None = None, *, seconds: float | None = None, design: Design | None = None,
        workers: int | None = None, limit: float = LIMIT_S, progress: Progress | None = None,
        scheduler: str | None = None, tell: Callable[[str], None] = lambda words: None,
    ) -> "pa.Table":  # fmt: skip
        """Perform all runs of the sweep, and return a table with one row for each run.

        `out`: Parquet file for the table; an interrupted sweep is resumed.  `seconds`: virtual time of each run.
        `workers`: number of processes; 0: run in this process; None: one process per core.  `limit`: longest real time
        of a run in seconds.  `scheduler`: address of a Dask cluster, which performs the runs instead of this computer.
        Raises UsageError before the first run.
        """
        if out is None:
            with TemporaryDirectory() as directory:
                return self.run(
                    Path(directory) / "sweep.parquet", seconds=seconds, design=design, workers=workers, limit=limit,
                    progress=progress, scheduler=scheduler, tell=tell,
                )  # fmt: skip
        design, out = design or Design(), Path(out)
        runner, found = self.check(design, seconds)
        prepare(runner, scheduler)
        with Journal(out, self.plan(design, seconds), self._types(found)) as results:
            if not results.complete:
                engine = engine_for(runner, workers, limit, tell, scheduler)
                self._run(runner, results, engine, design, found, progress, tell)
        return journal.read(out)

    def _run(
        self, runner: Runner, results: Journal, engine: Engine, design: Design, found: Points,
        progress: Progress | None, tell: Callable[[str], None],
    ) -> None:  # fmt: skip
        all_runs = design.search or len(found)
        done, failing = len(results.done), 0
        kept = len([*_kept(results.out).glob("run-*")])
        try:
            with engine:
                for row in self._rows(engine, results, design, found):
                    results.add(row)
                    done += 1
                    if any(row[name] is False for name in self.claims):
                        failing += 1
                        kept += _keep(runner, row, _kept(results.out), tell) if kept < KEPT else 0
                    if progress is not None:
                        progress(done, all_runs, failing)
        finally:
            results.flush()
        results.finish()

    def _rows(self, engine: Engine, results: Journal, design: Design, found: Points) -> Iterator[Row]:
        if design.search is not None:
            known = searching.known(results, self.claims)
            yield from searching.search(engine, self.varied, tuple(self.claims), design.search, design.seed, known)
            return
        done = frozenset(results.done)  # the journal adds to it
        yield from engine.map((number, values) for number, values in enumerate(found) if number not in done)

    def _types(self, found: Points) -> dict[str, str]:
        columns: list[Sequence[Value]] = [*zip(*found, strict=True)]
        columns = columns or [values.samples for values in self.varied.values()]
        types = {"run": "whole"}
        types |= {path: journal.kind_of(column) for path, column in zip(self.varied, columns, strict=True)}
        types |= {
            name: "numbers" if measure(text).text.endswith(" each") else "number"
            for name, text in self.measures.items()
        }
        for name in self.claims:
            types |= {name: "truth", f"{name}.robustness": "number", f"{name}.at_s": "number"}
        texts = dict.fromkeys(("difference", "notes", "worker", "version", "scene"), "text")
        return {**types, "ended": "text", "seconds": "number", "wall_s": "number", **texts}


def prepare(runner: Runner, scheduler: str | None) -> None:
    """Import the user's host.  Raises UsageError if the host or the cluster at `scheduler` cannot be used."""
    runner.host  # noqa: B018  # imported at its first use
    if scheduler:
        with Cluster(runner, scheduler):
            pass


def engine_for(
    runner: Runner, workers: int | None, limit: float, tell: Callable[[str], None], scheduler: str | None = None
) -> Engine:
    """Return the engine that performs the runs of a sweep, e.g. worker processes.

    `workers`: number of worker processes; None: one for each core; 0: perform the runs in this process.  `scheduler`:
    address of a Dask cluster to use instead.
    """
    if scheduler:
        return Cluster(runner, scheduler, limit)
    count = len(os.sched_getaffinity(0)) if workers is None and hasattr(os, "sched_getaffinity") else workers
    count = (os.cpu_count() or 1) if count is None else count
    compile_servos(runner)  # The servo code is compiled once, before the worker processes start.
    return Workers(runner, count, limit, tell) if count else ThisProcess(runner)


def _checked(values: Values, drawn: Sequence[Value]) -> Sequence[Value]:
    return values.samples if values.listed or not drawn else [min(drawn), max(drawn)]


def _kept(out: Path) -> Path:
    return out.with_name(f"{out.stem}-failing")


def _keep(runner: Runner, row: Row, directory: Path, tell: Callable[[str], None]) -> int:
    """Write a scene that repeats a failing run; return the number of scenes.  After a failure, no more follow."""
    try:
        for name, text in runner.files(row).items():
            file = directory / f"run-{row['run']}" / name
            file.parent.mkdir(parents=True, exist_ok=True)
            write_whole(file, text.encode())
    except OSError as error:
        tell(f"no scenes of failing runs: cannot write {directory}: {reason(error)}")
        return KEPT
    return 1
