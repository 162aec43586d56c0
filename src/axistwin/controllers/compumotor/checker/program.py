"""Checker for a host's commands: reports the commands that an 1810 or 1811 would ignore, without running them.

`check` follows a host's commands from power-on to power-off, with definitions, mode and sequences.  A board ignores
wrong commands without a message, so all of them are reported.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Flag
from itertools import groupby
from typing import Any

from axistwin.controllers.commandset import CommandSet
from axistwin.controllers.compumotor import rules
from axistwin.controllers.compumotor.checker.texts import name_of
from axistwin.controllers.compumotor.language import LONGEST, Accept, DontCare, Opcode
from axistwin.controllers.compumotor.parts.library import CLOSED_LOOP, Kind, Move
from axistwin.controllers.compumotor.parts.ranges import BASE_CLOCKS, FULL, VELOCITY_RANGES
from axistwin.controllers.diagnostics import Diagnostic, Fix, Rule, Sent, Session, diagnose, fixing, replaced
from axistwin.core.units import MS, S

DEFINITIONS = tuple(Kind)
LOOPS = (0x20, 0x21)
NEED_DEFAULT = {0x32: "move", 0x33: "move", 0x34: "move", 0x35: "move", 0x36: "move", 0x39: "search", 0x3A: "search"}
NEED_LOOP = (0x35, 0x36)
LOOP_PARAMETERS = {0xB0: "ratio", 0xB1: "resolution", 0xB2: "sigma", 0xB3: "algorithm", 0xB4: "teeth"}
RATIO, RESUME = 0xB0, 0x37
TAKE_TIME = (*NEED_DEFAULT, RESUME, 0x40, 0x41)
IGNORED_MEANWHILE = (0x92, 0xD9, 0xDA)
MODAL = frozenset((0x50, 0x51, 0x52, 0x53, 0xD8, 0xD9))
"""Opcodes of the commands that decide which commands the board accepts next: modes, and definitions of sequences."""
DATA = {0xE0: 0x51, 0xE1: 0x52, 0xE3: 0x53}  # Streaming mode that accepts streamed data, by their opcode.
END_OF_STREAM = -0x7FFF
SHORTEST_NS = 2 * MS  # The shortest duration of a velocity-distance pair.


@dataclass(frozen=True)
class Given:
    """A command in the checked program file, with its parameter values, its bytes, and the position of each byte."""

    command: Opcode
    values: tuple[Any, ...]
    sent: Sequence[Sent]


@dataclass
class Definitions:
    """The board's definitions and its mode, after the commands that have been checked."""

    moves: dict[int, int] = field(default_factory=dict)  # Opcode that has defined each move, by its number.
    sequences: dict[int, list[Given]] = field(default_factory=dict)
    defining: int | None = None
    begun: Given | None = None
    default: bool = False
    home: bool = False
    loop: set[int] = field(default_factory=set)
    mode: Given | None = None  # Command that has entered the streaming mode; None in indexer mode.
    triggers: dict[int, int] = field(default_factory=dict)


def check(commands: CommandSet, sessions: Sequence[Session]) -> list[Diagnostic]:
    """Return all problems in a host's commands, one on each line, sorted by their position in the file."""
    found: set[Diagnostic] = set()
    for session in sessions:
        checker = _followed(commands, session)
        checker.finish()
        found |= set(checker.found)
    return sorted(found)


def acceptable(commands: CommandSet, session: Session) -> list[Opcode]:
    """Return the commands that the board accepts after those of this session."""
    defined = _followed(commands, session).defined

    def may_follow(accepted: Flag) -> bool:
        if defined.defining is not None:
            return bool(accepted & (Accept.SEQUENCE | Accept.DEFINING))
        return bool(accepted) and _misplaced(accepted, defined.mode is not None) is None

    return [command for command in commands if isinstance(command, Opcode) and may_follow(command.accepted)]


def _followed(commands: CommandSet, session: Session) -> "_Checker":
    checker = _Checker(commands)
    for _, line in groupby(session.characters, key=lambda sent: sent.line):
        checker.take(list(line))
    return checker


class _Checker:
    def __init__(self, commands: CommandSet) -> None:
        self.commands, self.defined = commands, Definitions()
        self.found: list[Diagnostic] = []
        self._before: Sent | None = None  # First byte of the command before, if that takes time.

    def take(self, sent: Sequence[Sent]) -> None:
        command = self.commands.get(sent[0].byte)
        if not isinstance(command, Opcode):
            self._say(rules.NO_COMMAND, sent[:1], f"no command {sent[0].byte:02X}: ignored")
        elif (values := self._values(command, sent)) is not None:
            self._during_move(Given(command, values, sent))
            self._place(Given(command, values, sent))

    def _during_move(self, given: Given) -> None:
        """Report 92h, D9h and DAh on the line after a move, with nothing between (a wait takes a line or columns)."""
        before, first, opcode = self._before, given.sent[0], given.command.opcode
        begins = opcode in TAKE_TIME and self.defined.defining is None
        self._before = first if begins else None
        if opcode in IGNORED_MEANWHILE and before and (before.line + 1, before.column) == (first.line, first.column):
            what = f"ignored during {before.byte:02X}: wait until its motion has ended"
            self._about(rules.DURING_MOVE, given, what)

    def _values(self, command: Opcode, sent: Sequence[Sent]) -> tuple[Any, ...] | None:
        here = sent[1:]
        if len(sent) > LONGEST:
            self._say(rules.TOO_LONG, sent[LONGEST:], f"the command is too long: expected at most {LONGEST} bytes")
            return None
        if len(here) < command.size:
            given = f"{len(here)} parameter byte{'s' * (len(here) != 1)}"
            message = f"{_called(command)} has {given}: expected {command.size}"
            self._say(rules.TOO_SHORT, sent[-1:], message, command.chapter)
            return None
        for surplus in here[command.size :]:
            if surplus.byte:
                what = f"surplus byte {surplus.byte:02X}: expected 00 after the {command.size} bytes of the parameters"
                self._say(rules.SURPLUS, [surplus], what, command.chapter)
                return None
        return self._decoded(command, here)

    def _decoded(self, command: Opcode, here: Sequence[Sent]) -> tuple[Any, ...] | None:
        values, at = [], 0
        for parameter in command.fields:
            part = here[at : at + parameter.size]
            data = bytes(sent.byte for sent in part)
            value = parameter.decode(data)
            if value is None:
                self._say(
                    rules.RANGE, part, f"{data.hex(' ').upper()} is out of range: expected {parameter}", command.chapter
                )
                return None
            if not isinstance(parameter, DontCare):
                values.append(value)
            at += parameter.size
        return tuple(values)

    def _place(self, given: Given) -> None:
        accepted, defined = given.command.accepted, self.defined
        if not accepted:
            self._about(rules.NOTHING, given, f"{_called(given.command)} does nothing")
        elif defined.defining is not None and Accept.DEFINING not in accepted:
            if Accept.SEQUENCE in accepted:
                defined.sequences[defined.defining].append(given)
                self._value_rules(given)
            else:
                self._say(rules.NOT_IN_SEQUENCE, given.sent, f"{_called(given.command)} is not allowed in a sequence")
        elif wrong := _misplaced(accepted, defined.mode is not None):
            rule, what = wrong
            self._about(rule, given, f"{_called(given.command)} {what}")
        else:
            self._value_rules(given)
            self._follow(given)

    def _value_rules(self, given: Given) -> None:
        opcode, values = given.command.opcode, given.values
        if opcode in DEFINITIONS:
            self._move_rules(given, *values[1:4])
            if values[0] > 50:
                message = f"move {values[0]} is not stored: expected 1 to 50"
                self._about(rules.NO_SUCH_MOVE, given, message, given.sent[1:2])
        elif opcode == 0x31 and any(values[1:]):
            self._move_rules(given, *values)
        elif opcode == 0xEE:
            self._marker(given)

    def _move_rules(self, given: Given, ranges: tuple[int, int], velocity: int, acceleration: int) -> None:
        velocity_bytes = given.sent[3:7]
        if Move(Kind.CONTINUOUS, ranges, velocity, acceleration).rate is None:
            most = VELOCITY_RANGES[ranges[0]].highest
            message = f"velocity {velocity} is beyond range {ranges[0]}: expected at most {most}"
            self._about(rules.VELOCITY, given, message, velocity_bytes)
        elif not acceleration:
            self._about(rules.ACCELERATION, given, "acceleration 0: the move is never performed, expected 1 or more")

    def _follow(self, given: Given) -> None:
        opcode, values, defined = given.command.opcode, given.values, self.defined
        match opcode:
            case 0xD9:
                defined.defining, defined.begun = values[0], given
                defined.sequences[values[0]] = []
            case 0xD8:
                self._end_definition(given)
            case 0xDA:
                defined.sequences.pop(values[0], None)
            case 0xD7:
                defined.moves.pop(values[0], None)
            case 0x41:
                self._perform_sequence(given)
            case 0x50:
                defined.mode = None
            case 0x51 | 0x52 | 0x53:
                defined.mode, defined.sequences = given, {}
            case 0xE0 | 0xE1 | 0xE3:
                self._data(given)
            case _:
                self._perform(given)

    def _perform(self, given: Given) -> None:
        opcode, values, defined = given.command.opcode, given.values, self.defined
        if opcode in DEFINITIONS:
            defined.moves[values[0]] = opcode
        elif opcode in LOOP_PARAMETERS:
            defined.loop.add(opcode)
        elif opcode == 0x31:
            defined.default = any(values[1:])
        elif opcode == 0x38:
            defined.home = True
        elif opcode == 0x40:
            self._perform_move(given)
        elif opcode in NEED_DEFAULT:
            self._needs(given)
        elif 0x74 <= opcode <= 0x7F or opcode == 0xAC:
            self._trigger(given)

    def _perform_move(self, given: Given) -> None:
        number, defined = given.values[0], self.defined
        if number not in defined.moves:
            self._about(rules.NO_MOVE, given, f"move {number} is not defined here", given.sent[1:2])
        elif defined.moves[number] in CLOSED_LOOP and self.commands.get(RESUME) is None:
            what = f"not performed: move {number} is a closed-loop move, but an 1810 has no encoder"
            self._about(rules.NO_ENCODER, given, what)
        elif defined.moves[number] in CLOSED_LOOP and RATIO not in defined.loop:
            what = f"ignored: B0 (ratio) must be sent first, because move {number} is a closed-loop move"
            self._about(rules.NOT_GIVEN, given, what)

    def _needs(self, given: Given) -> None:
        opcode, defined = given.command.opcode, self.defined
        missing = [] if defined.default else ["31 (default velocity and acceleration)"]
        if opcode in (0x39, 0x3A) and not defined.home:
            missing.append("38 (define home)")
        if opcode in NEED_LOOP:
            missing += [f"{code:02X} ({name})" for code, name in LOOP_PARAMETERS.items() if code not in defined.loop]
        if missing:
            self._about(rules.NOT_GIVEN, given, f"ignored: {', '.join(missing)} must be sent first")

    def _trigger(self, given: Given) -> None:
        opcode, defined = given.command.opcode, self.defined
        if len(given.values) < 2:
            return
        trigger, on = given.values[:2]
        busy = defined.triggers.get(trigger)
        if not on:
            if busy == opcode:
                del defined.triggers[trigger]
        elif busy not in (None, opcode):
            what = f"ignored: trigger {trigger} already has the function {busy:02X}, which must be disabled first"
            self._about(rules.TRIGGER, given, what)
        else:
            defined.triggers[trigger] = opcode

    def _end_definition(self, given: Given) -> None:
        defined = self.defined
        if defined.defining is None:
            whole = fixing("leave it out", replaced(given.sent, ""), sure=False)
            self._about(rules.NOT_DEFINING, given, "no sequence is being defined", fix=whole)
            return
        self._loops(defined.sequences[defined.defining])
        defined.defining = None

    def _loops(self, buffer: Sequence[Given]) -> None:
        inside = 0
        for at, given in enumerate(buffer):
            if given.command.opcode not in LOOPS:
                inside = max(0, inside - 1)
                continue
            count, left = given.values[0], len(buffer) - at - 1
            if inside:
                self._say(rules.NESTED, given.sent, "ignored: loops cannot be nested")
                inside -= 1
                continue
            if count > left:
                self._about(rules.LOOP_TOO_LONG, given, f"the loop repeats {count} commands, but {left} follow")
            inside = count

    def _perform_sequence(self, given: Given) -> None:
        number = given.values[0]
        buffer = self.defined.sequences.get(number)
        if not buffer:
            self._about(rules.NO_SEQUENCE, given, f"sequence {number} is not defined here", given.sent[1:2])
            return
        for each in buffer:
            self._perform(each)

    def finish(self) -> None:
        """Report a sequence definition that is not ended by command D8h."""
        defined = self.defined
        if defined.defining is not None and defined.begun is not None:
            self._about(rules.UNENDED, defined.begun, "the definition of this sequence never ends: expected D8")
            self._loops(defined.sequences[defined.defining])

    def _data(self, given: Given) -> None:
        opcode, mode = given.command.opcode, self.defined.mode
        assert mode is not None, "E0, E1 and E3 are valid in streaming modes only"
        if mode.command.opcode != DATA[opcode]:
            what = f"ignored: data for mode {DATA[opcode]:02X}, but the present mode is {mode.command.opcode:02X}"
            self._about(rules.OTHER_MODE, given, what)
            return
        clock = BASE_CLOCKS[mode.values[0]] / mode.values[1]
        if opcode == 0xE0:
            for number, (velocity, distance) in enumerate(zip(given.values[::2], given.values[1::2], strict=True)):
                rate = clock * (velocity & 0x7FFF) / FULL
                if rate and distance and distance * S < rate * SHORTEST_NS:
                    pair = given.sent[1 + 4 * number : 5 + 4 * number]
                    what = f"this pair lasts {float(distance / rate * 1000):.3g} ms: expected 2 ms or more"
                    self._say(rules.SHORT_PAIR, pair, what)
        elif opcode == 0xE3:
            most = clock / 2 * mode.values[3] / 1000
            for number, distance in enumerate(given.values[1 : 1 + given.values[0]]):
                if distance != END_OF_STREAM and abs(distance) > most:
                    at = given.sent[2 + 2 * number : 4 + 2 * number]
                    what = (
                        f"{abs(distance)} pulses in {mode.values[3]} ms exceed the clock: expected at most {int(most)}"
                    )
                    self._about(rules.BEYOND_CLOCK, given, what, at)

    def _marker(self, given: Given) -> None:
        marked = self.commands.get(given.values[1])
        if not given.values[1]:
            return
        needed = Accept.STREAMING | Accept.DURING_STREAMING
        if not isinstance(marked, Opcode) or needed not in marked.accepted or marked.size > 2:
            what = (
                f"{given.values[1]:02X} cannot be in a marker: expected a command that is valid while streaming, "
                "with at most two parameters"
            )
            self._about(rules.NOT_MARKED, given, what, given.sent[3:4])

    def _about(
        self, rule: Rule, given: Given, message: str, sent: Sequence[Sent] | None = None, fix: Fix | None = None
    ) -> None:
        self._say(rule, given.sent if sent is None else sent, message, given.command.chapter, fix)

    def _say(
        self, rule: Rule, characters: Sequence[Sent], message: str, chapter: str = "", fix: Fix | None = None
    ) -> None:
        self.found.append(diagnose(rule, characters, message, chapter, fix))


def _misplaced(accepted: Flag, streaming: bool) -> tuple[Rule, str] | None:
    if not accepted & (Accept.INDEXER | Accept.STREAMING):
        return rules.ONLY_IN_SEQUENCE, "is valid in a sequence only"
    if not streaming and Accept.INDEXER not in accepted:
        return rules.ONLY_STREAMING, "is valid in a streaming mode only"
    if streaming and Accept.STREAMING not in accepted:
        return rules.NOT_STREAMING, "is not valid in a streaming mode"
    return None


def _called(command: Opcode) -> str:
    return f"{name_of(command)} ({command.opcode:02X})"
