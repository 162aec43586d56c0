"""The shadow: a twin that follows the host's requests, and the comparison of its answers with the machine's.

Pure: times are arguments, in nanoseconds since 1970, and must not go back.  `host`, `machine` and `tick` are all there
is to call.  The twin's virtual time is the time of the arguments plus a constant, which changes only when the twin is
brought into the machine's state.
"""

from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from axistwin.core.units import MS, S
from axistwin.real.shadow.dialects.dialect import dialect_for
from axistwin.real.shadow.findings import TOLERANCE_NS, Finding, Findings, Kind
from axistwin.real.shadow.judging import HELD_NS, Judge
from axistwin.real.shadow.learning import Learned
from axistwin.real.shadow.moves import Moves, Timed
from axistwin.real.shadow.pairing import Pairing
from axistwin.real.shadow.talk import QUIET_NS, TYPING_NS, Answer, Command, Messages
from axistwin.real.shadow.twin import STEP_NS, Twin

AWAKE_NS = 200 * MS  # Time after a request during which the twin is watched step by step.
SILENT_AFTER = 3  # Missing answers after which the machine counts as switched off.
BLIND_NS = 50 * MS
UNHEARD_NS = 300 * MS
BOOT_S = 2.0
REMEMBERED_NS = 3 * S
MOST_HOST = 4096
EARLY_NS = 50 * MS  # Time by which an answer may be seen before its request, if that comes through another adapter.
STEER = 0.1  # Part of the lateness of an unasked message by which the twin's time follows the machine's.
TICK_NS = 1 * S


class Doubt(NamedTuple):
    """A pair whose difference is judged a little later, when the twin's motion around it is known."""

    due_ns: int
    machine: Answer
    twin: Answer
    rested: bool


class Shadow:
    """Compares a machine with its twin.  `tell` receives each finding, `timed` each move that both have ended."""

    def __init__(
        self, twin: Twin, tell: Callable[[Finding], object], learned: Learned | None = None, *,
        tolerance_ns: int = TOLERANCE_NS, timed: Callable[[Timed], object] = lambda timed: None,
    ) -> None:  # fmt: skip
        self.twin, self.dialect = twin, dialect_for(twin)
        self.findings, self.learned = Findings(tell), learned or Learned()
        self.moves = Moves(self.learned, tolerance_ns, timed, self._unusual)
        self.judge = Judge(self.dialect, self.findings, self.learned, self.moves, tolerance_ns)
        self._pairing = Pairing(self._both, self._alone)
        twin.owes = lambda: self._pairing.twin.owed
        form = self.dialect.message_size, self.dialect.terminators
        self._machine, self._ours = Messages(self._machine_says, *form), Messages(self._twin_says, *form)
        twin.heard = self._twin_heard
        self._ahead_ns: int | None = None  # The twin's time minus the time of the arguments.
        self._doubts: deque[Doubt] = deque(maxlen=256)
        self._host: deque[tuple[int, bytes]] = deque(maxlen=256)
        self.early_ns = 0
        self._early: deque[tuple[int, bytes]] = deque(maxlen=256)
        self._missed: list[Answer] = []
        self._awake_ns = 0
        self.following = not self.dialect.needs_joining
        self.moves.trusted = False
        self.silent_since_ns: int | None = None
        self._absent = self._away = False
        self._joined_by_echo = False  # True until the answer behind the echo has come, which is not compared either.
        self._asked_ns: int | None = None  # The time of the last request to a silent machine.
        self.pairs = self.lost = 0
        self.paired: Callable[[Answer, Answer], object] = lambda machine, twin: None

    # What happens

    def host(self, time_ns: int, data: bytes) -> None:
        """The host has sent data to the machine."""
        self.tick(time_ns)
        if self._away:
            return
        if self._absent:
            self._absent = False
            self._join(time_ns, b"", b"")
        if self.silent_since_ns is not None:
            self._unheard(time_ns, data)
        self._host.append((time_ns, data[:MOST_HOST]))
        if self.following:
            self._follow(time_ns, data)
            self._hear_early(time_ns)

    def port(self, time_ns: int, *, away: bool) -> None:
        """The port of the machine is away, or back: between them nothing reaches the machine."""
        self.tick(time_ns)
        self._away = away
        self._pairing.clear()
        self._missed.clear()
        words = "away" if away else "back"
        self.note(f"port {words}", f"the port of the machine is {words}", time_ns)

    def absent(self, time_ns: int) -> None:
        """Nobody answers at the machine's place on its bus: it is off, until the host sends something to it."""
        self.tick(time_ns)
        if not self._absent:
            self._absent = True
            self._fall_silent(time_ns)

    def _unheard(self, time_ns: int, data: bytes) -> None:
        """While the machine is silent, what precedes a request without an answer has not been heard either."""
        if self._asked_ns is not None and time_ns - self._asked_ns > UNHEARD_NS:
            self._host.clear()
            self._asked_ns = None
        if any(command.answers for command in self.dialect.commands(data)):
            self._asked_ns = time_ns

    def _follow(self, time_ns: int, data: bytes) -> None:
        for command in self.dialect.commands(data):
            self._pairing.ask(time_ns, command, echo=self.dialect.echo)
            self.judge.heard(time_ns, command)
            if command.starts:
                self.moves.start(command)
        self._machine.quiet_ns = self._ours.quiet_ns = TYPING_NS if self.dialect.echo else QUIET_NS
        self.twin.write(data)
        self._awake_ns = time_ns + AWAKE_NS

    def machine(self, time_ns: int, data: bytes) -> None:
        """The machine has sent data to the host."""
        self.tick(time_ns)
        self._machine.receive(time_ns, data)
        self._look(time_ns)

    def tick(self, now_ns: int) -> None:
        """Let the twin catch up, and judge what is due.  To be called at least every second."""
        if self._ahead_ns is None:
            self._ahead_ns = self.twin.now - now_ns
        while (here_ns := self.twin.now - self._ahead_ns) < now_ns:
            awake = here_ns < self._awake_ns or self.moves.edges[-1][1] or bool(self._doubts)
            self._run(min(now_ns, here_ns + (STEP_NS if awake else TICK_NS)))
        self._look(now_ns)

    def _run(self, until_ns: int) -> None:
        assert self._ahead_ns is not None
        self.twin.run_to(until_ns + self._ahead_ns)
        busy, ended_ns = self.twin.busy, None
        if not busy and self.moves.edges[-1][1]:
            exact_ns = self.twin.motion_ended_ns
            ended_ns = None if exact_ns is None else exact_ns - self._ahead_ns
            if ended_ns is not None and until_ns - ended_ns > 2 * STEP_NS:  # The axis rested; something else went on.
                ended_ns = None
        self.moves.twin(until_ns, busy, ended_ns)
        self._look(until_ns)

    def _look(self, now_ns: int) -> None:
        self._machine.catch_up(now_ns)
        self._ours.catch_up(now_ns)
        self._hear_early(now_ns)
        self._pairing.pair(now_ns)
        for doubt in [doubt for doubt in self._doubts if doubt.due_ns <= now_ns]:
            self._doubts.remove(doubt)
            self._steadied(self.judge.differing(doubt.machine, doubt.twin, now_ns, rested=doubt.rested), now_ns)
        self._hurry(now_ns)
        self.judge.tick(now_ns)

    def _hurry(self, now_ns: int) -> None:
        """The machine has answered what an unsettled twin still holds back behind its moves."""
        waiting, owed = self._pairing.machine.waiting, self._pairing.twin.owed
        behind = bool(waiting) and waiting[0].asked in owed and now_ns - waiting[0].time_ns > HELD_NS
        if behind and self.judge.unsettled and self.twin.ends:
            self.judge.hurry(now_ns)
            self._rebase(now_ns)

    # Answers

    def _machine_says(self, time_ns: int, data: bytes) -> None:
        self._early.append((time_ns, data))
        self._hear_early(time_ns)

    def _hear_early(self, now_ns: int) -> None:
        while self._early and (self._expects or now_ns - self._early[0][0] >= self.early_ns):
            self._hear(*self._early.popleft())

    @property
    def _expects(self) -> bool:
        return bool(self._pairing.machine.owed) or self._joined_by_echo or not self.following

    def _hear(self, time_ns: int, data: bytes) -> None:
        host = b"".join(said for when, said in self._host if time_ns - when < REMEMBERED_NS)
        last = next(reversed(host.splitlines(keepends=True)), b"")
        if self._joined_by_echo:
            self._joined_by_echo = False
        elif not self.following:
            if self.dialect.tells(last, data):
                self._join(time_ns, host if self.dialect.restarted(host, data) else last, data)
                answers = (command.answers for command in self.dialect.commands(last))
                self._joined_by_echo = self.dialect.echo and any(answers)
        elif self.dialect.restarted(last, data) and not self._pairing.twin.waiting and not self._twin_initialises():
            self.note("restart", "the machine has been switched off and on", time_ns)
            self._join(time_ns, last, data)
        else:
            self._pairing.machine.take(time_ns, data)

    def _twin_initialises(self) -> bool:
        return str(self.twin.controller.registers["state"].read()) != "ready" if self.dialect.needs_joining else False

    def _twin_heard(self, time_ns: int, data: bytes) -> None:
        if self._ahead_ns is not None:
            self._ours.receive(time_ns - self._ahead_ns, data)

    def _twin_says(self, time_ns: int, data: bytes) -> None:
        if self.following:
            self._pairing.twin.take(time_ns, data, self.twin.speed, self.twin.busy, *self.twin.pulses)

    def _both(self, machine: Answer, twin: Answer) -> None:
        self.pairs += 1
        self._blame()
        if machine.asked is None:
            self._steer(machine.time_ns - twin.time_ns)
        self.judge.time(machine, twin)
        self.paired(machine, twin)
        if self.judge.agree(machine, twin):
            return
        due_ns = max(machine.time_ns, twin.time_ns) + self.judge.wait_ns(machine, twin)
        self._doubts.append(Doubt(due_ns, machine, twin, self.judge.rested(twin)))
        self._awake_ns = max(self._awake_ns, due_ns)

    def _steer(self, late_ns: int) -> None:
        """Messages that nobody has asked for tell how far the machine's clock has drifted from the twin's."""
        if self._ahead_ns is not None and abs(late_ns) < S:
            self._ahead_ns -= int(STEER * late_ns)

    def _steadied(self, before: bool, now_ns: int) -> None:
        """The judge may have let the twin answer privately: its time goes on from here."""
        if before:
            self._rebase(now_ns)

    def _rebase(self, now_ns: int) -> None:
        self._ahead_ns = self.twin.now - now_ns

    def _alone(self, answer: Answer, ours: bool) -> None:
        """An answer without a partner.  One that the machine owes may mean that it is off."""
        if not ours:
            self._blame()
            self.judge.surplus(answer)
            return
        self._missed.append(answer)
        if len(self._missed) >= SILENT_AFTER:
            self._fall_silent(self._missed[0].time_ns)

    def _blame(self) -> None:
        """The machine answers again: what it has not answered before is missing."""
        for answer in self._missed:
            self.judge.missing(answer)
        self._missed.clear()

    # Joining and leaving

    def _fall_silent(self, time_ns: int) -> None:
        self.silent_since_ns = time_ns
        self.note("silent", "the machine does not answer: it is switched off, or the cable is open", time_ns)
        self._missed.clear()
        self.following, self._asked_ns = False, None
        self._host.clear()
        self._forget()

    def _forget(self) -> None:
        self._pairing.clear()
        self._early.clear()
        self._joined_by_echo = False
        self._doubts.clear()
        self.dialect.clear()
        self._ours.clear()
        self.moves.now, self.moves.cleared_ns = None, 0
        self.judge.forget()

    def _join(self, time_ns: int, host: bytes, data: bytes) -> None:
        """Take the machine's state of communication over; this exchange is not compared."""
        self._forget()
        self.moves.trusted = self._restart(host, data)
        if self.silent_since_ns is not None:
            seconds = (time_ns - self.silent_since_ns) / S
            self.note("back", f"the machine answers again, after {seconds:.0f} s", time_ns)
        self.silent_since_ns, self.following = None, True
        self._rebase(time_ns)
        busy = self.twin.busy
        self.moves.edges.append((time_ns, busy))

    def _restart(self, host: bytes, data: bytes) -> bool:
        if self.dialect.needs_joining:
            return self.dialect.join(host, data)
        self.twin.power_cycle()
        self.twin.bench.run(BOOT_S)
        self.twin.replay(self._host)
        return False

    def blind(self, time_ns: int, late_ns: int) -> None:
        """The relay was late by `late_ns`, now or just before: its times say nothing about the machine."""
        self.judge.blind(time_ns - 2 * late_ns - BLIND_NS, time_ns + BLIND_NS)

    def rejoin(self, time_ns: int, why: str, subject: str = "rejoin") -> None:
        """Begin again with a new machine state, e.g. after data that the twin has not received."""
        self.note(subject, why, time_ns)
        self._forget()
        self.following = not self.dialect.needs_joining
        self._machine.clear()
        self.moves.trusted = False
        self._rebase(time_ns)

    # Findings

    def note(self, subject: str, text: str, time_ns: int) -> None:
        self.findings.add(Kind.NOTE, subject, text, time_ns)

    def _unusual(self, words: str, command: Command, time_ns: int) -> None:
        name = command.text
        self.findings.add(Kind.DURATION, name, words, time_ns, section=command.section)
