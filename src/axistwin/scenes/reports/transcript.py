"""Report the messages, moves and level changes of a run, as text and as a dictionary for JSON."""

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any

from axistwin.bench import endpoints
from axistwin.bench.actions import level_name, voltage
from axistwin.bench.codec import Codec, unpadded
from axistwin.bench.events import FaultChanged, LevelChanged, VoltageChanged
from axistwin.core.units import to_seconds
from axistwin.plant.machine_units import MachineUnits
from axistwin.plant.servo_axis import ServoAxis
from axistwin.scenes.reports.refusals import RefusedLine
from axistwin.scenes.reports.run_record import AnyMove, Message, RunRecord
from axistwin.sim.frames import LineError

HIDDEN_LEVELS = ("dtr", "rts", "host.dtr", "host.rts")
"""Terminals that the text leaves out, because their levels change with each message."""

Item = Message | AnyMove | FaultChanged | LevelChanged | VoltageChanged


def text(run: RunRecord, refused: Sequence[RefusedLine] = ()) -> Iterator[str]:
    """Yield the transcript of a run: one line for each message, move, fault and level change, in order of time.

    `>` marks a message of the host, `<` a message of the controller, `!` an action of an operator or a refused line,
    and `=` a new level.
    """
    yield from (f"{'':14}  {refusal.words}" for refusal in refused if refusal.message is None)
    by_message: dict[int, list[RefusedLine]] = {}
    for refusal in refused:
        by_message.setdefault(id(refusal.message), []).append(refusal)
    several = endpoints.several(run.bench)
    codecs = _codecs(run)
    levels = [c for c in run.changes if c.pin not in HIDDEN_LEVELS and not (c.flashing and c.pin == "led")]
    told: list[Item] = [*run.said, *run.faults, *levels, *run.turned, *run.moves()]
    # Sort messages, faults, levels and moves by time; at equal times, a move comes last.
    for item in sorted(told, key=_time_ns):
        name = f"{item.controller}: " if several else ""
        yield f"{to_seconds(_time_ns(item)):14.6f}  {name}{_words(item, codecs[item.controller])}"
        yield from (f"{'':14}  {name}{refusal.words}" for refusal in by_message.get(id(item), ()))


def summary(run: RunRecord) -> Iterator[str]:
    """Yield a table of the axes that have moved, and a line for each axis that has lost pulses."""
    by_axis = _by_axis(run)
    units = " or ".join(sorted({move.unit for moves in by_axis.values() for move in moves}, reverse=True))
    machine_units = [moves[0].units for moves in by_axis.values()]
    rows = [["axis", "from", "to", units, "moving", "moves"]]
    if any(machine_units):
        rows[0].append(" or ".join(sorted({unit.of for unit in machine_units if unit is not None})))
    for name, moves in by_axis.items():
        total = sum(abs(move.target - move.origin) for move in moves)
        time_s = to_seconds(sum((move.end_ns or move.now_ns) - move.start_ns for move in moves))
        rows.append([name, str(moves[0].origin), str(moves[-1].target), str(total), f"{time_s:.6f} s", str(len(moves))])
        if any(machine_units):
            rows[-1].append(_way(moves[0].origin, moves[-1].target, moves[0].units))
    if len(rows) > 1:
        widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
        for row in rows:
            cells = [cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True)]
            yield "  ".join([row[0].ljust(widths[0]), *cells]).rstrip()
    yield from _lost_pulses(run)


def extremes(run: RunRecord) -> Iterator[str]:
    """Yield lines of text: the least and the greatest position of each axis, and each limit switch that has opened.

    The text also has the drive faults and the emergency stops, and the time of each opening.
    """
    for name, moves in _by_axis(run).items():
        places = [place for move in moves for place in (move.origin, move.target)]
        low, high, unit = min(places), max(places), moves[0].units
        told = f"  ({unit.shown(low)} to {unit.shown(high)} {unit.of})" if unit is not None else ""
        yield f"{name}: least position {low}, greatest {high} {moves[0].unit}{told}"
    for change in run.changes:
        made = run.bench[change.controller].product
        stops = (*(pin for pins in made.limit_pins.values() for pin in pins), *made.drive_fault_pins.values(), "estop")
        if change.pin in stops and change.level is not made.closed_level:
            where = f"{change.controller}.{change.pin}"
            yield f"{to_seconds(change.time_ns):.6f} s  {where} opened: {level_name(change.level)}"


def _way(origin: int, target: int, units: MachineUnits | None) -> str:
    return "" if units is None else f"{units.shown(origin)} → {units.shown(target)} {units.of}"


def as_dict(run: RunRecord, refused: Sequence[RefusedLine] = ()) -> dict[str, Any]:
    """Return the transcript of a run as a dictionary, for the option `--json`.

    Times are in ns, rates in pulses/s or counts/s.  An axis with a machine unit has its positions and rates in this
    unit, too.
    """
    codecs = _codecs(run)
    return {
        "said": [_said(message, codecs[message.controller]) for message in run.said],
        "moves": [_moved(move) for move in run.moves()],
        "changes": [
            {"time_ns": c.time_ns, "controller": c.controller, "pin": c.pin, "level": c.level, "driven": c.driven}
            for c in run.changes
        ],
        "voltages": [
            {"time_ns": t.time_ns, "controller": t.controller, "pin": t.pin, "volts": t.volts} for t in run.turned
        ],
        "faults": [
            {"time_ns": f.time_ns, "controller": f.controller, "act": f.act, "words": f.words} for f in run.faults
        ],
        "axes": [
            {"controller": c.name, "axis": name, "position": axis.position}
            | ({"commanded": axis.commanded} if isinstance(axis, ServoAxis) else {"pulses": axis.pulses})
            | ({"unit": axis.units.of, "position_in_unit": axis.units.value(axis.position)} if axis.units else {})
            for c in run.bench.controllers.values()
            for name, axis in c.axes.items()
        ],
        "refused": [_refused(refusal) for refusal in refused],
        "complete": run.complete,
        "end_ns": run.bench.now,
    }


def _codecs(run: RunRecord) -> dict[str, Codec]:
    bench = run.bench
    return {name: endpoints.codec_at(bench, name) for name in (*bench.controllers, *endpoints.names(bench))}


def _said(message: Message, codec: Codec) -> dict[str, Any]:
    return {
        "time_ns": message.time_ns, "end_ns": message.last_ns, "controller": message.controller,
        "by": "host" if message.by_host else "controller", "text": codec.show(bytes(message.data)),
        **({"words": words} if (words := codec.words(bytes(message.data), message.by_host)) else {}),
        "errors": _errors(message.errors),
    }  # fmt: skip


def _refused(refusal: RefusedLine) -> dict[str, Any]:
    error, message = refusal.error, refusal.message
    return {
        "time_ns": None if message is None else message.time_ns, "file": refusal.file, "line": error.line,
        "column": error.column, "code": error.code, "message": error.message,
    }  # fmt: skip


def _moved(move: AnyMove) -> dict[str, Any]:
    return {
        "start_ns": move.start_ns, "end_ns": move.end_ns, "controller": move.controller, "axis": move.axis,
        "from": move.origin, "to": move.target, "top_rate": float(move.top_rate),
        **({} if move.units is None else _in_unit(move, move.units)),
    }  # fmt: skip


def _in_unit(move: AnyMove, units: MachineUnits) -> dict[str, Any]:
    return {
        "unit": units.of, "from_in_unit": units.value(move.origin), "to_in_unit": units.value(move.target),
        "top_rate_in_unit": float(Fraction(move.top_rate) / units.per),
    }  # fmt: skip


def _time_ns(item: Item) -> int:
    return item.start_ns if isinstance(item, AnyMove) else item.time_ns


def _words(item: Item, codec: Codec) -> str:
    match item:
        case Message():
            errors = f"   ({', '.join(_errors(item.errors))})" if item.errors else ""
            return f"{'>' if item.by_host else '<'} {_message(item, codec)}{errors}"
        case LevelChanged():
            return f"{'!' if item.driven else '='} {item.pin} {level_name(item.level)}"
        case FaultChanged():
            return f"! {item.act} {item.words}"
        case VoltageChanged():
            return f"! {item.pin} {voltage(item.volts)}"
    # Round the speed of a servo move, because this speed is only an average over several samples.
    rate = f"{float(item.top_rate):g}" if item.unit == "pulses" else f"{item.top_rate:.0f}"
    units = item.units
    way = f" ({_way(item.origin, item.target, units)})" if units is not None else ""
    speed = f" ({float(Fraction(item.top_rate) / units.per):.4g} {units.of}/s)" if units is not None else ""
    path = f"  {item.axis} {item.origin} → {item.target}{way}, up to {rate} {item.unit}/s{speed}"
    if item.end_ns is None:
        return f"{path}, still moving at {to_seconds(item.now_ns):.6f}"
    return f"{path}, until {to_seconds(item.end_ns):.6f}"


def _message(item: Message, codec: Codec) -> str:
    data = bytes(item.data)
    words = codec.words(data, item.by_host)
    if not words:
        return codec.show(data)
    return f"{codec.show(data if item.by_host else unpadded(data))}   {words}"


def _errors(errors: LineError) -> list[str]:
    return [str(error.name).lower() for error in LineError if error in errors and error]


def _by_axis(run: RunRecord) -> dict[str, list[AnyMove]]:
    found: dict[str, list[AnyMove]] = {}
    for move in run.moves():
        several = len(run.bench.controllers) > 1
        found.setdefault(f"{move.controller}.{move.axis}" if several else move.axis, []).append(move)
    return found


def _lost_pulses(run: RunRecord) -> Iterator[str]:
    for controller in run.bench.controllers.values():
        for name, axis in controller.axes.items():
            if not isinstance(axis, ServoAxis) and axis.position != axis.pulses:
                yield f"{name} is at {axis.position}: {abs(axis.pulses - axis.position)} pulses were lost"
