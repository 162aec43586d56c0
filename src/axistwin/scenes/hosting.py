"""Hosts that live in the virtual time of a scene, each at its own controller, side by side.

A host sends the lines of an `.if1` or `.181x` file: as everywhere, a line when the controller is done with the one
before, and after `+2.5` when that time has passed; but here others move, so only that one controller is looked at.  Or
it does what a conversation (`.talk`) has for the host's side, at its times.
"""

import re
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

from axistwin.bench import FAMILIES, Bench, Controller, endpoints
from axistwin.bench.action_runner import Hands, Load
from axistwin.bench.actions import FAULT_ACTS
from axistwin.bench.acts import Act, Do, Hear, Say, Wait
from axistwin.bench.hosts import Host, host_of
from axistwin.conversations.conversation import Conversation, load_text, parse
from axistwin.conversations.player import PATIENCE_S, open_channels
from axistwin.errors import UsageError
from axistwin.programs import stored_programs
from axistwin.programs.command_lines import ATTEMPTS, READY_S, SELF_TEST_S, command_lines, greeting, prepared_action
from axistwin.programs.command_lines import PATIENCE_S as ANSWER_S
from axistwin.programs.hex_commands import command_strings
from axistwin.sim.clock import LAST, Clock, Event, Procedure, Process, kill
from axistwin.units import MS, to_ns

LOOK_NS = 20 * MS
"""So often a host looks whether its controller is done."""
TALK, STORED = ".talk", ".sms"
KINDS = {".if1": "digiplan", ".181x": "compumotor"}
"""What is sent to whom."""
HOST, SCRIPT = 0, 1
"""Ranks of those who do something when all else has happened that is due: first hosts, then people at the machine."""
OUTSIDE = "outside"
_OUTSIDE = re.compile(rf"{OUTSIDE}(?: ([1-9]\d?))?")
"""`; host: outside` in a conversation: its host was none of the scene's; what it did comes after what they do then."""
Start = Callable[[], Process]
"""Lets a host begin."""


def prepared(bench: Bench, name: str, file: str, read: Callable[[str], str], hands: Hands | None = None) -> Start:
    """A host that sends this file to whoever is reached by this name.

    `read`: finds the text of a file.  `hands`: who does what a conversation has, the same for all of a bench.  Raises
    ProgramError or UsageError if it cannot.
    """
    suffix, clock = _kind(bench, name, file), bench.clock
    text = read(file)
    if suffix == TALK:
        talker = _Talker(bench, name, _conversation(bench, name, file, text), hands or Hands(bench, own=True))
        return lambda: clock.process(talker.converse())
    controller = bench[name]
    if KINDS[suffix] == "digiplan":
        sender = _Host(clock, controller, command_lines(text, file), file)
        return lambda: clock.process(sender.send_lines())
    assert controller.product.language is not None, "a board has one"
    operator = _Host(clock, controller, command_strings(text, controller.product.language, file), file)
    return lambda: clock.process(operator.send_commands())


def rank_of(host: str) -> int:
    """When a host does something, among all who do when all else has happened: `outside 2` after `outside`."""
    found = _OUTSIDE.fullmatch(host)
    return HOST if found is None else min(SCRIPT - 1 + int(found[1] or 1), LAST - 1)


def _kind(bench: Bench, name: str, file: str) -> str:
    """The suffix of what a host sends.  Raises UsageError if it cannot be sent to whoever is called so."""
    suffix = Path(file).suffix.lower()
    if suffix not in (TALK, *KINDS):
        raise UsageError(f"{file} is nothing that a host sends by itself: give .if1, .181x or a conversation .talk")
    if suffix != TALK and FAMILIES[bench[name].product.model] != KINDS[suffix]:
        raise UsageError(f"{file} is not for {name}, which is a {bench[name].product.model}")
    return suffix


def loader(bench: Bench, read: Callable[[str], str]) -> Load:
    """Puts programs into controllers of this bench, which are switched off and on for it.

    A SmartMotor's source (.sms) is stored and run; what a host sends is sent by one that takes the place of the one
    before.  `read` finds the text of a file.
    """

    def load(name: str, file: str) -> Callable[[], object]:
        suffix, controller = Path(file).suffix.lower(), bench[name]
        if suffix == STORED:
            source = stored_programs.as_sent(read(file))
            stored_programs.check(source, file, controller)
            return partial(stored_programs.run, source, file, controller)
        if suffix not in KINDS:
            raise UsageError(
                f"{file} cannot be loaded: give a SmartMotor's source .sms, or command lines .if1 or .181x"
            )
        return partial(_send, controller, prepared(bench, name, file, read), bench.senders)

    return load


def _send(controller: Controller, start: Start, there: dict[str, Process]) -> None:
    if controller.name in there:
        kill(there[controller.name])
    if controller.name in controller.ports:
        controller.serial.drop_pending()
    controller.power_cycle()
    there[controller.name] = start()


def program_text(path: Path) -> str:
    """The text of a program of any kind.  Raises UsageError or ProgramError."""
    return stored_programs.load_source(path).decode() if path.suffix.lower() == STORED else load_text(path)


def _conversation(bench: Bench, name: str, file: str, text: str) -> Conversation:
    model = bench[name].product.model if name in bench.controllers else ""
    conversation = parse(text, file, model=model)
    open_channels(conversation, bench)
    return conversation


class _Talker:
    """Does what the host does in a conversation, and waits where it hears something.

    What must be so (`=`) is nothing that a host does.
    """

    def __init__(self, bench: Bench, name: str, conversation: Conversation, hands: Hands) -> None:
        self.bench, self.name, self.conversation = bench, name, conversation
        self._hands = hands
        self._patience_ns = to_ns(conversation.seconds_in("patience", PATIENCE_S))
        self._rank = rank_of(conversation.headers.get("host", ""))
        self._heard: dict[str, bytearray] = {}
        self._waiting: Event | None = None
        self._acts = [(act, self._prepared(act)) for act in conversation.acts]
        bench.agenda_ns = max(bench.agenda_ns, sum(act.ns for act in conversation.acts if isinstance(act, Wait)))

    def _prepared(self, act: Act) -> Callable[[], object]:
        """What it does, as something to call; what cannot be done is found now."""
        with self.conversation.placing_errors(act):
            match act:
                case Say(data=data):
                    self._check(self._whom(act))
                    return self._hands.prepare(Say(data, controller=self._whom(act)))
                case Do(target=target, value=value) if not self._is_later(act):
                    return self._hands.prepare(Do(target, value, controller=self._whom(act)))
                case Do(target=target, value=value):
                    later = Do(target, value, controller=self._whom(act))
                    return lambda: self._hands.prepare(later)()
                case Hear():
                    self._listen(self._whom(act))
        return lambda: None

    def _is_later(self, act: Do) -> bool:
        """A fault may be about another that is there only when its time has come."""
        return act.target in FAULT_ACTS

    def _whom(self, act: Act) -> str:
        return act.controller or self.name

    def _check(self, name: str) -> None:
        if name not in endpoints.names(self.bench):
            raise UsageError(f"nobody called {name!r} to talk to: there are {', '.join(endpoints.names(self.bench))}")

    def _listen(self, name: str) -> None:
        self._check(name)
        if name in self._heard:
            return
        self._heard[name] = bytearray()
        if endpoints.at_a_bus(self.bench, name):
            self.bench[name].bus.hear(partial(self._hears, name))
        else:
            self.bench.port(name).hear(lambda byte, _: self._hears(name, bytes([byte])))

    def _hears(self, name: str, data: bytes) -> None:
        self._heard[name] += data
        self._wake()

    def _wake(self) -> None:
        waiting, self._waiting = self._waiting, None
        if waiting is not None:
            waiting.succeed()

    def converse(self) -> Procedure:
        """From the first act to the last, each when everything else has happened that is due at its time."""
        time_ns = self.bench.now
        for act, do in self._acts:
            match act:
                case Wait():
                    time_ns += act.ns
                    yield self._when_all_is_done(time_ns)
                case Hear():
                    yield from self._hear(act)
                    time_ns = self.bench.now
                case _:
                    with self.conversation.placing_errors(act):
                        do()

    def _when_all_is_done(self, time_ns: int) -> Event:
        event = self.bench.clock.event()
        self.bench.clock.after_all(time_ns, event.succeed, rank=self._rank)
        return event

    def _hear(self, act: Hear) -> Procedure:
        """Until all of it has come, whatever it is, or nothing more for a while."""
        heard, wanted, clock = self._heard[self._whom(act)], len(act.data), self.bench.clock
        known = -1
        while known < len(heard) < wanted:
            known, self._waiting = len(heard), clock.event()
            forget = clock.after_all(clock.now + self._patience_ns, self._wake)
            yield self._waiting
            forget()
        del heard[:wanted]
        yield self._when_all_is_done(clock.now)


class _Host:
    """At one controller, with what it is going to do."""

    def __init__(self, clock: Clock, controller: Controller, acts: Iterable[Act], file: str) -> None:
        self.clock, self.controller, self.file = clock, controller, file
        self.acts = [(act, self._prepared(act)) for act in acts]

    def _prepared(self, act: Act) -> Callable[[], object]:
        """What somebody at the machine does, as something to call; what cannot be done is found now."""
        if not isinstance(act, Do):
            return lambda: None
        return prepared_action(self.controller, act, self.file)

    # At a serial line

    def send_lines(self) -> Procedure:
        """Initialise the interface, then type line after line, as far as it wants to hear more."""
        port, wanted = self.controller.serial, self.controller.serial.host.format
        first, message = greeting(wanted)
        port.host.format = first
        yield self._pause(SELF_TEST_S)
        yield from self._open()
        port.write(message)
        yield self._pause(READY_S)
        port.host.format = wanted
        yield from self._perform(self._type, lambda: bool(port.pending))

    def _open(self) -> Procedure:
        """Open bracket until it is answered."""
        port, heard = self.controller.serial, bytearray()
        unsubscribe = port.hear(lambda byte, _: heard.append(byte))
        for _ in range(ATTEMPTS):
            port.write(b"(")
            for _ in range(round(to_ns(ANSWER_S) / LOOK_NS)):
                yield self.clock.timeout(LOOK_NS)
                if heard.endswith(b"U\r"):
                    unsubscribe()
                    return
        unsubscribe()

    def _type(self, words: bytes) -> Procedure:
        port = self.controller.serial
        for character in words + b"\r":
            while not port.dtr or port.pending:
                yield self.clock.timeout(LOOK_NS if not port.dtr else port.host.format.frame_ns)
            port.write(bytes([character]))

    # At a bus

    def send_commands(self) -> Procedure:
        """Send command after command, and read what comes."""
        with host_of(self.controller) as host:
            host.hear(lambda message: None)
            while not self.controller.bus.status:
                yield self.clock.timeout(LOOK_NS)
            yield from self._perform(partial(self._send, host), lambda: bool(host.pending))

    def _send(self, host: Host, command: bytes) -> Procedure:
        host.write(command)
        yield self.clock.timeout(0)

    # At either

    def _perform(self, say: Callable[[bytes], Procedure], pending: Callable[[], bool]) -> Procedure:
        timed = True
        for act, do in self.acts:
            if not (timed or isinstance(act, Wait)):
                yield from self._until_done(pending)
            timed = isinstance(act, Wait)
            match act:
                case Wait():
                    yield self.clock.timeout(act.ns)
                case Say():
                    yield from say(act.data)
                case _:
                    do()
        yield from self._until_done(pending)

    def _until_done(self, pending: Callable[[], bool]) -> Procedure:
        """Until two looks in a row find nothing said that has not left, and the controller at rest."""
        looks = 0
        while looks < 2:
            yield self.clock.timeout(LOOK_NS)
            looks = 0 if pending() or self.controller.busy else looks + 1

    def _pause(self, seconds: float) -> Event:
        return self.clock.timeout(to_ns(seconds))
