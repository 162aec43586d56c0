"""Sensitivity: the share of a result's variance that each varied path causes, as Sobol indices by SALib.

The first-order index is the share of a path alone.  The total index includes its interactions with other paths.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from axistwin.core.errors import UsageError, require
from axistwin.core.lazy import pa

DESIGN = "saltelli"  # Design that a sweep must have for Sobol indices.
_SEED = 1  # Random seed for the resampling that estimates confidence intervals.


def fractions(paths: int, runs: int, seed: int) -> list[list[float]]:
    """Return the sample points for a sensitivity analysis with Sobol indices (Saltelli design).

    Each of the `runs` * (`paths` + 2) points is a row of fractions from 0 to 1, one for each varied setting.  Raises
    UsageError if `runs` is not a power of 2, or if fewer than two settings are varied.
    """
    if runs & (runs - 1):
        power_of_2 = 1 << runs.bit_length()
        raise UsageError(
            f"invalid --runs {runs} with the design {DESIGN}: expected a power of 2, e.g. --runs {power_of_2}"
        )
    if paths < 2:
        raise UsageError(
            f"too few varied settings for the sweep design {DESIGN}: expected two or more, "
            "e.g. add --vary table.X.load.torque=0.05..0.4"
        )
    require("SALib", "sensitivity")
    from SALib.sample import sobol

    found = sobol.sample(_problem(list(map(str, range(paths)))), runs, calc_second_order=False, seed=seed)
    return [[min(max(float(x), 0.0), 1 - 2**-53) for x in row] for row in found]


def indices(table: "pa.Table", plan: Mapping[str, Any]) -> dict[str, Any]:
    """Return the Sobol indices by measure and path; None for a measure whose results are missing or all equal."""
    if plan["design"] != DESIGN or table.num_rows != plan["runs"] * (len(plan["varied"]) + 2):
        return {}
    return {name: _indices(list(plan["varied"]), table[name].to_pylist()) for name in plan["measures"]}


def _indices(paths: Sequence[str], given: Sequence[Any]) -> dict[str, dict[str, float]] | None:
    flat = [np.mean(value) if isinstance(value, list) else value for value in given]
    if None in flat or len(set(flat)) == 1:
        return None
    require("SALib", "sensitivity")
    from SALib.analyze import sobol

    found = sobol.analyze(_problem(paths), np.array(flat, float), calc_second_order=False, seed=_SEED)
    columns = {"first": "S1", "total": "ST", "first_95": "S1_conf", "total_95": "ST_conf"}
    return {path: {name: float(found[key][n]) for name, key in columns.items()} for n, path in enumerate(paths)}


def _problem(paths: Sequence[str]) -> dict[str, Any]:
    return {"num_vars": len(paths), "names": list(paths), "bounds": [[0.0, 1.0]] * len(paths)}
