"""Tuning with Optuna: find the best values for the settings of a scene, such as gains.

from axistwin.sweeps.tuning import Tuning

best = (
    Tuning("scene.toml", "max |knife.shaft.following_error|")
    .change("knife.KP", "10..400")
    .vary("knife.shaft.load.inertia_kg_m2", "1.6e-4..2.4e-4:3")
    .run("gains.db", trials=100)
)

A trial is one point of the changed values.  It runs once for each point of the varied values, and its score is the
worst result of these runs.  Every claim must hold in every run.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Self

from axistwin.core.errors import UsageError
from axistwin.core.version import VERSION
from axistwin.scenes.scene import Scene
from axistwin.sweeps.designs import Points
from axistwin.sweeps.job import Row, Runner
from axistwin.sweeps.paths import Variation
from axistwin.sweeps.study import Study, Trial, reserved
from axistwin.sweeps.sweep import Design, Sweep, engine_for, prepare
from axistwin.sweeps.values import Value, Values
from axistwin.sweeps.workers import LIMIT_S, Engine

GOAL = "goal"
"""Name of the measure that is minimised or maximised."""
LEAST_VIOLATION = 1e-12
"""Violation that is stored for a claim that fails with a robustness of 0."""
FAR = 1e12
"""Score of a trial without results, and upper limit of a violation."""
GAINS = ("KP", "KI", "KD", "KL", "KS", "KV", "KA", "KG")
"""Gains of a SmartMotor; a new value takes effect with the command F."""
Progress = Callable[[int, int, Trial | None, Trial], object]
"""Function that is called with two numbers (finished trials, all trials), the best trial and the delivered one."""


class Tuning:
    """Finds settings, e.g. gains, that minimise or maximise the measure `goal`."""

    def __init__(
        self, scene: Scene | str | Path | Mapping[str, Any], goal: str, *, maximise: bool = False,
        program: str | Path | None = None, host: str | None = None,
    ) -> None:  # fmt: skip
        self._scatter = Sweep(scene, program, host).measure(GOAL, goal)
        self.maximises = maximise
        self._sign = -1.0 if maximise else 1.0
        self.goal = f"{'maximise' if maximise else 'minimise'} {goal}"
        self.changed: dict[str, Values] = {}

    def change(self, path: str, values: Value) -> Self:
        """Add a setting to optimise, e.g. the gain KP from 10 to 400: `.change("knife.KP", "10..400")`.

        `path`: the setting.  `values`: a range or a list of values.  Raises UsageError for invalid values, or if the
        path is given twice.
        """
        given = Sweep(self._scatter.scene).vary(path, values).varied[path]
        if path in {**self.changed, **self._scatter.varied}:
            raise UsageError(f"the setting {path} is given twice: expected only one --change or --vary per setting")
        if given.interval is None and not given.listed:
            raise UsageError(f"cannot tune {path}={given.text}: expected a range or a list of values, e.g. 10..400")
        self.changed[path] = given
        return self

    def vary(self, path: str, values: Value) -> Self:
        """Run each trial several times, e.g. with ten random seeds: `.vary("seed", "0..9")`.

        A trial is a combination of tuned values.  The worst run determines the score of the trial.  `path`: a setting
        that is not tuned.
        """
        if path in self.changed:
            raise UsageError(f"the setting {path} is given twice: expected only one --change or --vary per setting")
        self._scatter.vary(path, values)
        return self

    def subject_to(self, name: str, sentence: str) -> Self:
        """Add a claim that must hold in every run of a trial."""
        self._scatter.claim(name, sentence)
        return self

    def run(
        self, out: str | Path, *, trials: int, seed: int = 0, design: Design | None = None,
        seconds: float | None = None, workers: int | None = None, limit: float = LIMIT_S,
        progress: Progress | None = None, scheduler: str | None = None,
        tell: Callable[[str], None] = lambda words: None,
    ) -> Study:  # fmt: skip
        """Test `trials` combinations of setting values, and return the results as a `Study`.

        The results are stored in the SQLite file `out`; earlier combinations in `out` are not tested again.
        `design`: the combinations of varied values.
        `scheduler`: address of a Dask cluster, which performs the runs instead of this computer.  Raises UsageError.
        """
        delivered, runner, scatter = self.check(design or Design(), seconds)
        prepare(runner, scheduler)
        with reserved(Path(out)):
            study = Study(Path(out), self._plan(design or Design(), seed, seconds, delivered), self.changed, seed)
            if study.delivered is None:
                with engine_for(delivered, 0, limit, tell) as engine:
                    study.delivered = self._trial({}, _rows(engine, [(n, point) for n, point in enumerate(scatter)]))
            if trials > len(study.trials):
                with engine_for(runner, workers, limit, tell, scheduler) as engine:
                    for batch in study.batches(trials):
                        self._run(study, engine, batch, scatter, trials, progress)
        return study

    def check(self, design: Design, seconds: float | None) -> tuple[Runner, Runner, Points]:
        """Raise UsageError if the search for the best settings cannot start, e.g. without a setting to change.

        Returns the runner of the unchanged scene, the runner of the trials, and the varied values of a trial.
        """
        if not self.changed:
            raise UsageError(
                "the search has no value to change: add --change PATH=VALUES, e.g. --change knife.KP=10..400"
            )
        delivered, scatter = self._scatter.check(design, seconds)
        job = delivered.job
        paths = (*self.changed, *job.paths)
        runner = Runner(replace(job, paths=paths, for_s=seconds))
        for number, values in enumerate(self.changed.values()):
            for value in values.samples:
                runner.variation.check(number, value)
        return delivered, runner, scatter

    def lines(self, values: Mapping[str, Value]) -> Iterator[str]:
        """Yield text with these values for a program or a scene, e.g. `KP=100`."""
        variation = Variation(self._scatter.scene, values)
        texts: dict[str, list[str]] = {}
        for place, value in zip(variation.places, values.values(), strict=True):
            if place.file:
                texts.setdefault(f"in {Path(place.file).name}", []).append(f"{place.variable}={value}")
            elif "variables" in place.keys:
                motor = place.path.rpartition(".")[0] or "the motor"
                texts.setdefault(f"in the program of {motor}", []).append(f"{place.keys[-1]}={value}")
            else:
                texts.setdefault("in the scene", []).append(f"{place.path} = {json.dumps(value)}")
        for where, found in texts.items():
            yield f"{where}:"
            if where == "in the scene":
                yield from (f"    {text}" for text in found)
            else:
                gains = any(text.partition("=")[0] in GAINS for text in found)
                yield f"    {' '.join(found)}{' F' if gains else ''}"

    def _plan(self, design: Design, seed: int, seconds: float | None, delivered: Runner) -> dict[str, Any]:
        return {
            "version": VERSION, "scene": delivered.job.hash(), "goal": self.goal,
            "changed": {path: values.text for path, values in self.changed.items()},
            "varied": {path: values.text for path, values in self._scatter.varied.items()},
            "design": design.name, "runs": design.runs, "scatter_seed": design.seed, "seed": seed,
            "subject_to": self._scatter.claims, "for": seconds,
            "program": self._scatter.program and self._scatter.program.name, "host": self._scatter.host,
        }  # fmt: skip

    def _run(
        self, study: Study, engine: Engine, batch: Mapping[int, Mapping[str, Value]], scatter: Points, trials: int,
        progress: Progress | None,
    ) -> None:  # fmt: skip
        """Perform a batch of trials, and store the trials in the order of their numbers."""
        runs = {n: (trial, point) for n, (trial, point) in enumerate((t, p) for t in batch for p in scatter)}
        rows = _rows(engine, [(n, (*batch[trial].values(), *point)) for n, (trial, point) in runs.items()])
        for trial, values in batch.items():
            own = [row for row, (of, _) in zip(rows, runs.values(), strict=True) if of == trial]
            study.add(self._trial(values, own))
            if progress is not None and study.delivered is not None:
                progress(len(study.trials), trials, study.best, study.delivered)

    def _trial(self, values: Mapping[str, Value], rows: Sequence[Row]) -> Trial:
        results = [_result(row, self._sign) for row in rows]
        violations = {name: max(_violation(row, name) for row in rows) for name in self._scatter.claims}
        missing = [row for row in rows if row[GOAL] is None]
        if missing:
            violations["result"] = FAR
        notes = next((row["notes"] for row in missing if row["notes"]), "")
        return Trial(
            dict(values), self._sign * max(results), [self._sign * each for each in results], violations, notes
        )


def _rows(engine: Engine, tasks: Sequence[tuple[int, Sequence[Value]]]) -> list[Row]:
    return sorted(engine.map(tasks), key=lambda row: int(row["run"]))


def _result(row: Row, sign: float) -> float:
    """Return the result of a run as a number that the search minimises."""
    value = row[GOAL]
    if value is None:
        return FAR
    return max(sign * float(each) for each in (value if isinstance(value, list) else [value]))


def _violation(row: Row, name: str) -> float:
    """Return the amount by which a run violates a claim (a condition); 0 or less if the claim holds."""
    robustness = row[f"{name}.robustness"]
    if robustness is None:
        return FAR if row["ended"] in ("error", "limit", "killed") else 0.0
    found = max(-FAR, min(FAR, -float(robustness)))
    return min(found, 0.0) if row[name] else max(found, LEAST_VIOLATION)
