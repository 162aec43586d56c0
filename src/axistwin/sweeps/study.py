"""A study: the trials of a tuning, kept in an SQLite file of Optuna, which `optuna-dashboard` can show.

Optuna proposes the trials in batches.  A batch depends only on the seed and on earlier trials.  Therefore a resumed
study proposes the same trials, and the number of workers has no effect.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from pathlib import Path
from shutil import rmtree
from typing import Any

from axistwin.core.errors import AxistwinError, UsageError, require
from axistwin.core.storage import Lock, write_error
from axistwin.sweeps.journal import being_written, check_plan
from axistwin.sweeps.values import Value, Values

NAME = "axistwin"  # Name of the Optuna study in its database file.
BATCH = 4  # Number of trials that Optuna proposes at once.
PLAN, DELIVERED, RESULTS, NOTES, SUM = "plan", "delivered", "results", "notes", "sum"
MAGIC = b"SQLite format 3\0"


@dataclass(frozen=True)
class Trial:
    """A trial: values by path, score, result of each run, and `violations` by claim (above 0: the claim fails)."""

    values: dict[str, Value]
    score: float
    results: list[float]
    violations: dict[str, float] = field(default_factory=dict)
    notes: str = ""

    @property
    def feasible(self) -> bool:
        """True if all simulation runs with the tested settings meet all requirements."""
        return all(violation <= 0 for violation in self.violations.values())


class Study:
    """The trials in the file `out`.  Raises UsageError if `out` is another file or belongs to another tuning."""

    def __init__(self, out: Path, plan: Mapping[str, Any], changed: Mapping[str, Values], seed: int) -> None:
        self.out, self.plan, self._seed = out, json.loads(json.dumps(plan)), seed
        if out.suffix != ".db":
            raise UsageError(f"invalid file name {out.name!r}: expected a name that ends in .db")
        self._distributions = {path: _distribution(values) for path, values in changed.items()}
        self._stored = _open(out, create=True)
        with _storage(out, "write"):
            before = self._stored.user_attrs.get(PLAN)
            if before is None:
                self._stored.set_user_attr(PLAN, self.plan)
            else:
                check_plan(out, before, self.plan)
        self.trials = _trials(out, self._stored)

    @property
    def delivered(self) -> Trial | None:
        """Results with the scene's original settings, to compare; None until they have been stored."""
        return _delivered(self.out, self._stored)

    @delivered.setter
    def delivered(self, trial: Trial | None) -> None:
        with _storage(self.out, "write"):
            told = None if trial is None else {**asdict(trial), SUM: _sum(trial)}
            self._stored.set_user_attr(DELIVERED, told)

    @property
    def best(self) -> Trial | None:
        return best(self.trials, str(self.plan["goal"]))

    def add(self, trial: Trial) -> None:
        with _storage(self.out, "write"):
            self._stored.add_trial(self._frozen(trial))
        self.trials.append(trial)

    def batches(self, count: int) -> Iterator[dict[int, dict[str, Value]]]:
        """Yield batches of missing trials up to `count`: values by path, by number of the trial."""
        while len(self.trials) < count:
            first = len(self.trials) // BATCH * BATCH
            proposed = self._proposed(first)
            yield {n: proposed[n - first] for n in range(len(self.trials), min(first + BATCH, count))}

    def _proposed(self, first: int) -> list[dict[str, Value]]:
        optuna = _optuna()
        sampler = optuna.samplers.TPESampler(seed=(self._seed << 20) + first, multivariate=True)
        study = optuna.create_study(direction=_direction(str(self.plan["goal"])), sampler=sampler)
        study.add_trials([self._frozen(trial) for trial in self.trials[:first]])
        return [study.ask(self._distributions).params for _ in range(BATCH)]

    def _frozen(self, trial: Trial) -> Any:
        return _optuna().trial.create_trial(
            params=trial.values, distributions=self._distributions, value=trial.score, constraints=trial.violations,
            user_attrs={RESULTS: trial.results, NOTES: trial.notes, SUM: _sum(trial)},
        )  # fmt: skip


def best(trials: Sequence[Trial], goal: str) -> Trial | None:
    sign = -1 if _direction(goal) == "maximize" else 1
    return min((trial for trial in trials if trial.feasible), key=lambda trial: sign * trial.score, default=None)


def _direction(goal: str) -> str:
    return "maximize" if goal.startswith("maximise") else "minimize"


def is_study(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            return file.read(len(MAGIC)) == MAGIC
    except OSError:
        return False


def load(path: Path) -> tuple[dict[str, Any], Trial, list[Trial]]:
    """Read the results that the command `axistwin tune` has written to a file.

    Return the plan (the data of the tuning, e.g. its goal), the trial with the original values, and all trials.  Raises
    UsageError.
    """
    stored = _open(path, create=False)
    with _storage(path, "read"):
        plan = stored.user_attrs.get(PLAN)
    told = _delivered(path, stored)
    if told is None or plan is None:
        raise UsageError(f"{path} contains no trials: expected a file written by 'axistwin tune'")
    return plan, told, _trials(path, stored)


@contextmanager
def reserved(out: Path) -> Iterator[None]:
    """Exclude other processes from the study `out` within a `with` block.  Raises UsageError."""
    directory = out.with_name(f"{out.name}.lock")
    try:
        directory.mkdir(exist_ok=True)
        lock = Lock(directory, being_written(out))
    except OSError as error:
        raise write_error(f"cannot write the study to {out}", error) from None
    try:
        yield
    finally:
        lock.release()
        rmtree(directory, ignore_errors=True)


def _open(path: Path, *, create: bool) -> Any:
    optuna = _optuna()
    there = path.is_file() and path.stat().st_size > 0
    if not path.parent.is_dir() or (path.exists() and not path.is_file()) or (there and not is_study(path)):
        raise UsageError(f"cannot write the study to {path}: expected a new file or a file written by 'axistwin tune'")
    with _storage(path, "read"):
        if there:
            _check_pages(path)
        storage = optuna.storages.RDBStorage(f"sqlite:///{path}")
        if create:
            return optuna.create_study(storage=storage, study_name=NAME, load_if_exists=True)
        return optuna.load_study(storage=storage, study_name=NAME)


def _check_pages(path: Path) -> None:
    """Raise ValueError for a damaged database, which SQLite might otherwise read in part."""
    import sqlite3

    with closing(sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)) as database:
        (found,) = database.execute("PRAGMA integrity_check").fetchone()
    if found != "ok":
        raise ValueError(found)


@contextmanager
def _storage(path: Path, what: str) -> Iterator[None]:
    """Convert an exception of Optuna, SQLAlchemy or SQLite: to a UsageError, or in writing to an AxistwinError."""
    try:
        yield
    except AxistwinError:
        raise
    except Exception as error:  # noqa: BLE001  # of SQLAlchemy, which need not be there
        why = (str(error) or type(error).__name__).splitlines()[0]
        kind = UsageError if what == "read" else AxistwinError
        raise kind(
            f"cannot {what} the study in {path} ({why}): expected a whole file of 'axistwin tune', or a new one"
        ) from None


def _delivered(path: Path, stored: Any) -> Trial | None:
    with _storage(path, "read"):
        told = stored.user_attrs.get(DELIVERED)
        return None if told is None else _whole(Trial(**{key: told[key] for key in told if key != SUM}), told)


def _trials(path: Path, stored: Any) -> list[Trial]:
    with _storage(path, "read"):
        return [_trial(each) for each in stored.get_trials(deepcopy=False)]


def _trial(stored: Any) -> Trial:
    attributes = stored.user_attrs
    trial = Trial(
        dict(stored.params), stored.value, attributes[RESULTS], dict(stored.constraints), attributes.get(NOTES, "")
    )
    return _whole(trial, attributes)


def _whole(trial: Trial, attributes: Mapping[str, Any]) -> Trial:
    """Return the trial if its check sum is right.  Trials of earlier versions have none."""
    if attributes.get(SUM, _sum(trial)) != _sum(trial):
        raise ValueError("the check sum of a trial is wrong")
    return trial


def _sum(trial: Trial) -> str:
    return sha256(json.dumps(asdict(trial), sort_keys=True).encode()).hexdigest()[:16]


def _distribution(values: Values) -> Any:
    distributions = _optuna().distributions
    if values.interval is None:
        return distributions.CategoricalDistribution(list(values.listed))
    low, high, logarithmic = values.interval
    if isinstance(low, int) and isinstance(high, int):
        return distributions.IntDistribution(low, high, log=logarithmic)
    return distributions.FloatDistribution(float(low), float(high), log=logarithmic)


def _optuna() -> Any:
    require("optuna", "tune")
    import optuna

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    return optuna
