r"""Triggers: events that start a fault, as sentences.

    table.X passes 1000         an axis reaches or passes a position, at the exact pulse or sample
    table.X passes 12.5 mm      the same in the unit of the axis
    table.X passes 1000 up      the same in the positive direction only; in the negative direction: down
    table.output1 rises         an edge on a pin; also: falls, changes
    table hears X1000           the device has received these characters; an 1810 or 1811, this command in hex
    table says U\r              the host has received these characters
    motor raises Be             the device sets a fault flag; the flags have the names of the manual
    motor runs 12               line 12 of the program begins, or step 12 of the sequence; the first is 1
    board runs 3:2              command 2 of sequence 3 begins
    cable begins                the fault "cable" begins; also: ends

The controller's name may be left out if only one is possible.
"""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from axistwin.bench.faults import places
from axistwin.bench.faults.places import Find, Machine, Spot, World
from axistwin.controllers.product import Listing
from axistwin.core.errors import UsageError
from axistwin.core.numbers import whole
from axistwin.plant import machine_units
from axistwin.plant.axes import Axis
from axistwin.sim.frames import LineError
from axistwin.sim.signal import Signal

Unsubscribe = Callable[[], object]
Arm = Callable[[Callable[[], None]], Unsubscribe]  # Subscribes a function to an event; returns an unsubscribe function.

_SENTENCE = re.compile(r"(?P<who>\S+) (?P<verb>[a-z]+)(?: (?P<what>.*))?")
_POSITION = re.compile(r"(?P<position>-?[0-9.]+(?: ?(?!(?:up|down)\b)[^\W\d_]+| ?°)?)(?: (?P<way>up|down))?")
_LINE = re.compile(r"(?:(?P<program>\d+):)?(?P<line>\d+)", re.ASCII)
_ESCAPE = re.compile(r"\\(?:x(?P<hex>[0-9A-Fa-f]{2})|(?P<letter>[rn\\]))")
_LETTERS = {"r": "\r", "n": "\n", "\\": "\\"}


def other_fault(text: str | None) -> str | None:
    """Return the fault that an event mentions, e.g. "jam" for "jam begins"; None if it mentions none."""
    found = _SENTENCE.fullmatch((text or "").strip())
    return found["who"] if found is not None and VERBS.get(found["verb"]) is _other_fault else None


def read(text: str, world: World, here: str = "") -> Arm:
    """Return the trigger for an event such as "X passes 1000".  Raises UsageError for an invalid event."""
    found = _SENTENCE.fullmatch(text.strip())
    if found is None or found["verb"] not in VERBS:
        axis, verbs = next(iter(places.names(places.axes(world), here)), "X"), ", ".join(VERBS)
        raise UsageError(f"invalid event when={text!r}: expected e.g. '{axis} passes 1000'; possible verbs are {verbs}")
    return VERBS[found["verb"]](_Wish(world, here, found["who"], found["verb"], found["what"] or ""))


@dataclass(frozen=True)
class _Wish:
    """The words of an event: in "X passes 1000", `who` is X, `verb` is passes, `what` is 1000."""

    world: World
    here: str
    who: str
    verb: str
    what: str

    @property
    def text(self) -> str:
        return f"{self.who} {self.verb} {self.what}".strip()

    def spot(self, found: Iterable[tuple[str, Find]], thing: str) -> Spot:
        return places.find(places.names(found, self.here), self.who, thing)

    def wrong(self, example: str) -> UsageError:
        return UsageError(f"invalid event when={self.text!r}: expected e.g. '{example}'")


def _passes(wish: _Wish) -> Arm:
    axis = wish.spot(places.axes(wish.world), "axis").axis
    assert axis is not None, "an axis was found"
    found = _POSITION.fullmatch(wish.what)
    if found is None:
        raise wish.wrong(example=f"{wish.who} passes 1000")
    ways = {"up": (1,), "down": (-1,), None: (1, -1)}[found["way"]]
    try:
        position = machine_units.position(found["position"], axis.units)
    except UsageError as what_was_expected:
        raise UsageError(f"invalid axis position in the event when={wish.text!r}: {what_was_expected}") from None
    return lambda happens: _Passing(axis, position, ways, happens).end


class _Passing:
    def __init__(self, axis: Axis, position: int, ways: tuple[int, ...], happens: Callable[[], None]) -> None:
        self._axis, self._position, self._ways, self._happens = axis, position, ways, happens
        self._side = self._find_side()
        self.end = axis.subscribe_edges([position, position + 1], self._check)

    def _find_side(self) -> int:
        at = self._axis.position
        return (at > self._position) - (at < self._position)

    def _check(self) -> None:
        before, self._side = self._side, self._find_side()
        if before and self._side != before and -before in self._ways:
            self._happens()


def _edge(wish: _Wish) -> Arm:
    pin = wish.spot(places.pins(wish.world), "pin").pin
    assert pin is not None, "a terminal was found"
    if wish.what:
        raise wish.wrong(example=f"{wish.who} {wish.verb}")
    wanted = {"rises": (True,), "falls": (False,), "changes": (True, False)}[wish.verb]
    return lambda happens: pin.subscribe_edges(lambda pin: happens() if pin.level in wanted else None)


def _receives(wish: _Wish) -> Arm:
    """Return the trigger for "hears" (the device has received characters) or "says" (the host has received them)."""
    hears, port = wish.verb == "hears", _port(wish)
    if port is None:
        bus = wish.spot(places.controllers(wish.world), "controller").machine.bus
        subscribe, pattern = bus.subscribe_sent if hears else bus.subscribe_received, _hexadecimal(wish)
        return lambda happens: subscribe(lambda message: happens() if message.startswith(pattern) else None)
    line = port.to_device if hears else port.from_device
    return _characters(line.receiver.received, _written(wish))


def _port(wish: _Wish) -> Any:
    """Return the host's end of the serial line; None for a controller on a bus."""
    machine = wish.world.controllers.get(wish.who or wish.here)
    if machine is not None and machine.product.attend is not None:
        return None
    return wish.spot(places.lines(wish.world), "serial line").port


def _characters(received: Signal[int, LineError], pattern: bytes) -> Arm:
    def arm(happens: Callable[[], None]) -> Unsubscribe:
        latest = bytearray()

        def take(byte: int, _: LineError) -> None:
            latest.append(byte)
            del latest[: -len(pattern)]
            if latest == pattern:
                happens()

        return received.subscribe(take)

    return arm


def _written(wish: _Wish) -> bytes:
    def meant(escape: re.Match[str]) -> str:
        return chr(int(escape["hex"], 16)) if escape["hex"] else _LETTERS[escape["letter"]]

    try:
        pattern = _ESCAPE.sub(meant, wish.what).encode("latin-1")
    except UnicodeEncodeError:
        pattern = b""
    if not pattern:
        raise wish.wrong(example=rf"{wish.who} {wish.verb} X1000\r")
    return pattern


def _hexadecimal(wish: _Wish) -> bytes:
    try:
        pattern = bytes.fromhex(wish.what)
    except ValueError:
        pattern = b""
    if not pattern:
        raise wish.wrong(example=f"{wish.who} {wish.verb} 33 00")
    return pattern


def _raises(wish: _Wish) -> Arm:
    machine = wish.spot(places.controllers(wish.world), "controller").machine
    alarms = machine.alarms
    if alarms is None:
        raise UsageError(f"{machine.name} has no fault flags: expected another controller, e.g. an IF1")
    if wish.what and wish.what not in alarms.names:
        flag, known_flags = wish.what, ", ".join(alarms.names)
        raise UsageError(f"{machine.name} has no fault flag {flag!r}: expected one of {known_flags}")
    return lambda happens: alarms.subscribe(lambda name: happens() if wish.what in ("", name) else None)


def _runs(wish: _Wish) -> Arm:
    machine = wish.spot(places.controllers(wish.world), "controller").machine
    names = machine.product.programs
    if not names:
        raise UsageError(f"{machine.name} cannot store programs: expected a controller that stores programs")
    found = _LINE.fullmatch(wish.what)
    if found is None or (len(names) > 1) != bool(found["program"]):
        raise wish.wrong(example=f"{machine.name} runs {'3:2' if len(names) > 1 else '12'}")
    name, line = _program(machine, found["program"]), whole(found["line"])
    _check_line(machine, name, line)
    return lambda happens: machine.subscribe_lines(lambda program, index: happens(), (name, line - 1))


def _program(machine: Machine, number: str | None) -> str:
    names = machine.product.programs
    found = next((name for name in names if number is None or name.split()[-1] == number), None)
    if found is None:
        raise UsageError(f"{machine.name} has no program {number}: expected {names[0]} to {names[-1]}")
    return found


def _check_line(machine: Machine, name: str, line: int) -> None:
    """Raise UsageError for a line at which no fault can begin, e.g. a label; one not stored yet is valid."""
    most = machine.product.most_lines
    if line < 1 or (most is not None and line > most):
        lines = "1 or more" if most is None else f"1 to {most}"
        raise UsageError(f"invalid line number {line} in a program of {machine.name}: expected {lines}")
    listing = machine.programs.get(name)
    if listing is not None and line - 1 in listing.silent:
        text, valid_line = listing.lines[line - 1], _timed_line(listing, line)
        raise UsageError(
            f"program line {line} ({text}) of {machine.name} contains nothing to execute, "
            f"so no fault can begin at this line: expected {valid_line}"
        )


def _timed_line(listing: Listing, after: int) -> str:
    """Return the next line that can trigger a fault, e.g. "line 4 (a=a+1)", not a label; or "another line"."""
    number = next((n for n in range(after, len(listing.lines)) if n not in listing.silent), None)
    return "another line" if number is None else f"line {number + 1} ({listing.lines[number]})"


def _other_fault(wish: _Wish) -> Arm:
    faults = dict.fromkeys((*wish.world.faults.names, *wish.world.faults.announced))
    if wish.who not in faults:
        fault, known_faults = wish.who, ", ".join(faults) or "none"
        raise UsageError(f"unknown fault {fault!r}: known faults are {known_faults}")
    return lambda happens: wish.world.faults.subscribe(
        lambda fault, what: happens() if (fault.name, what) == (wish.who, wish.verb) else None
    )


VERBS: dict[str, Callable[[_Wish], Arm]] = {
    "passes": _passes, "rises": _edge, "falls": _edge, "changes": _edge, "hears": _receives, "says": _receives,
    "raises": _raises, "runs": _runs, "begins": _other_fault, "ends": _other_fault,
}  # fmt: skip
