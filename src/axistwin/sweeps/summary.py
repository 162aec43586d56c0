"""The summary of a sweep: each measure's range, each claim's failures, and paths without an effect."""

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from axistwin.core.lazy import pa
from axistwin.sweeps import sensitivity
from axistwin.sweeps.journal import digest

WORST = 3  # Number of runs that are listed for each claim, worst first.


def summary(table: "pa.Table", plan: Mapping[str, Any]) -> dict[str, Any]:
    """Return the summary of a sweep as data for JSON.  An infinite robustness becomes None."""
    rows = table.to_pylist()
    return {
        "runs": len(rows), "ended": dict(Counter(row["ended"] for row in rows)),
        "measures": {name: _measure(rows, name) for name in plan["measures"]},
        "claims": {name: _claim(rows, name, list(plan["varied"])) for name in plan["claims"]},
        "sensitivity": sensitivity.indices(table, plan), "without_effect": without_effect(rows, plan),
        "hash": digest(table),
    }  # fmt: skip


def _measure(rows: Sequence[Mapping[str, Any]], name: str) -> dict[str, Any]:
    values = [row[name] for row in rows if row[name] is not None]
    flat = np.array([x for value in values for x in (value if isinstance(value, list) else [value])], float)
    found: dict[str, Any] = {"count": len(values), "missing": len(rows) - len(values)}
    if len(flat):
        middle = np.percentile(flat, (5, 50, 95)).tolist()
        found |= {"min": float(flat.min()), "p5": middle[0], "median": middle[1], "p95": middle[2]}
        found |= {"max": float(flat.max()), "mean": float(flat.mean())}
    return found


def _claim(rows: Sequence[Mapping[str, Any]], name: str, paths: Sequence[str]) -> dict[str, Any]:
    answered = [row for row in rows if row[name] is not None]
    listed = [
        {
            "run": row["run"], "robustness": _finite(row[f"{name}.robustness"]), "holds": row[name],
            "at_s": row[f"{name}.at_s"], "values": {path: row[path] for path in paths},
        }
        for row in sorted(answered, key=lambda row: (row[f"{name}.robustness"], row["run"]))[:WORST]
    ]  # fmt: skip
    failing = sum(row[name] is False for row in answered)
    return {"holds": len(answered) - failing, "fails": failing, "missing": len(rows) - len(answered), "worst": listed}


def _finite(value: float) -> float | None:
    return value if abs(value) < float("inf") else None


def without_effect(rows: Sequence[Mapping[str, Any]], plan: Mapping[str, Any]) -> list[str]:
    """Return the settings that were varied in a sweep without any effect on the results.

    Only runs that differ in this setting alone are compared.  Without such runs, the results of all runs must be equal.
    """
    paths = list(plan["varied"])
    names = [*plan["measures"], *(f"{name}.robustness" for name in plan["claims"])]
    if not names:
        return []
    return [path for path in paths if _is_without_effect(rows, path, [p for p in paths if p != path], names)]


def _is_without_effect(
    rows: Sequence[Mapping[str, Any]], path: str, others: Sequence[str], names: Sequence[str]
) -> bool:
    results: defaultdict[str, set[str]] = defaultdict(set)
    values: defaultdict[str, set[str]] = defaultdict(set)
    for row in rows:
        group = repr([row[other] for other in others])
        results[group].add(repr([row[name] for name in names]))
        values[group].add(repr(row[path]))
    compared = [group for group in values if len(values[group]) > 1]
    if not compared:
        return len({repr(row[path]) for row in rows}) > 1 and len(set().union(*results.values())) == 1
    return all(len(results[group]) == 1 for group in compared)


def lines(found: Mapping[str, Any]) -> Iterator[str]:
    ended = ", ".join(f"{count} {name}" for name, count in found["ended"].items())
    yield f"{found['runs']} runs (ended: {ended or 'none'}), hash {found['hash']}"
    if found["measures"]:
        yield ""
        yield _columns("measure", "min", "5 %", "median", "95 %", "max", "missing")
        for name, one in found["measures"].items():
            shown = [_number(one.get(key)) for key in ("min", "p5", "median", "p95", "max")]
            yield _columns(name, *shown, str(one["missing"]))
    if found["claims"]:
        yield ""
        yield f"{_columns('claim', 'holds', 'fails', 'missing')}   least robustness, run"
        for name, one in found["claims"].items():
            worst = next((f"{_number(w['robustness'])}, {w['run']}" for w in one["worst"]), "")
            counts = (str(one[key]) for key in ("holds", "fails", "missing"))
            yield f"{_columns(name, *counts)}   {worst}"
    for name, paths in found["sensitivity"].items():
        yield ""
        yield f"{_columns(f'share of {name}', 'alone', '± 95 %', 'total', '± 95 %')}"
        for path, one in (paths or {}).items():
            yield _columns(path, *(f"{one[key]:.3f}" for key in ("first", "first_95", "total", "total_95")))
        if paths is None:
            yield "results are missing or all equal"


def _columns(first: str, *rest: str) -> str:
    return f"{first:<20}" + "".join(f"{word:>13}" for word in rest)


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.6g}"
