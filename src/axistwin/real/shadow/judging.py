"""Judges a pair of answers: the same, a matter of timing, something only the machine can know, or a finding."""

from collections import deque
from typing import NamedTuple

from axistwin.core.units import MS, S
from axistwin.real.shadow.dialects.dialect import Dialect, Reading, Taken
from axistwin.real.shadow.findings import Findings, Kind
from axistwin.real.shadow.learning import Learned
from axistwin.real.shadow.moves import Moves
from axistwin.real.shadow.talk import Answer, Command

LEARNS = 12
HELD_NS = 100 * MS
"""An answer that the twin holds back for longer, e.g. behind a ramp calculation, is a kind of its own."""
SPREADS = 6
AROUND_NS = 120 * MS  # Time by which the machine's motion may be ahead or behind.
LOST_S = 1.0  # Lag of a position in motion that is a finding before the end of the move.
TIMES_NS, MOST_TIMES = 400 * MS, 1000
SOON_NS = 25 * MS
SUSPECT_NS = 5 * S  # Time within which a request tells the cause of a fault that the machine only hints at.
MOST_KNOWN = 2000
SWITCH_LEARNS = 1  # Stops at a limit switch from which its position is learnt.
SWITCH_GRAIN = 5  # Pulses by which a switch may open earlier or later.
NOBODY = Command("unasked", "", b"")


class Suspect(NamedTuple):
    """An answer whose cause is not told yet."""

    due_ns: int
    command: Command
    kind: Kind
    words: str


class Switch:
    """A limit switch of the machine, which the twin has where it was stopped.

    Where the twin stands then is where the machine stands, so a first error of its place does not matter.
    """

    def __init__(self, position: int) -> None:
        self.position, self.stops = position, 0  # `stops`: times that both have stopped there.
        self.moved = False  # True if it has been placed anew during the present stop.


class Judge:
    """Compares answers by the family's reading of them, and remembers differences that are known."""

    def __init__(self, dialect: Dialect, findings: Findings, learned: Learned, moves: Moves, tolerance_ns: int) -> None:
        self._dialect, self._findings, self._learned, self._moves = dialect, findings, learned, moves
        self._tolerance_ns = tolerance_ns
        self._times: deque[tuple[Answer, Answer]] = deque(maxlen=MOST_TIMES)
        self._known: set[str] = set()  # Commands whose answers have been equal, or taken over.
        self._accepted: dict[str, tuple[object, object]] = {}  # The twin's and the machine's answer, where they differ.
        self._offsets: dict[str, int] = {}  # The machine's number minus the twin's.
        self._positions: dict[str, int] = {}
        self._started_ns = 0  # The time of the last command that may begin a motion.
        self._manual = False
        self._retaken: set[str] = set()  # Commands whose position was read since a person has moved the axes.
        self._told: set[str] = set()  # Commands whose position was a finding.
        self._suspect: Suspect | None = None
        self._fault_ns = -SUSPECT_NS
        self._switches: dict[tuple[str, int], Switch] = {}
        self._at_limit = False
        self._halted_ns = 0
        self._halted: tuple[str, int, int] | None = None  # Where the twin was stopped, because the machine rests.
        self._begun = True
        self._excused = False  # True if a person or a switch has ended the present motion.
        self._twin_private = False
        self._unlike = False  # True if the machine's first moves have ended before the twin's.

    def forget(self) -> None:
        """The machine's state is new: nothing is known of it."""
        self._known.clear()
        self._accepted.clear()
        self._offsets.clear()
        self._positions.clear()
        self._suspect, self._at_limit, self._unlike = None, False, False
        self._unlearn()

    def _unlearn(self) -> None:
        """Where the machine stands is not known exactly: its next stop at a switch tells it again."""
        for switch in self._switches.values():
            switch.stops = 0

    def heard(self, time_ns: int, command: Command) -> None:
        if self._dialect.machine_positions:
            self._manual = True
            self._retaken.clear()
        if command.starts:
            self._started_ns = time_ns
            for switch in self._switches.values():
                if switch.moved:  # The twin was stopped otherwise: its own next stop there is learnt first.
                    switch.stops, switch.moved = 0, False
            self._begun, self._at_limit, self._excused = True, False, False

    def tick(self, now_ns: int) -> None:
        while self._times and now_ns - self._times[0][0].time_ns > TIMES_NS:
            self._time(*self._times.popleft())
        suspect = self._suspect
        if suspect is not None and now_ns > suspect.due_ns:
            self._suspect = None
            if abs(now_ns - self._fault_ns) > 6 * SUSPECT_NS:
                self._add(suspect.kind, suspect.command, suspect.command.name, suspect.words, now_ns)

    # Times

    def time(self, machine: Answer, twin: Answer) -> None:
        """Note when both have answered; it is judged a little later, when the relay has told of its own delays."""
        if machine.asked is not None:
            self._times.append((machine, twin))

    def blind(self, since_ns: int, until_ns: int) -> None:
        """The relay itself was late: times between these say nothing about the machine."""
        self._times = deque(pair for pair in self._times if not since_ns <= pair[0].time_ns <= until_ns)
        self._moves.excuse()

    def _time(self, machine: Answer, twin: Answer) -> None:
        assert machine.asked is not None
        command, late_ns = machine.asked.command, machine.time_ns - twin.time_ns
        held = " held" if twin.time_ns - machine.asked.time_ns > HELD_NS else ""
        key = f"late {command.name}{' echo' if machine.asked.echo else ''}{held}"
        usual = self._learned.usual(key, LEARNS)
        tolerance = max(self._tolerance_ns, SPREADS * usual.spread)
        if usual.add(machine.time_ns, late_ns, late_ns, tolerance):
            by_ns = late_ns - usual.median if abs(late_ns - usual.median) > tolerance else usual.drift
            how = "later" if by_ns > 0 else "earlier"
            words = f"{command.text} is answered {abs(by_ns) / MS:.0f} ms {how} than usual"
            self._add(Kind.LATE, command, command.name, words, machine.time_ns)

    # Contents

    def agree(self, machine: Answer, twin: Answer) -> bool:
        """Return True if the answers agree at first sight; False: `differing` judges them later."""
        command = _command(machine)
        if machine.asked is not None and machine.asked.echo:
            return machine.data == twin.data
        theirs, ours = self._read(command, machine), self._read(command, twin)
        if theirs.busy is not None:
            self._moves.machine(_asked_ns(machine), theirs.busy)
        if machine.data == twin.data:
            self._good(command.name, theirs)
            return True
        return theirs == ours or theirs.fixed is ours.fixed is theirs.position is theirs.busy is None

    def wait_ns(self, machine: Answer, twin: Answer) -> int:
        """Return how long a difference must wait until the twin's motion around it is known.

        What tells why the machine stops, the twin must know soon; nothing changes while both rest.
        """
        if self.rested(twin) or self._comes_to_rest(twin):
            return 0
        return SOON_NS if self._stops(machine, twin) else AROUND_NS

    def _stops(self, machine: Answer, twin: Answer) -> bool:
        command = _command(machine)
        theirs, ours = self._read(command, machine), self._read(command, twin)
        return command is not NOBODY and (theirs.fixed != ours.fixed or (theirs.busy is False and bool(ours.busy)))

    def _read(self, command: Command, answer: Answer) -> Reading:
        return self._dialect.read(None if command is NOBODY else command, answer.data)

    def _good(self, name: str, reading: Reading) -> None:
        if len(self._known) < MOST_KNOWN:
            self._known.add(name)
        self._accepted.pop(name, None)
        self._offsets.pop(name, None)
        if self._suspect is not None and name in (self._suspect.command.name, *self._dialect.causes):
            self._suspect = None  # Both say the same again: the twin was only later.
        if reading.position is not None:
            self._positions[name] = reading.position
            self._confirm()

    def _confirm(self) -> None:
        """Both have stopped at the limit switch where the twin expected it."""
        twin = self._dialect.twin
        switch = self._switches.get(twin.busiest()) if self._begun and self._switches else None
        if switch is not None and not twin.busy and twin.at_limit(*twin.busiest()):
            switch.stops += 1
            self._begun = False

    def rested(self, twin: Answer) -> bool:
        """Return True if both rest, as far as the answers up to now say; to be asked at the time of the answer."""
        return not twin.busy and self._machine_rests()

    def _comes_to_rest(self, twin: Answer) -> bool:
        """True if the machine stands at a limit switch, and the twin is about to, at a known place."""
        return bool(twin.total) and twin.busy and self._at_limit and self._machine_rests()

    def _machine_rests(self) -> bool:
        move = self._moves.now
        return move is None or move.clear_ns is not None

    @property
    def unsettled(self) -> bool:
        """True while the machine may have settings from before the twin's beginning, which no answer shows."""
        unlike = self._unlike and not self._moves.cleared_ns
        return unlike or (self._dialect.needs_joining and not self._moves.trusted)

    def hurry(self, now_ns: int) -> None:
        """The machine's settings let it arrive earlier: end the twin's move."""
        self._moves.hurried(now_ns, self._dialect.twin.left_ns)
        self._dialect.twin.hurry()
        self._twin_private = True

    def differing(self, machine: Answer, twin: Answer, now_ns: int, *, rested: bool = False) -> bool:
        """Judge a difference; return True if the twin's time has gone on meanwhile, by a private request."""
        self._twin_private = False
        command = _command(machine)
        theirs, ours = self._read(command, machine), self._read(command, twin)
        if machine.asked is not None and machine.asked.echo:
            self._differs(command, machine, twin)
        elif theirs.fixed != ours.fixed:
            if not (theirs.soft and (self._in_motion(machine) or self._excused or self._at_limit)):
                self._fixed(command, machine, twin)
        elif theirs.position is not None and ours.position is not None:
            self._position(command, machine, twin, theirs, ours, rested=rested)
        elif theirs.busy is not None and theirs.busy is not ours.busy:
            self._busy(command, machine, now_ns, busy=theirs.busy)
        return self._twin_private

    def _in_motion(self, machine: Answer) -> bool:
        at_ns = _asked_ns(machine)
        return self._moves.moved(at_ns - AROUND_NS, machine.time_ns + AROUND_NS) or self._moves.machine_busy()

    def _busy(self, command: Command, machine: Answer, now_ns: int, *, busy: bool) -> None:
        """Busy or clear: usually a matter of when a move ends, which `moves` measures."""
        at_ns, twin = _asked_ns(machine), self._dialect.twin
        move = self._moves.now
        meant = move is not None and move.began_ns < at_ns and not self._dialect.machine_positions
        if not busy and meant and twin.busy and twin.left_ns > AROUND_NS:
            if self.unsettled and twin.ends:
                self.hurry(now_ns)
            elif self._started_ns < machine.time_ns:
                self._stop(command, machine)
        if not busy or self._moves.now is not None or self._moves.moved(at_ns - 2 * S, at_ns + AROUND_NS):
            return
        if at_ns < self._moves.cleared_ns:
            return  # The end of a move that took longer than the twin's.
        subject, words = f"{command.name} busy", f"{command.text}: the machine moves, the twin rests"
        if self._dialect.machine_positions or (not self._moves.trusted and command.name not in self._known):
            self._note(subject, words, machine.time_ns)
        else:
            self._add(Kind.ANSWER, command, subject, words, machine.time_ns)

    def _stop(self, command: Command, machine: Answer) -> None:
        """The machine rests long before the twin: stop it, too, and wait for the cause."""
        twin = self._dialect.twin
        axis, direction = twin.busiest()
        self._halted = axis, direction, twin.position(axis)
        self._halted_ns, self._excused = machine.time_ns, True
        words = f"the motion ends {twin.left_ns / S:.1f} s before the twin's"
        self._dialect.halt()
        self._moves.excuse()
        if not (self._moves.trusted or self._moves.cleared_ns):
            self._unlike = True
            self._note("settings", f"{words}, as it may have settings from before", machine.time_ns)
        elif self._suspect is None and machine.time_ns - self._fault_ns > SUSPECT_NS:
            self._suspect = Suspect(machine.time_ns + SUSPECT_NS, command, Kind.DURATION, words)

    def _fixed(self, command: Command, machine: Answer, twin: Answer) -> None:
        if command is not NOBODY and self._take(command, machine, twin):
            return
        if self._dialect.unexplained(command, machine.data):
            if self._suspect is None and machine.time_ns - self._fault_ns > SUSPECT_NS:
                shown = self._dialect.show(machine.data)
                words = f"{command.text}: the machine answers {shown}, and the twin knows no cause"
                self._suspect = Suspect(machine.time_ns + SUSPECT_NS, command, Kind.FAULT, words)
            return
        theirs, ours = self._read(command, machine).fixed, self._read(command, twin).fixed
        if self._accepted.get(command.name) == (ours, theirs):
            return
        if type(theirs) is type(ours) is int:
            by = theirs - ours
            if self._offsets.get(command.name) == by:
                return
            self._offsets[command.name] = by
        self._accepted[command.name] = ours, theirs
        if command is not NOBODY and not self._moves.trusted and command.name not in self._known:
            self._known.add(command.name)
            self._note(
                command.name,
                f"{command.text}: {self._dialect.show(machine.data)} is taken from the machine",
                machine.time_ns,
            )
        else:
            self._differs(command, machine, twin)

    def _take(self, command: Command, machine: Answer, twin: Answer) -> bool:
        if self._dialect.twin.busy and self._started_ns > machine.time_ns:
            # The twin moves again: what it says now belongs to the next motion.
            self._unlearn()
            return True
        axis, direction = self._dialect.twin.busiest()
        at, moving, before_ns = self._dialect.twin.position(axis), self._dialect.twin.busy, self._dialect.twin.now
        was_open = self._dialect.twin.at_limit(axis, direction)
        found = self._dialect.take(command, machine.data, twin.data)
        self._twin_private |= self._dialect.twin.now != before_ns
        for taken in found:
            self._tell(command, taken, machine)
            if taken.subject == "clear" and self._started_ns >= machine.time_ns and self._moves.command is not None:
                self._dialect.twin.write(self._moves.command.data)  # The twin has refused it.
            if "limit" in taken.subject and taken.stops:
                self._at_limit = True
                halted = self._halted if machine.time_ns - self._halted_ns < SUSPECT_NS else None
                if halted is not None:
                    axis, direction, at = halted
                if (moving or halted) and not was_open:  # It was not stopped by a switch of its own.
                    self._place(axis, direction, at)
        return bool(found)

    def _tell(self, command: Command, taken: Taken, machine: Answer) -> None:
        self._suspect = None
        if taken.stops:
            self._moves.excuse()
            self._excused = True
            if "limit" not in taken.subject:
                self._unlearn()
        if taken.fault and taken.subject in self._dialect.unread and self.unsettled and command.name not in self._known:
            self._note(taken.subject, f"{taken.text} from before", machine.time_ns)
        elif taken.fault:
            if machine.time_ns - self._fault_ns > SUSPECT_NS or taken.subject == command.name:
                self._add(Kind.FAULT, command, taken.subject, taken.text, machine.time_ns)
            self._fault_ns = machine.time_ns
        else:
            self._note(taken.subject, taken.text, machine.time_ns)

    def _differs(self, command: Command, machine: Answer, twin: Answer) -> None:
        got, expected = self._dialect.show(machine.data), self._dialect.show(twin.data)
        kind, what = Kind.ANSWER, f"answers {got}, the twin {expected}"
        if by := _characters(machine.data, twin.data):
            kind = Kind.CHARACTERS
            what = f"{abs(by)} character{'s' * (abs(by) > 1)} {'too many' if by > 0 else 'missing'}: {what}"
        short = len(machine.data) < 6 and not machine.data.strip().isdigit()
        subject = f"{command.name} {expected} {got}" if short else command.name
        words = f"{command.text} {what}" if kind is Kind.ANSWER else f"{command.text}: {what}"
        self._add(kind, command, subject, words, machine.time_ns, expected, got)

    # Positions

    def _position(
        self, command: Command, machine: Answer, twin: Answer, theirs: Reading, ours: Reading, *, rested: bool
    ) -> None:
        assert theirs.position is not None and ours.position is not None
        name, by = command.name, theirs.position - ours.position
        if self._comes_to_rest(twin) and not theirs.encoder:
            # The twin still comes to rest at the switch, where the machine stands: compare where both stop.
            by = theirs.position - (twin.total if theirs.ahead else ours.position + twin.left)
            rested = True
        off = min(abs(by), abs(by - self._offsets.get(name, 0)))
        before, self._positions[name] = self._positions.get(name), theirs.position
        if self.unsettled and (self._moves.says_busy or _asked_ns(machine) < self._moves.cleared_ns):
            if self._moves.now is None:
                self._known.discard(name)  # A motion from before the twin's beginning ends at a place of its own.
            return
        if not rested and self._in_motion(machine):
            speed = max(twin.speed, self._dialect.twin.speed)
            lost = off > theirs.moving_grain + theirs.grain + max(speed, 1.0) * LOST_S and speed > 0
            if not lost or self.unsettled or self._excused or self._dialect.machine_positions:
                return
        elif off <= theirs.grain:
            if abs(by) > theirs.grain and self._begun and self._offsets.get(name) == by:
                self._again(command, machine, by)
            return
        elif (
            not rested
            and self._moves.now is not None
            and self._moves.now.clear_ns is None
            and before != theirs.position
        ):
            return  # The machine has not said yet that it rests.
        self._count(command, machine, twin, by)

    def _again(self, command: Command, machine: Answer, by: int) -> None:
        self._begun = False
        if command.name in self._told and not (self._excused or self._at_limit or self._dialect.machine_positions):
            self._add(Kind.COUNT, command, command.name, f"{command.text} differs by {by}", machine.time_ns)

    def _count(self, command: Command, machine: Answer, twin: Answer, by: int) -> None:
        """A position at rest differs: take it over, and tell it once."""
        name, where = command.name, self._dialect.show(machine.data)
        first, self._begun = self._begun, False
        reading = self._read(command, machine)
        explained = self._dialect.take(command, machine.data, twin.data)
        limited = self._limit_stopped(command, machine, by, first=first)
        if limited:
            pass
        elif self._excused or self._at_limit or self._suspect or self._by_hand(name):
            words = f"the twin was {abs(by)} {'before' if by > 0 else 'beyond'} the machine"
            self._note(f"{name} stopped", f"{command.text}: {words}", machine.time_ns)
        elif explained:
            for taken in explained:
                self._note(taken.subject, taken.text, machine.time_ns)
        elif not self._moves.trusted and name not in self._known:
            self._note(name, f"{command.text}: {where} is taken from the machine", machine.time_ns)
        else:
            self._told.add(name)
            words = f"{command.text} is {where}, {by:+} from the twin's {self._dialect.show(twin.data)}"
            self._add(Kind.COUNT, command, name, words, machine.time_ns, self._dialect.show(twin.data), where)
        self._known.add(name)
        if not self._dialect.machine_positions:
            self._retaken.add(name)
        before_ns = self._dialect.twin.now
        placed = reading.position is not None and self._dialect.set_position(command, reading.position)
        if placed:
            self._offsets.pop(name, None)
        else:
            self._offsets[name] = by
        if (placed or (first and reading.ahead)) and not limited and not self._at_limit:
            self._shift(by, reading)
        self._twin_private |= self._dialect.twin.now != before_ns

    def _by_hand(self, name: str) -> bool:
        """True for a position that has not been read since a person, or another machine, has moved the axes."""
        return self._dialect.machine_positions or (self._manual and name not in self._retaken)

    def _limit_stopped(self, command: Command, machine: Answer, by: int, *, first: bool) -> bool:
        """The motion has ended at a limit switch that the twin has learnt: tell if it has moved."""
        twin = self._dialect.twin
        axis, direction = twin.busiest()
        switch = self._switches.get((axis, direction))
        if switch is None or not twin.at_limit(axis, direction):
            return False
        reading = self._read(command, machine)
        if not first or reading.encoder or abs(by) <= SWITCH_GRAIN:
            return True
        switch.stops += 1
        if switch.stops > SWITCH_LEARNS:
            further = by if reading.ahead else direction * by
            when, side = "late" if further > 0 else "early", "+" if direction > 0 else "-"
            words = f"the limit {axis}{side} opens {abs(by)} pulses {when}"
            self._add(Kind.COUNT, command, f"limit {axis}{direction:+d}", words, machine.time_ns)
        return True

    def _place(self, axis: str, direction: int, position: int) -> None:
        before = self._switches.get((axis, direction))
        switch = self._switches[axis, direction] = Switch(position)
        if before is not None:
            switch.stops, switch.moved = before.stops, True
        self._dialect.twin.set_limit(axis, direction, position)

    def _shift(self, by: int, reading: Reading) -> None:
        """The twin stands elsewhere than the machine: its switches are where it would meet them from there."""
        axis, direction = self._dialect.twin.busiest()
        for (name, side), switch in self._switches.items():
            if name == axis and not reading.encoder:
                switch.position -= by * direction if reading.ahead else by
                self._dialect.twin.set_limit(name, side, switch.position)

    # Answers without a partner

    def missing(self, answer: Answer) -> None:
        command = _command(answer)
        words = (
            f"{command.text} is not answered" if answer.asked else f"{self._dialect.show(answer.data)} does not come"
        )
        self._add(Kind.MISSING, command, command.name, words, answer.time_ns, self._dialect.show(answer.data))

    def surplus(self, answer: Answer) -> None:
        command = _command(answer)
        words = f"{self._dialect.show(answer.data)} comes unasked"
        if self._moves.trusted or "surplus" in self._known:
            self._add(Kind.SURPLUS, command, command.name, words, answer.time_ns, got=self._dialect.show(answer.data))
        else:
            self._known.add("surplus")
            self._note("surplus", words, answer.time_ns)

    def _add(
        self, kind: Kind, command: Command, subject: str, words: str, time_ns: int, expected: str = "", got: str = ""
    ) -> None:
        self._findings.add(kind, subject, words, time_ns, section=command.section, expected=expected, got=got)

    def _note(self, subject: str, words: str, time_ns: int) -> None:
        self._findings.add(Kind.NOTE, subject, words, time_ns)


def _command(answer: Answer) -> Command:
    return NOBODY if answer.asked is None else answer.asked.command


def _asked_ns(answer: Answer) -> int:
    return answer.time_ns if answer.asked is None else answer.asked.time_ns


def _characters(machine: bytes, twin: bytes) -> int:
    """Return by how many characters the machine's answer is longer, if it is the same but for these; else 0."""
    short, long = sorted((machine, twin), key=len)
    by = len(long) - len(short)
    if not 0 < by <= 2 or not _within(short, long) or (short.strip().isdigit() and long.strip().isdigit()):
        return 0
    return by if len(machine) > len(twin) else -by


def _within(short: bytes, long: bytes) -> bool:
    rest = iter(long)
    return all(byte in rest for byte in short)
