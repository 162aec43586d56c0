"""`axistwin diff --positions`: what is printed of two machines' motion."""

import json

import click

from axistwin.core.units import S
from axistwin.records.traces.differences import Tolerance
from axistwin.records.traces.motion import Leg, Motion
from axistwin.scenes.reports.columns import columns

MOST = 20  # Largest number of moves that are printed.


def report(found: Motion, tolerance: Tolerance, files: tuple[str, str]) -> None:
    """Print the moves side by side, those that differ first, and the verdict."""
    legs = sorted(found.legs, key=lambda leg: not leg.differs(tolerance))
    titles = ("move", "axes", "begins at s", "takes s", "ends at", "apart")
    rows = [titles, *(_row(leg, leg.differs(tolerance)) for leg in legs[:MOST])]
    for line in columns(rows if found.by_move else [(row[1], *row[4:]) for row in rows]):
        click.echo(line)
    if len(legs) > MOST:
        click.echo(f"… and {len(legs) - MOST} more")
    click.echo(_verdict(found, tolerance, files))


def _verdict(found: Motion, tolerance: Tolerance, files: tuple[str, str]) -> str:
    one, other = map(len, found.moves)
    if one != other:
        return f"not the same motion: {files[0]} has {one} moves, {files[1]} {other}"
    worst = max(found.legs, key=lambda leg: leg.apart)
    unit = worst.axes[0].unit
    late = f"durations at most {max(leg.late_ns for leg in found.legs) / S:.6f} s, " * found.by_move
    hint = "; if the hosts pause differently, add --align move" * (not found.by_move and not same(found, tolerance))
    return (
        f"{'the same motion' if same(found, tolerance) else 'not the same motion'}: paths at most "
        f"{_position(worst, worst.apart)} {unit} apart, {late}"
        f"with {tolerance.value:g} {unit} and {tolerance.time_ns / S:g} s accepted{hint}"
    )


def report_json(found: Motion, tolerance: Tolerance) -> None:
    """Print one JSON object; times in nanoseconds, positions in the unit of the axis."""
    legs = [
        {
            "move": leg.move, "axes": [path.name for path in leg.axes], "unit": leg.axes[0].unit,
            "begin_ns": leg.begin_ns, "lasted_ns": leg.lasted_ns, "ends": leg.ends,
            "apart": leg.apart, "apart_ns": leg.apart_ns,
        }
        for leg in found.legs
    ]  # fmt: skip
    click.echo(json.dumps({"equal": same(found, tolerance), "moves": [*map(len, found.moves)], "legs": legs}))


def same(found: Motion, tolerance: Tolerance) -> bool:
    return not found.broken(tolerance) and len(found.moves[0]) == len(found.moves[1])


def _row(leg: Leg, differs: bool) -> tuple[str, ...]:
    begins, lasted = (f"{a / S:.6f} | {b / S:.6f}" for a, b in (leg.begin_ns, leg.lasted_ns))
    ends = " | ".join(_position(leg, end) for end in leg.ends)
    names = " | ".join(path.name for path in leg.axes)
    return str(leg.move), names, begins, lasted, ends, _position(leg, leg.apart) + " differs" * differs


def _position(leg: Leg, value: float) -> str:
    return f"{value:.{max(path.decimals for path in leg.axes)}f}"
