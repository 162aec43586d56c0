"""Diagnostics of a host's commands without running them: everything that an 1810 or 1811 would ignore.

`check` follows the host from power-on to power-off: definitions, the mode in force, the contents of sequences.  A board
ignores wrong commands without a message, so all of them are reported.
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
from axistwin.units import MS, S

DEFINITIONS = tuple(Kind)
LOOPS = (0x20, 0x21)
NEED_DEFAULT = {0x32: "move", 0x33: "move", 0x34: "move", 0x35: "move", 0x36: "move", 0x39: "search", 0x3A: "search"}
NEED_LOOP = (0x35, 0x36)
LOOP_PARAMETERS = {0xB0: "ratio", 0xB1: "resolution", 0xB2: "sigma", 0xB3: "algorithm", 0xB4: "teeth"}
RATIO, RESUME = 0xB0, 0x37
DATA = {0xE0: 0x51, 0xE1: 0x52, 0xE3: 0x53}
"""Streaming data, and the mode it is for."""
END_OF_STREAM = -0x7FFF
SHORTEST_NS = 2 * MS
"""The shortest duration of a velocity-distance pair."""


@dataclass(frozen=True)
class Given:
    """A command as sent, with its values and the place of each of its bytes."""

    command: Opcode
    values: tuple[Any, ...]
    sent: Sequence[Sent]


@dataclass
class Known:
    """The definitions and the mode of the board after the commands so far."""

    moves: dict[int, int] = field(default_factory=dict)
    """By number, the opcodes that define them."""
    sequences: dict[int, list[Given]] = field(default_factory=dict)
    defining: int | None = None
    begun: Given | None = None
    default: bool = False
    home: bool = False
    loop: set[int] = field(default_factory=set)
    mode: Given | None = None
    """The command that entered the streaming mode; None: indexer mode."""
    triggers: dict[int, int] = field(default_factory=dict)


def check(commands: CommandSet, sessions: Sequence[Session]) -> list[Diagnostic]:
    """Return everything wrong with the commands of a host, in order of place.  Each line is one command."""
    found: set[Diagnostic] = set()
    for session in sessions:
        checker = _followed(commands, session)
        checker.finish()
        found |= set(checker.found)
    return sorted(found)


def acceptable(commands: CommandSet, session: Session) -> list[Opcode]:
    """Return the commands that may follow those of this session."""
    known = _followed(commands, session).known

    def may_follow(accepted: Flag) -> bool:
        if known.defining is not None:
            return bool(accepted & (Accept.SEQUENCE | Accept.DEFINING))
        return bool(accepted) and _misplaced(accepted, known.mode is not None) is None

    return [command for command in commands if isinstance(command, Opcode) and may_follow(command.accepted)]


def _followed(commands: CommandSet, session: Session) -> "_Checker":
    checker = _Checker(commands)
    for _, line in groupby(session.characters, key=lambda sent: sent.line):
        checker.take(list(line))
    return checker


class _Checker:
    def __init__(self, commands: CommandSet) -> None:
        self.commands, self.known = commands, Known()
        self.found: list[Diagnostic] = []

    def take(self, sent: Sequence[Sent]) -> None:
        """Check one command."""
        command = self.commands.get(sent[0].byte)
        if not isinstance(command, Opcode):
            self._say(rules.NO_COMMAND, sent[:1], f"no command {sent[0].byte:02X}: it is ignored")
        elif (values := self._values(command, sent)) is not None:
            self._place(Given(command, values, sent))

    def _values(self, command: Opcode, sent: Sequence[Sent]) -> tuple[Any, ...] | None:
        """Return the values for the handler, or None after a diagnostic."""
        here = sent[1:]
        if len(sent) > LONGEST:
            self._say(rules.TOO_LONG, sent[LONGEST:], f"the input data buffer holds {LONGEST} bytes")
            return None
        if len(here) < command.size:
            wanted = f"{command.size} parameter byte{'s' * (command.size != 1)}"
            message = f"{_called(command)} takes {wanted}, {len(here)} here"
            self._say(rules.TOO_SHORT, sent[-1:], message, command.chapter)
            return None
        for surplus in here[command.size :]:
            if surplus.byte:
                what = f"{_called(command)} takes {command.size} parameter bytes, any more must be 00"
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
                self._say(rules.RANGE, part, f"{data.hex(' ').upper()} is out of range: {parameter}", command.chapter)
                return None
            if not isinstance(parameter, DontCare):
                values.append(value)
            at += parameter.size
        return tuple(values)

    def _place(self, given: Given) -> None:
        accepted, known = given.command.accepted, self.known
        if not accepted:
            self._about(rules.NOTHING, given, f"{_called(given.command)} does nothing")
        elif known.defining is not None and Accept.DEFINING not in accepted:
            if Accept.SEQUENCE in accepted:
                known.sequences[known.defining].append(given)
                self._value_rules(given)
            else:
                self._say(rules.NOT_IN_SEQUENCE, given.sent, f"{_called(given.command)} may not stand in a sequence")
        elif wrong := _misplaced(accepted, known.mode is not None):
            rule, what = wrong
            self._about(rule, given, f"{_called(given.command)} {what}")
        else:
            self._value_rules(given)
            self._follow(given)

    def _value_rules(self, given: Given) -> None:
        """Check values that are in range each, but impossible together."""
        opcode, values = given.command.opcode, given.values
        if opcode in DEFINITIONS:
            self._move_rules(given, *values[1:4])
            if values[0] > 50:
                message = f"move {values[0]} is not kept: there are moves 1 to 50"
                self._about(rules.NO_SUCH_MOVE, given, message, given.sent[1:2])
        elif opcode == 0x31 and any(values[1:]):
            self._move_rules(given, *values)
        elif opcode == 0xEE:
            self._marker(given)

    def _move_rules(self, given: Given, ranges: tuple[int, int], velocity: int, acceleration: int) -> None:
        at = given.sent[3:7]  # the velocity, in all of these commands
        if Move(Kind.CONTINUOUS, ranges, velocity, acceleration).rate is None:
            most = VELOCITY_RANGES[ranges[0]].highest
            self._about(rules.VELOCITY, given, f"velocity {velocity} is beyond range {ranges[0]}: {most} at most", at)
        elif not acceleration:
            self._about(rules.ACCELERATION, given, "with acceleration 0 this move is never performed")

    def _follow(self, given: Given) -> None:
        opcode, values, known = given.command.opcode, given.values, self.known
        match opcode:
            case 0xD9:
                known.defining, known.begun = values[0], given
                known.sequences[values[0]] = []
            case 0xD8:
                self._end_definition(given)
            case 0xDA:
                known.sequences.pop(values[0], None)
            case 0xD7:
                known.moves.pop(values[0], None)
            case 0x41:
                self._perform_sequence(given)
            case 0x50:
                known.mode = None
            case 0x51 | 0x52 | 0x53:
                known.mode, known.sequences = given, {}
            case 0xE0 | 0xE1 | 0xE3:
                self._data(given)
            case _:
                self._perform(given)

    def _perform(self, given: Given) -> None:
        """Follow a command as it is performed, from the host or from a sequence."""
        opcode, values, known = given.command.opcode, given.values, self.known
        if opcode in DEFINITIONS:
            known.moves[values[0]] = opcode
        elif opcode in LOOP_PARAMETERS:
            known.loop.add(opcode)
        elif opcode == 0x31:
            known.default = any(values[1:])
        elif opcode == 0x38:
            known.home = True
        elif opcode == 0x40:
            self._perform_move(given)
        elif opcode in NEED_DEFAULT:
            self._needs(given)
        elif 0x74 <= opcode <= 0x7F or opcode == 0xAC:
            self._trigger(given)

    def _perform_move(self, given: Given) -> None:
        number, known = given.values[0], self.known
        if number not in known.moves:
            self._about(rules.NO_MOVE, given, f"move {number} is not defined here", given.sent[1:2])
        elif known.moves[number] in CLOSED_LOOP and self.commands.get(RESUME) is None:
            what = f"not performed: move {number} is a closed-loop move, and an 1810 has no encoder"
            self._about(rules.NO_ENCODER, given, what)
        elif known.moves[number] in CLOSED_LOOP and RATIO not in known.loop:
            what = f"ignored: B0 (ratio) has not been given, and move {number} is a closed-loop move"
            self._about(rules.NOT_GIVEN, given, what)

    def _needs(self, given: Given) -> None:
        opcode, known = given.command.opcode, self.known
        missing = [] if known.default else ["31 (default velocity and acceleration)"]
        if opcode in (0x39, 0x3A) and not known.home:
            missing.append("38 (define home)")
        if opcode in NEED_LOOP:
            missing += [f"{code:02X} ({name})" for code, name in LOOP_PARAMETERS.items() if code not in known.loop]
        if missing:
            self._about(rules.NOT_GIVEN, given, f"ignored: {', '.join(missing)} has not been given")

    def _trigger(self, given: Given) -> None:
        opcode, known = given.command.opcode, self.known
        if len(given.values) < 2:
            return
        trigger, on = given.values[:2]
        busy = known.triggers.get(trigger)
        if not on:
            if busy == opcode:
                del known.triggers[trigger]
        elif busy not in (None, opcode):
            what = f"ignored: trigger {trigger} has a function, {busy:02X}, that must be disabled first"
            self._about(rules.TRIGGER, given, what)
        else:
            known.triggers[trigger] = opcode

    def _end_definition(self, given: Given) -> None:
        known = self.known
        if known.defining is None:
            whole = fixing("leave it out", replaced(given.sent, ""), sure=False)
            self._about(rules.NOT_DEFINING, given, "no sequence is being defined", fix=whole)
            return
        self._loops(known.sequences[known.defining])
        known.defining = None

    def _loops(self, buffer: Sequence[Given]) -> None:
        inside = 0
        for at, given in enumerate(buffer):
            if given.command.opcode not in LOOPS:
                inside = max(0, inside - 1)
                continue
            count, left = given.values[0], len(buffer) - at - 1
            if inside:
                self._say(rules.NESTED, given.sent, "ignored: a loop may not stand within another one")
                inside -= 1
                continue
            if count > left:
                self._about(rules.LOOP_TOO_LONG, given, f"the loop is to repeat {count} commands, but {left} follow")
            inside = count

    def _perform_sequence(self, given: Given) -> None:
        number = given.values[0]
        buffer = self.known.sequences.get(number)
        if not buffer:
            self._about(rules.NO_SEQUENCE, given, f"sequence {number} is not defined here", given.sent[1:2])
            return
        for each in buffer:
            self._perform(each)

    def finish(self) -> None:
        """Check for an unfinished definition after the last command."""
        known = self.known
        if known.defining is not None and known.begun is not None:
            self._about(rules.UNENDED, known.begun, "the definition of this sequence never ends: D8 is missing")
            self._loops(known.sequences[known.defining])

    def _data(self, given: Given) -> None:
        opcode, mode = given.command.opcode, self.known.mode
        assert mode is not None, "only then it is valid"
        if mode.command.opcode != DATA[opcode]:
            what = f"ignored: this data is for mode {DATA[opcode]:02X}, in force is {mode.command.opcode:02X}"
            self._about(rules.OTHER_MODE, given, what)
            return
        clock = BASE_CLOCKS[mode.values[0]] / mode.values[1]
        if opcode == 0xE0:
            for number, (velocity, distance) in enumerate(zip(given.values[::2], given.values[1::2], strict=True)):
                rate = clock * (velocity & 0x7FFF) / FULL
                if rate and distance and distance * S < rate * SHORTEST_NS:
                    pair = given.sent[1 + 4 * number : 5 + 4 * number]
                    what = f"this pair lasts {float(distance / rate * 1000):.3g} ms: each must last 2 ms at least"
                    self._say(rules.SHORT_PAIR, pair, what)
        elif opcode == 0xE3:
            most = clock / 2 * mode.values[3] / 1000
            for number, distance in enumerate(given.values[1 : 1 + given.values[0]]):
                if distance != END_OF_STREAM and abs(distance) > most:
                    at = given.sent[2 + 2 * number : 4 + 2 * number]
                    what = f"{abs(distance)} pulses in {mode.values[3]} ms are beyond the clock: {int(most)} at most"
                    self._about(rules.BEYOND_CLOCK, given, what, at)

    def _marker(self, given: Given) -> None:
        marked = self.commands.get(given.values[1])
        if not given.values[1]:
            return
        needed = Accept.STREAMING | Accept.DURING_STREAMING
        if not isinstance(marked, Opcode) or needed not in marked.accepted or marked.size > 2:
            what = (
                f"{given.values[1]:02X} cannot be marked: it must be valid while streaming, with two parameters at most"
            )
            self._about(rules.NOT_MARKED, given, what, given.sent[3:4])

    def _about(
        self, rule: Rule, given: Given, message: str, sent: Sequence[Sent] | None = None, fix: Fix | None = None
    ) -> None:
        """Report a finding about a command, or about some of its bytes, with the command's chapter."""
        self._say(rule, given.sent if sent is None else sent, message, given.command.chapter, fix)

    def _say(
        self, rule: Rule, characters: Sequence[Sent], message: str, chapter: str = "", fix: Fix | None = None
    ) -> None:
        self.found.append(diagnose(rule, characters, message, chapter, fix))


def _misplaced(accepted: Flag, streaming: bool) -> tuple[Rule, str] | None:
    """Return the reason why this mode ignores a command outside of a sequence definition, or None."""
    if not accepted & (Accept.INDEXER | Accept.STREAMING):
        return rules.ONLY_IN_SEQUENCE, "means something in a sequence only"
    if not streaming and Accept.INDEXER not in accepted:
        return rules.ONLY_STREAMING, "is for the streaming modes"
    if streaming and Accept.STREAMING not in accepted:
        return rules.NOT_STREAMING, "is not valid in a streaming mode"
    return None


def _called(command: Opcode) -> str:
    return f"{name_of(command)} ({command.opcode:02X})"
