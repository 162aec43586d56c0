"""Helpers of the IF1 and IF2 tests: send messages, run, read answers, moves and levels, and play scripts."""

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any, cast

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.core.units import MS, S
from axistwin.plant.stepper import StepperAxis
from axistwin.sim.frames import LineError, Parity
from axistwin.sim.pins import Pin

Segment = tuple[int | Fraction, Fraction]
"""A pulse rate, and its duration in seconds."""

OWN_TIME_NS = MS
"""Longest time that a sequence step without a move or a wait may take; the manual gives no figure."""
BITS_7_OR_8 = {1: 7, 2: 7, 3: 8, 4: 8, 5: 8, 6: 8, 7: 8, 8: 8}
PARITY: dict[int, Parity] = {1: "N", 2: "N", 3: "O", 4: "E", 5: "O", 6: "E", 7: "N", 8: "O", 9: "E"}

# Messages


def write(controller: Controller, *messages: str, end: str = "\r") -> None:
    """Write messages, each with its terminator, to the host's port, without advancing the time."""
    controller.serial.write("".join(message + end for message in messages).encode("latin-1"))


def send(bench: Bench, controller: Controller, *messages: str, seconds: float = 0.2, end: str = "\r") -> bytes:
    """Write messages and run for `seconds`; return everything received that the host has not read."""
    write(controller, *messages, end=end)
    bench.run(seconds)
    return controller.serial.read()


def command(bench: Bench, controller: Controller, *messages: str, seconds: float = 0.2, end: str = "\r") -> None:
    """Send messages that are not answered, and run for a while; assert that nothing is received."""
    assert send(bench, controller, *messages, seconds=seconds, end=end) == b""


def ask(bench: Bench, controller: Controller, message: str, seconds: float = 0.2, end: str = "\r") -> bytes:
    """Send one message and return its answer, with all that the host has not read before."""
    return send(bench, controller, message, seconds=seconds, end=end)


def status(bench: Bench, controller: Controller, letter: str) -> str:
    """Send K, F, I, O, E or N, and return the answer without its terminator."""
    controller.serial.read()
    write(controller, letter)
    bench.run_until(lambda: not controller.serial.pending, 10)
    bench.run(0.05)
    reply = controller.serial.read().decode("latin-1")
    assert reply.endswith("\r") and reply.count("\r") == 1, f"{letter} answered {reply!r}"
    return reply[:-1]


def number(bench: Bench, controller: Controller, letter: str) -> int:
    """Return the number answered to F, I, O or N."""
    return int(status(bench, controller, letter))


def status_word(bench: Bench, controller: Controller) -> int:
    """Return the motion status K."""
    return number(bench, controller, "K")


def faults(bench: Bench, controller: Controller) -> tuple[bytes, bytes]:
    """Return the answers to K and to F; F clears the communication faults."""
    return ask(bench, controller, "K"), ask(bench, controller, "F")


def until_idle(bench: Bench, controller: Controller, timeout: float = 100.0) -> None:
    """Run until E no longer answers `E`; fail after `timeout` seconds."""
    end_ns = bench.now + int(timeout * S)
    while status(bench, controller, "E") == "E":
        bench.run(0.1)
        assert bench.now < end_ns, "still busy"


def each_character(bench: Bench, controller: Controller, text: str, act: Callable[[int], None]) -> None:
    """Send `text`; just before its character n is transmitted, call `act(n)`."""
    for n, character in enumerate(text):
        act(n)
        write(controller, character, end="")
        bench.run(controller.serial.host.format.frame_ns / S)


def arrivals(bench: Bench, controller: Controller) -> list[tuple[int, int, LineError]]:
    """Return a list that grows with (time in ns, byte, errors) of each character that the host receives."""
    characters: list[tuple[int, int, LineError]] = []
    controller.serial.subscribe_received(lambda byte, errors: characters.append((bench.now, byte, errors)))
    return characters


# Initialisation


def ready(bench: Bench, message: str = "U61", model: str = "if1", **options: Any) -> Controller:
    """Return a new controller that is ready for commands."""
    return initialise(bench, bench.add(model, **options), message)


def detect(bench: Bench, controller: Controller) -> None:
    """Run through the self-test and the detection of the baud rate."""
    bench.run(1.5)
    assert send(bench, controller, "(", seconds=1.0, end="") == b"U\r"


def initialise(bench: Bench, controller: Controller, message: str = "U61") -> Controller:
    """Initialise a controller after power-up until its ramp is calculated; set the host to the same format."""
    detect(bench, controller)
    end = "\r\n" if message[0] == "V" else "\r"
    each_character(bench, controller, message + end, lambda n: bench.run(0.02))  # so slow that none is lost
    bench.run(0.15)
    host_format(controller, message)
    bench.run(1.2)
    assert controller.serial.read() == b""
    return controller


def host_format(controller: Controller, message: str) -> None:
    """Set the host to the format of a data format message such as `U61`."""
    frame, parity = int(message[1]), int(message[2])
    host = controller.serial.host
    host.bytesize, host.stopbits, host.parity = BITS_7_OR_8[frame], 2 - frame % 2, PARITY[parity]


# Moves and levels


def moving(controller: Controller) -> bool:
    """True if the motion of any axis has not ended."""
    return any(axis.moving for axis in controller.axes.values())


def positions(controller: Controller) -> tuple[int, int, int]:
    """Return the positions of X, Y and Z."""
    axes = controller.axes
    return axes["X"].position, axes["Y"].position, axes["Z"].position


def moves(axis: StepperAxis) -> list[int]:
    """Return the moves of an axis as signed numbers of pulses; moves without a pulse are left out."""
    lengths = [move.direction * move.profile.pulses_by(axis.clock.now - move.start_ns) for move in axis.train.moves]
    return [length for length in lengths if length]


def times(axis: StepperAxis) -> list[int]:
    """Return the times of all pulses of an axis in nanoseconds."""
    return [int(at_ns) for at_ns in axis.pulse_times()]


def gaps(times_ns: Iterable[int]) -> list[int]:
    """Return the differences of successive times."""
    return [after - before for before, after in pairwise(times_ns)]


def start_ns(axis: StepperAxis) -> int:
    """Return the time at which the latest motion began."""
    return axis.train.move.start_ns


def since_start(axis: StepperAxis, nth: int = -1) -> list[int]:
    """Return the pulse times of the latest motion, or of motion `nth`, in nanoseconds from its start."""
    starts = [*(move.start_ns for move in axis.train.moves), axis.clock.now + 1]
    begin, end = starts[nth - 1 if nth < 0 else nth], starts[nth if nth < 0 else nth + 1]
    return [int(time) - begin for time in axis.pulse_times(begin, end)]


def at_speed(bench: Bench, controller: Controller, axis: str = "X") -> float:
    """Return the speed of a run after its ramp, in pulses per second."""
    bench.run_until(lambda: controller.axes[axis].moving, 3)
    bench.run(30)
    return controller.axes[axis].velocity


def outputs(controller: Controller) -> str:
    """Return the levels of outputs 1 to 5 as five digits."""
    return "".join(str(int(controller.pins[f"output{n}"].level)) for n in range(1, 6))


def edges(pin: Pin) -> list[tuple[int, bool]]:
    """Return a list that grows with (nanoseconds, level) of each change of the pin."""
    seen: list[tuple[int, bool]] = []
    pin.subscribe(lambda changed: seen.append((changed.clock.now, changed.level)))
    return seen


# Expected pulse times, by an independent calculation


def pulse_times_of(segments: Sequence[Segment]) -> list[int]:
    """Return pulse times: the phase advances at the rate of each segment, and pulse n comes when it reaches n."""
    found: list[int] = []
    begin, phase = Fraction(0), Fraction(0)
    for rate, seconds in segments:
        last = phase + rate * seconds
        found += [int((begin + (n - phase) / rate) * S) for n in range(int(phase) + 1, int(last) + 1)]
        begin, phase = begin + seconds, last
    return found


def constant(rate: int | Fraction, pulses: int) -> list[int]:
    """Return pulse times without a ramp: pulse n comes n / rate seconds after the start."""
    return [int(n * S / Fraction(rate)) for n in range(1, pulses + 1)]


def ramped(distance: int, start: int, top: int | Fraction, increment: int, acceleration: int) -> list[Segment]:
    """Return the segments of an index: up by `increment` every increment/acceleration seconds, constant, down.

    A distance too short for the whole ramp uses as many levels as fit twice, and the rest runs at the next level.
    """
    interval = Fraction(increment, acceleration)
    levels: list[int | Fraction] = []
    level, up = start, Fraction(0)
    while level < top and 2 * (up + level * interval) <= distance:
        levels.append(level)
        up += level * interval
        level += increment
    plateau = min(Fraction(level), Fraction(top))
    ramp = [(rate, interval) for rate in levels]
    return [*ramp, (plateau, (distance - 2 * up) / plateau), *reversed(ramp)]


# Scripts


@dataclass
class Seen:
    """Changes of each output since a script began, as (nanoseconds, level), and the marked place."""

    changes: dict[str, list[tuple[int, bool]]]
    place: tuple[int, int, int]


def play(bench: Bench, controller: Controller, script: str) -> None:
    """Carry out the actions and checks of a script, which are separated by `; `.

    Actions: `X100$` (send a message), `sends x10<CR>` (send characters), `slowly X10$` (send a message, 2 ms before
    each character), `E<CR> -> C<CR>` (send characters, and compare all that is received in 0.2 s), `K?` (send a
    request, ignore the answer), `0.5 s` (run), `until CHECK` (run until this check of a state is true), `idle` (until E
    is not `E`), `estop low`, `input1 high`, `estop released` (drive a pin), `mark` (keep the positions for `moved`).
    Of the line: `host RTS off`, `host parity E`, `host 1200`, `host 7E1` (baud rate, format), `fill 9` (blanks, until
    the last is in the buffer), `break 0.25 s`, `cut`, `mend`, `lose`, `double`, `flip 01` (the wire to the interface,
    or its next character), `cut back` (the wire to the host).
    Of the power: `power on`, `power up` (off, then on for 1.05 s, DSR off meanwhile), `power up with DSR`, `detect`
    (`(` after a self-test).
    Checks of answers: `K: 32`, `F: 8|16` (one of them), `N: X` (the steps of X), `Q: 32` (byte), `receives C<CR>`.
    Nothing else may be received.
    Checks of a state: `at 0 10 0`, `moved 0 10 0` (since `mark`, or since the script began), `X at 10`,
    `X between 1 399`, `X moves 120 -20`, `X runs at 400`, `X moving`, `X at rest`, `moving`, `still`, `led is high`,
    `led is flashing`, `DTR is on`, `outputs 01000`.
    Of the outputs since the script began: `outputs unchanged`, `output4 high for 200 ms` (each time),
    `output4 high for 48000 to 48007 ms`.
    Of the latest motion, pulse by pulse: `X 100 pulses at 200`, `X constant at 200`, `X like Y`,
    `X 300 pulses from 400 to 1000 by 100 at 10000`, `Y 75 of 300 pulses from 400 ...` (the minor axis), and
    `X begins 3 to 5 ms after Y` (after the last pulse of Y before it).
    In texts, `<SP>`, `<CR>`, `<LF>` and `<7F>` are characters.
    """
    changes = {name: edges(pin) for name, pin in controller.pins.items() if name.startswith("output")}
    seen = Seen(changes, positions(controller))
    for act in script.split("; "):
        words = act.split()
        if words[:1] != ["receives"]:
            assert controller.serial.read() == b"", f"received before {act!r}"
        if (
            _act(bench, controller, words, seen)
            or _act_on_line(bench, controller, words, act)
            or _answer(bench, controller, words, act)
        ):
            continue
        if (found := _state(controller, words, seen)) is not None:
            assert found[0] == found[1], act
        else:
            assert act == act.upper(), f"neither an action nor a check: {act!r}"
            write(controller, act)
    assert controller.serial.read() == b""


def _act(bench: Bench, controller: Controller, words: list[str], seen: Seen) -> bool:
    """Perform an action other than a message; return False if the words are no such action."""
    host = controller.serial.host
    match words:
        case [seconds, "s"]:
            bench.run(float(seconds))
        case ["until", *check]:
            assert bench.run_until(lambda: _holds(_state(controller, check, seen)), 100), " ".join(words)
        case ["slowly", *text]:
            each_character(bench, controller, " ".join(text) + "\r", lambda n: bench.run(0.002))
        case [pin, "low" | "high" as level]:
            controller.pins[pin].drive(level == "high")
        case [pin, "released"]:
            controller.pins[pin].release()
        case ["host", line, "on" | "off" as level]:
            setattr(host, line.lower(), level == "on")
        case ["host", setting, value]:
            setattr(host, setting, int(value) if value.isdecimal() else value)
        case ["mark"]:
            seen.place = positions(controller)
        case ["idle"]:
            until_idle(bench, controller)
        case ["K?" | "F?" | "I?" | "O?" | "E?" | "N?" as request]:
            status(bench, controller, request[0])
        case _:
            return False
    return True


def _act_on_line(bench: Bench, controller: Controller, words: list[str], act: str) -> bool:
    """Perform an action at the serial line or the power; return False if the words are no such action."""
    serial = controller.serial
    match words:
        case _ if " -> " in act:
            said, answer = act.split(" -> ")
            serial.write(characters(said))
            bench.run(0.2)
            assert serial.read() == characters(answer), act
        case ["sends", *text]:
            serial.write(characters(" ".join(text)))
        case ["host", rate] if rate.isdigit():
            serial.host.baudrate = int(rate)
        case ["host", form]:
            serial.host.bytesize, serial.host.stopbits = int(form[0]), int(form[2])
            serial.host.parity = cast("Parity", form[1])
        case ["fill", blanks]:
            serial.write(b" " * int(blanks))
            bench.run_until(lambda: not serial.pending, 100)
            bench.run(serial.host.format.frame_ns / S + 0.001)
        case ["break", seconds, "s"]:
            serial.send_break(float(seconds))
        case ["cut" | "mend" | "lose" | "double" as what, *back]:
            getattr(serial.from_device if back else serial.to_device, what)()
        case ["flip", mask, *back]:
            (serial.from_device if back else serial.to_device).flip(int(mask, 16))
        case ["power", "on" | "off" as level]:
            controller.power(level == "on")
        case ["power", "up", *dsr]:
            controller.power(False)
            serial.host.dtr = bool(dsr)
            controller.power(True)
            bench.run(1.05)
            serial.host.dtr = True
        case ["detect"]:
            detect(bench, controller)
        case _:
            return False
    return True


def _answer(bench: Bench, controller: Controller, words: list[str], act: str) -> bool:
    """Check an answer; return False if the words are no such check."""
    match words:
        case ["N:", "X" | "Y" | "Z" as axis]:
            assert number(bench, controller, "N") == abs(controller.axes[axis].position), act
        case ["K:" | "F:" | "I:" | "O:" | "E:" | "N:" as request, answer]:
            obtained = status(bench, controller, request[0])
            assert obtained in answer.split("|"), f"{act}: {obtained}"
        case ["Q:", value]:
            assert ask(bench, controller, "Q") == bytes([int(value)]), act
        case ["receives", *text]:
            assert controller.serial.read() == characters(" ".join(text)), act
        case _:
            return False
    return True


def _state(controller: Controller, words: list[str], seen: Seen) -> tuple[object, object] | None:
    """Return the state of which the words speak, and the expected one; None if they are no such check."""
    axes, pins = controller.axes, controller.pins
    match words:
        case ["at", *places]:
            return positions(controller), tuple(map(int, places))
        case ["moved", *distances]:
            moved = [now - then for now, then in zip(positions(controller), seen.place, strict=True)]
            return moved, [int(distance) for distance in distances]
        case [axis, "at", "rest"]:
            return axes[axis].moving, False
        case [axis, "moving"]:
            return axes[axis].moving, True
        case [axis, "at", place]:
            return axes[axis].position, int(place)
        case [axis, "between", low, high]:
            return int(low) <= axes[axis].position <= int(high), True
        case [axis, "moves", *lengths]:
            return moves(axes[axis]), [int(length) for length in lengths]
        case [axis, "runs", "at", speed]:
            return axes[axis].velocity, Fraction(speed)
        case [axis, pulses, "pulses", "at", rate]:
            return since_start(axes[axis]), constant(Fraction(rate), int(pulses))
        case [axis, "constant", "at", rate]:
            return since_start(axes[axis]), constant(Fraction(rate), len(since_start(axes[axis])))
        case [axis, pulses, "pulses", "from", start, "to", top, "by", increment, "at", acceleration]:
            ramp = ramped(int(pulses), int(start), Fraction(top), int(increment), int(acceleration))
            return since_start(axes[axis]), pulse_times_of(ramp)
        case [axis, minor, "of", pulses, "pulses", "from", start, "to", top, "by", increment, "at", acceleration]:
            ramp = ramped(int(pulses), int(start), Fraction(top), int(increment), int(acceleration))
            share = Fraction(minor) / Fraction(pulses)
            return since_start(axes[axis]), pulse_times_of([(rate * share, seconds) for rate, seconds in ramp])
        case [axis, "like", other]:
            return since_start(axes[axis]), since_start(axes[other])
        case [axis, "begins", low, "to", high, "ms", "after", other]:
            begin = start_ns(axes[axis])
            after = begin - max(at_ns for at_ns in times(axes[other]) if at_ns <= begin)
            return float(low) * MS <= after <= float(high) * MS, True
        case ["moving" | "still" as state]:
            return moving(controller), state == "moving"
        case ["DTR" | "RTS" as line, "is", "on" | "off" as level]:
            return getattr(controller.serial, line.lower()), level == "on"
        case ["led", "is", "flashing" | "steady" as state]:
            return pins["led"].flashing, state == "flashing"
        case [pin, "is", "low" | "high" as level]:
            return pins[pin].level, level == "high"
        case ["outputs", "unchanged"]:
            return [name for name, changes in seen.changes.items() if changes], []
        case ["outputs", levels]:
            return outputs(controller), levels
        case [pin, "low" | "high" as level, "for", *lengths, "ms"]:
            found = [(off - on) / MS for (on, was), (off, _) in pairwise(seen.changes[pin]) if was is (level == "high")]
            if lengths[1:2] == ["to"]:
                return len(found) == 1 and float(lengths[0]) <= found[0] <= float(lengths[2]), True
            return found, [float(length) for length in lengths]
    return None


def characters(text: str) -> bytes:
    """Return the characters of a text, in which `<SP>`, `<CR>`, `<LF>` and codes such as `<7F>` stand for one each."""
    named = {"SP": " ", "CR": "\r", "LF": "\n"}
    return re.sub(r"<(\w\w)>", lambda m: named.get(m[1]) or chr(int(m[1], 16)), text).encode("latin-1")


def _holds(found: tuple[object, object] | None) -> bool:
    """Return whether a state is the expected one."""
    assert found is not None, "not a check of a state"
    return found[0] == found[1]
