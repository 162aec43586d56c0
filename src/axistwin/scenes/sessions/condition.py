"""The state of a machine in words, with what to do next: the same for the panel, the playground and the terminal.

What a controller can tell comes from `scenes/reasons`.  The first kind that applies wins.
"""

import re
from collections.abc import Iterable, Iterator
from enum import StrEnum
from typing import NamedTuple

from axistwin.bench import Bench, Controller, Do, Say
from axistwin.bench.controller import on_a_bus
from axistwin.core.errors import PlacedError
from axistwin.core.units import figures, to_seconds
from axistwin.plant.axes import Axis
from axistwin.plant.servo_axis import ServoAxis
from axistwin.scenes.reasons.families import KNOWN, reasons_of
from axistwin.scenes.reasons.reasons import EMERGENCY_STOPS, Cause, Reason, spoken
from axistwin.scenes.reasons.remedies import ByHand
from axistwin.scenes.sessions.session import Session


class Tone(StrEnum):
    """Colour of a state: grey is normal, red is stopped, amber is refused or late, blue asks for an act."""

    GREY = "grey"
    RED = "red"
    AMBER = "amber"
    BLUE = "blue"


class Kind(StrEnum):
    """Kind of a state, in the order in which the first that applies wins."""

    GOING = "going"
    REPLAY = "replay"
    OFF = "off"
    STOPPED = "stopped"  # An emergency stop is pressed.
    RELEASED = "released"  # It is released, and its effect has not been cleared.
    FAULT = "fault"
    PAUSED = "paused"
    INPUT = "input"
    RUNNING = "running"
    COMMAND = "command"
    ENDED = "ended"


ORDER = list(Kind)


class Button(NamedTuple):
    """A button that a state offers; `perform` in `sessions/buttons.py` does what it says."""

    label: str
    does: str  # "do", "go", "initialise", "lessons", "live", "restart", "run" or "stop".
    acts: tuple[Do | Say, ...] = ()
    at_s: float = 0.0  # The time to go to.
    filled: bool = False  # True for the step that the page asks for; at most one is.


class Condition(NamedTuple):
    """The state of a session or a controller."""

    kind: Kind
    words: str
    next: str = ""  # What the machine does, or what to do.
    buttons: tuple[Button, ...] = ()
    tone: Tone = Tone.GREY
    controller: str = ""
    pin: str = ""  # The input that the user must change, as "controller.pin".


LESSONS = Button("Lessons", "lessons")
RUN = Button("Run", "run", filled=True)
MOST_SENT = 24  # Largest number of characters of a line that a button repeats; the text beside it shows it anyhow.
_COMMAND = re.compile(r"(?:.*: )?type  (\S+(?: \S+)*)(?:  (?:\(|and then  ).*)?")  # Of several, the first.


def condition(session: Session, *, running: bool | None = None) -> Condition:
    """Return the state of a session; with several controllers, it begins with the name of the one that it is about.

    `running`: True while virtual time passes, if something else than the session advances it.
    """
    running = session.running if running is None else running
    if session.busy:
        return Condition(Kind.GOING, f"Going to {session.heading}", buttons=(Button("Stop", "stop"),))
    if session.repeating:
        live = Button("Live from here", "live")
        asks = "Live from here ends the replay, and the machine can be operated"
        return Condition(Kind.REPLAY, f"Replay at {session.seconds:.1f} s", asks, (live,), Tone.BLUE)
    states = [condition_of(session, name) for name in session.bench.controllers]
    found = min(states, key=lambda each: ORDER.index(each.kind))
    if len(states) > 1 and found.kind is not Kind.RUNNING:
        found = found._replace(words=f"{found.controller}: {found.words[0].lower()}{found.words[1:]}")
    if ORDER.index(found.kind) < ORDER.index(Kind.PAUSED):
        return found if running or found.kind is Kind.OFF else found._replace(words=f"{found.words} (paused)")
    if not running:
        return _paused(session, found)
    if session.finished and found.kind in (Kind.COMMAND, Kind.ENDED):
        return _ended(found)
    return found


def condition_of(session: Session, name: str) -> Condition:
    """Return the state of one controller, without regard to pauses and replays."""
    controller = session.bench[name]
    found = reasons_of(controller, ByHand(session.operator, name))
    reasons = [*_buttons_pressed(session, name), *found.reasons()]
    moving = [axis for axis, shown in controller.axes.items() if shown.moving and (shown.velocity or not reasons)]
    first = {cause: next((each for each in reasons if each.cause is cause), None) for cause in Cause}
    if reason := first[Cause.OFF]:
        return _off(session, name)
    if reason := first[Cause.STOP]:
        return _stopped(session, name, Kind.STOPPED, "Stopped: emergency stop pressed", reason)
    if reason := first[Cause.AFTER_STOP]:
        return _stopped(session, name, Kind.RELEASED, "Stopped after an emergency stop", reason)
    if not moving and (reason := first[Cause.FAULT]):
        ran = found.moved or any(each.ended_by for each in controller.programs.values())
        before = "Stopped" if ran else "Cannot move"
        return _stopped(session, name, Kind.FAULT, f"{before}: {reason.short or reason.text}", reason)
    if not moving and (reason := first[Cause.INPUT]) and not _comes(session.bench, controller, reason.pin):
        return _waiting(session, name, reason, _displaced(controller) * found.begins)
    if moving or _works(session.bench, name):
        does = _motion(controller, moving) or _plan(session.bench, name)
        return Condition(Kind.RUNNING, "Running", does, controller=name)
    if reason := first[Cause.ENDED]:
        cycle = _power(name, "Power off and on", "off", "on")
        asks = _sentence(_steps(session, name, reason)) + _displaced(controller) * bool(reason.waits)
        return Condition(Kind.ENDED, "The stored sequence has ended", asks, (cycle,), controller=name)
    if (reason := first[Cause.START]) and reason.remedy == "wait":
        return Condition(Kind.RUNNING, "Starting", _plain(reason.text), controller=name)
    return _commanded(session, name, first[Cause.START] or first[Cause.REFUSED] or first[Cause.COMMAND])


# States of the session


def _paused(session: Session, found: Condition) -> Condition:
    words = "Paused at 0 s until a browser or a host connects" if session.waiting else "Paused"
    words += f": {session.halted_by}" * bool(session.halted_by)
    does = found.next
    if not session.waiting:
        does = f"Press Run. {does}" if does else "Press Run"
    return found._replace(kind=Kind.PAUSED, words=words, next=does, buttons=(RUN,), tone=Tone.GREY, pin="")


def _ended(found: Condition) -> Condition:
    does = f"{found.next[:1].lower()}{found.next[1:]}"
    asked = f": {does}" if any(each.filled for each in found.buttons) else ""
    hand = does if found.kind is Kind.ENDED else f"operate by hand{asked}"
    buttons = (Button("Restart", "restart"), *(each for each in found.buttons if each.does == "do"))
    return Condition(Kind.ENDED, "The scene has ended", f"Restart, or {hand}", buttons)


# States of a controller


def _off(session: Session, name: str) -> Condition:
    buttons, asks = [_power(name, "Power on", "on", filled=True)], "Switch the power on"
    if planned := next_act(session.bench):
        buttons.append(Button("Go there", "go", at_s=to_seconds(planned[0])))
        asks = _plan(session.bench, name)
    return Condition(Kind.OFF, "Power off", asks, tuple(buttons), controller=name)


def _stopped(session: Session, name: str, kind: Kind, words: str, reason: Reason) -> Condition:
    buttons = []
    if reason.pin and (value := _released(session, name, reason)):
        label = known[0] if (known := operated(session, name, reason.pin)) else spaced(reason.pin)
        buttons.append(Button(f"Release {label}", "do", (Do(reason.pin, value, controller=name),), filled=True))
    if reason.cycle:
        if kind is not Kind.STOPPED:
            buttons.append(_power(name, "Power off and on", "off", "on", filled=True))
    elif command := _send(session.bench[name], reason):
        buttons.append(command)
    choice = ": " in reason.text and reason.remedy.startswith("type  ")  # The text tells what else would help.
    asks = _sentence(_steps(session, name, reason)) or _plain(str(reason) if choice else reason.remedy)
    asks += _displaced(session.bench[name]) * bool(reason.cycle and reason.waits)
    pin = f"{name}.{reason.pin}" if reason.pin else ""
    return Condition(kind, words, asks, tuple(buttons), Tone.RED, name, pin)


def _waiting(session: Session, name: str, reason: Reason, displaced: str) -> Condition:
    step = re.search(r"step \d+", reason.text)
    known = operated(session, name, reason.pin)
    where = f" ({known[0]})" if known else f" {reason.level}" + (f" ({step[0]})" if step else "")
    words = f"Waiting for {spaced(reason.pin)}{where}"
    by_hand = not session.bench[name].pins[reason.pin].wired
    act = Do(reason.pin, reason.level, controller=name)
    buttons = () if known or not by_hand else (Button(f"Set {reason.pin} {reason.level}", "do", (act,), filled=True),)
    asks = _plain(reason.remedy) + displaced
    return Condition(Kind.INPUT, words, asks, buttons, Tone.BLUE, name, f"{name}.{reason.pin}" if by_hand else "")


def _commanded(session: Session, name: str, reason: Reason | None) -> Condition:
    controller = session.bench[name]
    known = controller.product.family in KNOWN
    title, buttons, words = controller.product.indefinite.partition(" ")[2], [LESSONS] * known, "Waiting for a command"
    if reason is not None and reason.cause is Cause.START:
        asks = f"The {title} is on. Press Initialise, or begin with the lessons"
        words += f": {reason.short}" * bool(reason.short)
        buttons = [Button("Initialise", "initialise", filled=True), *buttons]
    elif reason is not None:
        asks = _plain(str(reason))
        buttons = [*((found,) if (found := _send(controller, reason)) else ()), *buttons]
    elif (step := reasons_of(controller, ByHand(session.operator, name)).step()) is not None:
        asks = f"Type {step[0]}: {step[1]}"
        buttons = [*((found,) if (found := _send(controller, Reason("", f"type  {step[0]}"))) else ()), *buttons]
    else:
        asks = "Type a command, or let a host send one"
    tone = Tone.GREY if session.client(name) else Tone.BLUE
    if reason is not None and reason.cause is Cause.REFUSED:
        tone, words = Tone.AMBER, "A message was refused"
        asks = _plain(reason.remedy)
    return Condition(Kind.COMMAND, words, asks, tuple(buttons), tone, name)


# Facts


def _buttons_pressed(session: Session, name: str) -> Iterator[Reason]:
    """Yield the latching stop buttons of the operator panel that are pressed, at any input of the controller."""
    controller = session.bench[name]
    for table in session.operator.button:
        who, _, pin = table.pin.rpartition(".")
        pressed = table.pressed == "high"
        stops = table.latching and "stop" in table.name.lower() and pin not in EMERGENCY_STOPS
        if who == name and stops and controller.pins[pin].level is pressed:
            yield Reason(f"{table.name} is pressed", "", Cause.STOP, pin, "low" if pressed else "high")


def _comes(bench: Bench, controller: Controller, name: str) -> bool:
    """True if the machine itself will change an input: it is wired, and an event is due."""
    pin = controller.pins[name]
    return pin.wired and not pin.driven and not pin.held and not bench.clock.quiet


def _works(bench: Bench, name: str) -> bool:
    controller = bench[name]
    hosted = _hosted(bench, name)
    runs = any(listing.running is not None for listing in controller.programs.values())
    return hosted or runs or controller.busy or next_act(bench) is not None


def _hosted(bench: Bench, name: str) -> bool:
    sender, attendant = bench.senders.get(name), bench.attendants.get(name)
    there = [*bench.hosts.get(name, ()), *((sender,) if sender is not None else ())]
    return any(each.is_alive for each in there) or (attendant is not None and attendant.pending > 0)


def next_act(bench: Bench) -> tuple[int, str] | None:
    """Return time and text of the scene's next act."""
    return min(((at, what) for at, what in bench.planned if at > bench.now), default=None)


def _released(session: Session, name: str, reason: Reason) -> str:
    """Return the value with which a user releases an input; "" if a machine or a fault holds it."""
    pin = session.bench[name].pins[reason.pin]
    if pin.held or not pin.driven:
        return ""
    return "release" if pin.undriven is (reason.level == "high") else reason.level


def operated(session: Session, name: str, pin: str) -> list[str]:
    """Return the names of a terminal on the operator panel: those of its buttons, then those of its lamps."""
    panel, of = session.operator, f"{name}.{pin}"
    selected = (f"{each.name}: {word}" for each in panel.selector for word, at in each.positions.items() if at == of)
    buttons, lamps = [each for each in panel.button if each.pin == of], [each for each in panel.lamp if each.pin == of]
    return [*(each.name for each in buttons), *selected, *(each.name for each in lamps)]


def spaced(pin: str) -> str:
    """Return the name of a terminal as words, e.g. `input 2` and `limit plus`."""
    return re.sub(r"(?<=[a-z])(?=\d)", " ", pin).replace("_", " ")


# What to do


def _steps(session: Session, name: str, reason: Reason) -> Iterator[str]:
    """Yield the steps out of a stop, if a person at the machine does them all."""
    if reason.cause is Cause.STOP:
        yield "release it"
    if reason.cycle:
        yield "switch the power off and on"
    remedies = ByHand(session.operator, name)
    yield from (remedies.drive(pin, level) for pin, level in reason.waits)


def _sentence(steps: Iterable[str]) -> str:
    *before, last = list(steps) or [""]
    said = f"{', '.join(before)}, then {last}" if before else last
    return f"{said[:1].upper()}{said[1:]}"


def _plain(remedy: str) -> str:
    """Return a remedy as a sentence: two blanks mark a line to type, which pages need not know."""
    said = re.sub(r"(?<!\))  and then  (?=\S)", ", then type ", remedy)
    said = re.sub(r" {2,}", " ", said).replace(" , ", ", ")
    return f"{said[:1].upper()}{said[1:]}"


def _send(controller: Controller, reason: Reason) -> Button | None:
    """Return the button that sends the first line of a remedy."""
    found = _COMMAND.fullmatch(reason.remedy)
    if found is None or found[1].startswith(":"):
        return None
    data, language = found[1].encode("latin-1") + controller.product.endings[0], controller.product.language
    if on_a_bus(controller) and language is not None:
        try:
            data = language.read(found[1])
        except PlacedError:
            return None
    label = f"Send {found[1]}" if len(found[1]) <= MOST_SENT else "Send it"
    return Button(label, "do", (Say(data, controller=controller.name),), filled=True)


def _power(name: str, label: str, *levels: str, filled: bool = False) -> Button:
    return Button(label, "do", tuple(Do("power", level, controller=name) for level in levels), filled=filled)


def _motion(controller: Controller, moving: list[str]) -> str:
    """Return what the machine does, e.g. `X moves to 60 mm, step 11 of 14: L1X-`."""
    moves = _sentence([" and ".join(_move(name, controller.axes[name]) for name in moving)])
    running = next((each for each in controller.programs.values() if each.running is not None), None)
    if running is None or running.running is None or running.running >= len(running.lines):
        return moves
    line = f"step {running.running + 1} of {len(running.lines)}: {running.lines[running.running].strip()}"
    return f"{moves}, {line}" if moves else f"{line[0].upper()}{line[1:]}"


def _plan(bench: Bench, name: str) -> str:
    if _hosted(bench, name):
        return "The host sends its program"
    planned = next_act(bench)
    return "" if planned is None else _plain(f"{planned[1]} at {figures(to_seconds(planned[0]))} s")


def _move(name: str, axis: Axis) -> str:
    if isinstance(axis, ServoAxis) or (pulses := axis.train.move.profile.pulses) is None:
        return f"{spoken(name)} moves in {'plus' if axis.velocity >= 0 else 'minus'}"
    move = axis.train.move
    return (
        f"{spoken(name)} moves to {_place(axis, move.origin + move.direction * pulses - (axis.pulses - axis.position))}"
    )


def _displaced(controller: Controller) -> str:
    """Return where a stored sequence begins, if the axes rest anywhere but at 0, where every scene begins."""
    axes = controller.axes
    places = " and ".join(f"{name} {_place(axis, axis.position)}" for name, axis in axes.items() if axis.position)
    rests = not any(axis.moving for axis in axes.values())
    return f": the sequence begins at {places}, not at 0" if places and rests else ""


def _place(axis: Axis, position: int) -> str:
    if axis.units is None:
        return f"{position} {axis.unit}"
    shown = f"{axis.units.value(position):.{axis.units.decimals}f}"
    return f"{shown.rstrip('0').rstrip('.') if '.' in shown else shown} {axis.units.of}"
