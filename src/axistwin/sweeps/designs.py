"""Designs: the combinations of values that a sweep runs.

`grid` runs every combination.  `zip` runs the first values of all paths, then all second values.  `random`, `lhs`
(Latin hypercube) and `sobol` draw `runs` points from all values.  `saltelli` draws the points for Sobol
indices: `runs` times the number of paths plus 2.  A grid runs each combination `runs`
times; each of these runs draws its own values from distributions.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from math import prod
from typing import Any

from axistwin.bench.faults.table import Chance
from axistwin.core.errors import UsageError, require
from axistwin.sweeps import sensitivity
from axistwin.sweeps.values import MOST, Value, Values

Points = Sequence[tuple[Value, ...]]  # One tuple of values for each run; the values are in the order of the paths.
_SEEDS_APART = 0x9E37_79B9  # Difference between the random seeds of two neighbouring paths.


def points(design: str, varied: Mapping[str, Values], runs: int | None, seed: int) -> Points:
    """Return the setting values for all runs of a sweep.

    Each run has one value for each varied setting, e.g. for `table.X.load.torque`.  Raises UsageError if the design is
    not possible with the given values.
    """
    if design not in DESIGNS:
        raise UsageError(f"unknown sweep design {design!r}: expected one of {', '.join(DESIGNS)}")
    found = DESIGNS[design](varied, runs, seed)
    if len(found) > MOST:
        raise UsageError(f"the sweep has {len(found):,} runs: expected at most {MOST:,}")
    return found


def _grid(varied: Mapping[str, Values], runs: int | None, seed: int) -> Points:
    listed = _listed(varied)
    _check_drawn(varied, listed, runs)
    count = prod(len(values) for values in listed.values()) * (runs or 1)
    if count > MOST:
        raise UsageError(
            f"the grid of all combinations has {count:,} runs: expected at most {MOST:,}; "
            "use fewer values, or limit the number of runs, e.g. --design sobol --runs 1000"
        )
    combinations = (point for point in product(*listed.values()) for _ in range(runs or 1))
    return _with_draws(varied, listed, list(combinations), seed)


def _zip(varied: Mapping[str, Values], runs: int | None, seed: int) -> Points:
    listed = {path: values for path, values in _listed(varied).items() if len(values) > 1}
    lengths = {path: len(values) for path, values in listed.items()}
    if len(set(lengths.values())) > 1:
        lengths_by_path = ", ".join(f"{path} {length}" for path, length in lengths.items())
        raise UsageError(
            f"the settings have different numbers of values ({lengths_by_path}): "
            "expected the same number for each setting with --design zip"
        )
    length = max(lengths.values(), default=1)
    listed |= {path: list(each.listed) * length for path, each in varied.items() if len(each.listed) == 1}
    listed = {path: listed[path] for path in varied if path in listed}
    _check_drawn(varied, listed, runs)
    together = [point for point in zip(*listed.values(), strict=True) for _ in range(runs or 1)]
    return _with_draws(varied, listed, together if listed else [()] * (runs or 1), seed)


def _listed(varied: Mapping[str, Values]) -> dict[str, Sequence[Value]]:
    for path, values in varied.items():
        if not values.listed and ".." in values.text:
            raise UsageError(
                f"the range {path}={values.text} lacks the number of values: expected e.g. {values.text}:5 for 5 values"
            )
    return {path: values.listed for path, values in varied.items() if values.listed}


def _check_drawn(varied: Mapping[str, Values], listed: Mapping[str, Any], runs: int | None) -> None:
    drawn = [path for path in varied if path not in listed]
    if drawn and runs is None:
        path = drawn[0]
        raise UsageError(
            f"the setting {path} has random values ({varied[path].text}), but the number of runs is missing: "
            "add e.g. --runs 100"
        )


def _with_draws(
    varied: Mapping[str, Values], listed: Mapping[str, Any], combinations: Sequence[tuple[Value, ...]], seed: int
) -> Points:
    """Complete the points by random values for the paths with distributions; each path has its own random sequence."""
    columns: dict[str, Iterator[Value]] = {}
    for number, (path, values) in enumerate(varied.items()):
        if path not in listed:
            chance = Chance(seed + _SEEDS_APART * (number + 1))
            columns[path] = (values.at(chance.unit()) for _ in combinations)
    place = {path: number for number, path in enumerate(listed)}
    return [
        tuple(point[place[path]] if path in place else next(columns[path]) for path in varied) for point in combinations
    ]


def _random(varied: Mapping[str, Values], runs: int | None, seed: int) -> Points:
    chances = [Chance(seed + _SEEDS_APART * (number + 1)) for number in range(len(varied))]
    return at_fractions(varied, ([chance.unit() for chance in chances] for _ in range(_count(runs))))


def _lhs(varied: Mapping[str, Values], runs: int | None, seed: int) -> Points:
    return at_fractions(varied, _qmc().LatinHypercube(len(varied), rng=seed).random(_count(runs)).tolist())


def _sobol(varied: Mapping[str, Values], runs: int | None, seed: int) -> Points:
    count = _count(runs)
    # The SciPy function `random_base2` generates 2**power points; choose the power for at least `count` points.
    power = max(count - 1, 1).bit_length()
    return at_fractions(varied, _qmc().Sobol(len(varied), rng=seed).random_base2(power)[:count].tolist())


def _saltelli(varied: Mapping[str, Values], runs: int | None, seed: int) -> Points:
    return at_fractions(varied, sensitivity.fractions(len(varied), _count(runs), seed))


def at_fractions(varied: Mapping[str, Values], unit: Iterator[list[float]] | Sequence[list[float]]) -> Points:
    """Convert each row of fractions to a point; a fraction from 0 to 1 selects a value of its path's distribution."""
    return [tuple(values.at(fraction) for values, fraction in zip(varied.values(), row, strict=True)) for row in unit]


def _count(runs: int | None) -> int:
    if runs is None:
        raise UsageError("the number of runs is missing: expected e.g. --runs 100")
    return runs


def _qmc() -> Any:
    require("scipy", "sweeps")
    from scipy.stats import qmc

    return qmc


DESIGNS: dict[str, Callable[[Mapping[str, Values], int | None, int], Points]] = {
    "grid": _grid, "zip": _zip, "random": _random, "lhs": _lhs, "sobol": _sobol, "saltelli": _saltelli,
}  # fmt: skip
