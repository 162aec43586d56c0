"""Tables of scripts, as those of the IF1: what the manual says, and what is sent, done and compared for it."""

import ast
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import pytest

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.core.units import MS

from .programs import (
    AT_ONCE,
    NEVER,
    continuous,
    cruise,
    distances,
    joystick_pulses,
    pairs,
    relative,
    rising,
    sequence,
    start,
    tracked,
    velocities,
    words,
)  # fmt: skip
from .talking import CONTROL, DATA, ask, i32, message, messages, ready, send, status_word, until_idle

FORMS: dict[str, Callable[..., tuple[int, ...]]] = {
    "default": lambda velocity, acceleration, ranges=0: (0x31, 0, ranges, *i32(velocity), *i32(acceleration)),
    "relative": relative,
    "absolute": lambda number, *rest: (0xCB, *relative(number, *rest)[1:]),
    "continuous": continuous,
}


def command(text: str) -> tuple[int, ...]:
    """Return the bytes of a command such as `33 =-100`, `09 02` or `relative 1 10000 100000 2000`.

    `33` is a byte in hex, `=100` a number of four bytes, `#100` of two; `at_once` and `never` are numbers, too.
    """
    code, *rest = text.replace("at_once", str(AT_ONCE)).replace("never", str(NEVER)).split()
    if code in FORMS:
        return FORMS[code](*(int(word, 0) for word in rest))
    return tuple(value for word in (code, *rest) for value in _bytes(word))


def _bytes(word: str) -> tuple[int, ...] | list[int]:
    if word[0] == "=":
        return i32(int(word[1:]))
    return words(int(word[1:])) if word[0] == "#" else tuple(bytes.fromhex(word))


@dataclass
class Play:
    """A board on which a script is played, and what its checks compare with: a position and a moment."""

    bench: Bench
    board: Controller
    place: int = 0
    since_ns: int = 0


def play(bench: Bench, script: str) -> None:
    """Carry out the actions and checks of a script, which are separated by `; `; what follows ` -- ` is a remark.

    The board is an 1811 that has been initialised, or what the first step says: `1810`, `1811 home_ms=0`, `tracked`,
    `tracked 1810` (see `tracked`), `new 1810` (not yet initialised).
    Actions: `33 =100` (send a command, see `command`), `sequence 1: 40 01, 01 02` (define it), `cruise -10000 100000`
    (a continuous move, up to its velocity), `start 35 =100` (until its motion has just begun), `velocities 1000 2000`
    and so on (data of a stream), `0.5 s` (run), `idle` (until the motion has ended), `until CHECK`, `trigger 1` (an
    edge), `home low`, `home released` (drive a terminal), `IDB 09 02`, `CB 20` (write to a register), `power off`,
    `power cycle`, `bus init`, `load -2.0` (N·m), `jam`, `free`, `displace 5` (turn the encoder), `stick 500` (deflect
    the joystick), `joystick -5` (pulses of a joystick, 1 kHz), `mark` (keep the position for `moved` and `marked`),
    `clock` (keep the moment for `later`).
    Answers: `8C -> FF` (the answer, without the opcode and the zeros at its end), `8C -> nothing`, `8C answers`,
    `88 & F0 is 00` (bits of its second byte), `says 01 A1, 28 00` (all messages that wait), `says nothing`,
    `next 01 A1` (the next one), `ODB 01` (the next byte).
    States: `83: -100` (the number of an answer), `at 25`, `moved 25`, `pulses 25`, `steps 900` (all pulses so far),
    `lasts 98 ms` (from the first of them to the last), `moves 2` (all motions so far), `velocity 10000`,
    `encoder at 5`, `98 ms later`, each with a number or `1 to 9`, `over 1`, `under 9`, `not 5`, `marked`; `moving`,
    `at rest`, `SB 50`, `SB & 7 is 2`, `led is high`, `interrupt`, `no interrupt`, `nothing planned` (no event is to
    come).
    """
    first, *rest = script.split("; ")
    match first.split():
        case ["1810" | "1811" as model, *options]:
            board = ready(bench, model, **_options(options))
        case ["tracked", *words]:
            options = [word for word in words if "=" in word]
            board = tracked(bench, *words[: len(words) - len(options)], **_options(options))
        case ["new", model, *options]:
            board = bench.add(model, **_options(options))
        case _:
            board, rest = ready(bench), [first, *rest]
    state = Play(bench, board)
    for step in rest:
        words = step.partition(" -- ")[0].split()
        if not (_acts(state, words) or _streams(state, words) or _by_hand(state, words) or _answers(state, words)):
            found, expected = _state(state, words)
            assert found == expected, f"{step}: {found}"


def _options(words: list[str]) -> dict[str, Any]:
    return {name: ast.literal_eval(value) for name, _, value in (word.partition("=") for word in words)}


def _acts(state: Play, words: list[str]) -> bool:
    """Perform an action; return False if it is none."""
    bench, board = state.bench, state.board
    match words:
        case [seconds, "s"]:
            bench.run(float(seconds))
        case ["idle"]:
            until_idle(bench, board)
        case ["until", *check]:
            assert bench.run_until(lambda: _holds(*_state(state, check)), 100), words
        case ["sequence", number, *_]:
            commands = " ".join(words[2:]).split(", ")
            sequence(bench, board, int(number[:-1]), *map(command, commands))
        case ["cruise", velocity, acceleration]:
            cruise(bench, board, abs(int(velocity)), int(acceleration), int(velocity[0] == "-"))
        case ["start", *rest]:
            start(bench, board, *command(" ".join(rest)))
        case ["trigger", number]:
            rising(bench, board, int(number))
        case ["IDB", *values]:
            for value in values:
                board.bus.write(DATA, int(value, 16))
        case ["CB", value]:
            board.bus.write(CONTROL, int(value, 16))
        case ["mark"]:
            state.place = board.axes["motor"].position
        case ["clock"]:
            state.since_ns = bench.now
        case _:
            return False
    return True


def _streams(state: Play, words: list[str]) -> bool:
    """Send data of a stream; return False if the words are no such action."""
    match words:
        case ["velocities", *numbers]:
            velocities(state.bench, state.board, *map(int, numbers))
        case ["distances", *numbers]:
            distances(state.bench, state.board, *map(int, numbers))
        case ["pairs", *numbers]:
            every = map(int, numbers)
            pairs(state.bench, state.board, *zip(every, every, strict=True))
        case _:
            return False
    return True


def _by_hand(state: Play, words: list[str]) -> bool:
    """Do something at the terminals, the motor, the joystick or the power; return False if it is no such action."""
    board, motor = state.board, state.board.axes["motor"]
    match words:
        case ["bus", "init"]:
            board.bus.init()
        case ["load", torque]:
            motor.load(float(torque))
        case ["power", "cycle"]:
            board.power_cycle()
        case ["power", level]:
            board.power(level == "on")
        case ["jam" | "free" as what]:
            motor.jam(what == "jam")
        case ["displace", counts]:
            motor.encoder.displace(int(counts))
        case ["stick", rate]:
            board.joystick.deflect(int(rate))
        case ["joystick", pulses, *period_ms]:
            joystick_pulses(state.bench, board, abs(int(pulses)), pulses[0] != "-", float((*period_ms, 1)[0]) / 1000)
        case [pin, "low" | "high" as level]:
            board.pins[pin].drive(level == "high")
        case [pin, "released"]:
            board.pins[pin].release()
        case _:
            return False
    return True


def _answers(state: Play, words: list[str]) -> bool:
    """Send a command and compare its answer, or the messages that wait; return False if it is neither."""
    bench, board, text = state.bench, state.board, " ".join(words)
    asked, is_answer, answer = text.partition(" -> ")
    if is_answer:
        request = command(asked)
        expected = b"" if answer == "nothing" else bytes([request[0], *command(answer)]).ljust(16, b"\0")
        assert ask(bench, board, *request) == expected, text
    elif words[1:] == ["answers"]:
        assert ask(bench, board, int(words[0], 16))[0] == int(words[0], 16), text
    elif words[0] == "says":
        assert messages(bench, board) == ([] if words[1] == "nothing" else text[5:].lower().split(", ")), text
    elif words[0] == "next":
        assert message(bench, board).rstrip(b"\0") == bytes.fromhex(text[5:].replace("nothing", "")), text
    elif words[0] in FORMS or (
        len(words[0]) == 2 and words[0] not in ("at", "SB", "no") and words[-1] != "later" and "&" not in words
    ):
        send(bench, board, *command(text))
    else:
        return False
    return True


def _holds(found: Any, expected: Any) -> bool:
    return bool(found == expected)


def _state(state: Play, words: list[str]) -> tuple[Any, Any]:
    """Return the state of which a check speaks, and the expected one."""
    board, motor = state.board, state.board.axes["motor"]
    match words:
        case ["at", "rest"]:
            return motor.velocity, 0
        case ["moving"]:
            return bool(motor.velocity), True
        case ["SB", value]:
            return status_word(state.bench, board), int(value, 16)
        case ["SB", "&", mask, "is", value]:
            return status_word(state.bench, board) & int(mask, 16), int(value, 16)
        case [opcode, "&", mask, "is", value]:
            return ask(state.bench, board, int(opcode, 16))[1] & int(mask, 16), int(value, 16)
        case ["ODB", value]:
            return board.bus.read(DATA), int(value, 16)
        case ["lasts", *expected, "ms"]:
            times = motor.pulse_times()
            return Fraction(int(times[-1] - times[0]), MS), Numbers(expected, state.place)
        case ["steps", *expected]:
            return len(motor.pulse_times()), Numbers(expected, state.place)
        case ["moves", *expected]:
            return len(motor.train.moves), Numbers(expected, state.place)
        case [pin, "is", level]:
            return board.pins[pin].level, level == "high"
        case ["interrupt"]:
            return board.bus.interrupt, True
        case ["no", "interrupt"]:
            return board.bus.interrupt, False
        case ["nothing", "planned"]:
            return state.bench.clock.next_event_ns(), None
        case [*expected, "ms", "later"]:
            return Fraction(state.bench.now - state.since_ns, MS), Numbers(expected, state.place)
        case [what, *expected] if what[-1] == ":":
            return _number(state, int(what[:-1], 16)), Numbers(expected, state.place)
        case ["encoder", "at", *expected]:
            return motor.encoder.count, Numbers(expected, state.place)
        case ["at", *expected]:
            return motor.position, Numbers(expected, state.place)
        case ["moved", *expected]:
            return motor.position - state.place, Numbers(expected, state.place)
        case ["pulses" | "velocity" as what, *expected]:
            return getattr(motor, what), Numbers(expected, state.place)
        case _:
            raise AssertionError(f"neither an action nor a check: {' '.join(words)!r}")


def _number(state: Play, opcode: int) -> int:
    """Return the number that a request answers: of six bytes from home and from zero, otherwise of four."""
    data = ask(state.bench, state.board, opcode)
    end = 7 if opcode in (0x82, 0x83) else 5
    assert (data[0], any(data[end:])) == (opcode, False)
    return int.from_bytes(data[1:end], "big", signed=True)


class Numbers:
    """The numbers equal to `5`, `1 to 9`, `over 1`, `under 9`, `not 5`, `about 5` (within a millionth) or `marked`."""

    def __init__(self, words: list[str], place: int) -> None:
        self._words = [str(place) if word == "marked" else word for word in words]

    def __eq__(self, found: object) -> bool:
        assert isinstance(found, int | float | Fraction)
        match self._words:
            case [low, "to", high]:
                return Fraction(low) <= found <= Fraction(high)
            case ["over", low]:
                return found > Fraction(low)
            case ["under", high]:
                return found < Fraction(high)
            case ["not", number]:
                return found != Fraction(number)
            case ["about", number]:
                return bool(found == pytest.approx(float(number)))
        (number,) = self._words
        return found == Fraction(number)

    def __hash__(self) -> int:
        return hash(tuple(self._words))
