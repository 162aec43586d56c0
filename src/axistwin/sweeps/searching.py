"""Search for the worst run with the evolution strategy CMA-ES.

The search minimises the smallest margin (robustness) of all claims of a run.  A failed claim has a negative margin,
e.g. -2 if a value exceeds its limit by 2.  Margins are limited to ±`FAR`; a run without margins counts as `FAR`.

The search varies one fraction, 0 to 1, for each path; the fraction selects a value from the path's range.  The result
depends on the seed, not on the number of workers.  The search restarts at a random point if it has converged, or if all
runs of a generation have the same robustness.
"""

from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from typing import Any

from axistwin.bench.faults.table import Chance
from axistwin.core.errors import UsageError, require
from axistwin.sweeps.designs import at_fractions
from axistwin.sweeps.job import Row
from axistwin.sweeps.journal import Journal
from axistwin.sweeps.values import Values
from axistwin.sweeps.workers import Engine

FAR = 1e12  # Finite number that replaces an infinite robustness in a search.
SIGMA = 0.3  # Initial step size of the search, as a fraction of each range.


def check(varied: Mapping[str, Values], claims: Mapping[str, str]) -> None:
    """Check that the option `--search` can be used with a sweep.

    The option searches for the run with the smallest margin of a claim (a condition for each run).  Raises UsageError
    if the sweep has no claims or no varied settings, or if a value is not a number.
    """
    require("cmaes", "sweeps")
    if not claims:
        raise UsageError(
            "--search needs a claim (a condition for each run): add e.g. --claim 'safe: never table.X passes 12000'"
        )
    for path, values in varied.items():
        if not values.ordered:
            raise UsageError(f"--search cannot vary {path}={values.text}: expected numbers, e.g. 0.05..0.4")
    if not varied:
        raise UsageError("--search needs a value to vary: add --vary PATH=VALUES")


def known(results: Journal, claims: Mapping[str, str]) -> dict[int, Row]:
    """Return the results of the completed runs of an interrupted `axistwin sweep --search`.

    The keys are run numbers, and the values contain the robustness of each claim.
    """
    columns = ["run", *(f"{name}.robustness" for name in claims)]
    return {row["run"]: row for _, part in results.tables() for row in part.select(columns).to_pylist()}


def _smallest_margin(row: Row, claims: Sequence[str]) -> float:
    found = [row[f"{name}.robustness"] for name in claims]
    return min([max(-FAR, min(FAR, value)) for value in found if value is not None], default=FAR)


def search(
    engine: Engine, varied: Mapping[str, Values], claims: Sequence[str], count: int, seed: int,
    before: Mapping[int, Row],
) -> Iterator[Row]:  # fmt: skip
    """Search for the setting values with the worst results, and yield a row of results for each run.

    `count`: number of runs.  `before`: rows of an interrupted search, whose runs are not repeated.
    """
    chance = Chance(seed)
    strategy, asked = _start(len(varied), chance, first=True), 0
    while asked < count:
        size = min(strategy.population_size, count - asked)
        units = [strategy.ask() for _ in range(size)]
        values = at_fractions(varied, [[min(x, 1 - 2**-53) for x in unit[: len(varied)]] for unit in units])
        scores = {run: _smallest_margin(before[run], claims) for run in range(asked, asked + size) if run in before}
        tasks = [(asked + n, point) for n, point in enumerate(values) if asked + n not in before]
        for row in engine.map(tasks):
            scores[row["run"]] = _smallest_margin(row, claims)
            yield row
        told = [scores[asked + n] for n in range(size)]
        asked += size
        if size < strategy.population_size:
            return
        if len(set(told)) == 1 or not any(map(isfinite, told)):
            strategy = _start(len(varied), chance)
            continue
        strategy.tell(list(zip(units, told, strict=True)))
        if strategy.should_stop():
            strategy = _start(len(varied), chance)


def _start(dimensions: int, chance: Chance, *, first: bool = False) -> Any:
    import numpy as np
    from cmaes import CMA

    size = max(2, dimensions)  # The search method CMA-ES needs at least two dimensions.
    mean = np.array([0.5 if first else chance.unit() for _ in range(size)])
    return CMA(mean, SIGMA, bounds=np.array([[0.0, 1.0]] * size), seed=chance.below(1 << 31))
