"""Hosts that run in the virtual time of a scene, each at its own controller.

A host sends the lines of an `.if1` or `.181x` file: a line when the controller has finished the previous line, or
after a `+2.5` line when that time has passed.  Other controllers may be moving, so a host observes only its own
controller.  A host with a conversation (`.talk`) sends its data at the times of the conversation.
"""

import re
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

from axistwin.bench import Bench, Controller, endpoints
from axistwin.bench.action_runner import ActionRunner, Load
from axistwin.bench.actions import FAULT_ACTS
from axistwin.bench.acts import Act, Do, Hear, Say, Wait
from axistwin.bench.hosts import Host, host_of
from axistwin.bench.programs import stored_programs
from axistwin.bench.programs.command_lines import (
    ATTEMPTS,
    READY_S,
    SELF_TEST_S,
    greeting,
    prepared_action,
    read_command_lines,
)
from axistwin.bench.programs.command_lines import PATIENCE_S as ANSWER_S
from axistwin.bench.programs.hex_commands import command_strings
from axistwin.bench.talk.conversation import Conversation, load_text, parse
from axistwin.bench.talk.player import PATIENCE_S, open_channels
from axistwin.core.errors import UsageError
from axistwin.core.units import MS, to_ns
from axistwin.sim.clock import LAST, Clock, Event, Procedure, Process, kill

CHECK_NS = 20 * MS  # Interval in virtual time at which a host checks if its controller is ready.
TALK, STORED = ".talk", ".sms"
SENT = (".if1", ".181x")  # Suffixes of the programs that a host sends line by line.
HOST, SCRIPT = 0, 1  # Order of actions that have the same time: first hosts, then actions at the machine.
OUTSIDE = "outside"
_OUTSIDE = re.compile(rf"{OUTSIDE}(?: ([1-9]\d?))?")
"""`; host: outside` marks a conversation of an outside host, whose acts come after those of the scene's hosts."""
Start = Callable[[], Process]  # Starts a host.


def prepare_host(
    bench: Bench, name: str, file: str, read: Callable[[str], str], runner: ActionRunner | None = None
) -> Start:
    """Prepare a simulated host that sends a file; return a function that starts the host.

    `name`: endpoint to which the file is sent.  `read` returns the text of a file.  `runner`: the action runner of the
    bench.  Raises ProgramError or UsageError if the file cannot be sent.
    """
    suffix, clock = _kind(bench, name, file), bench.clock
    text = read(file)
    if suffix == TALK:
        conversation_host = _ConversationHost(
            bench, name, _conversation(bench, name, file, text), runner or ActionRunner(bench, own=True)
        )
        return lambda: clock.process(conversation_host.converse())
    controller = bench[name]
    if controller.product.language is None:
        line_sender = _ControllerHost(clock, controller, read_command_lines(text, file), file)
        return lambda: clock.process(line_sender.send_lines())
    hex_sender = _ControllerHost(clock, controller, command_strings(text, controller.product.language, file), file)
    return lambda: clock.process(hex_sender.send_commands())


def rank_of(host: str) -> int:
    """Return the position of a host in the order of actions at the same time: `outside 2` is after `outside`."""
    found = _OUTSIDE.fullmatch(host)
    return HOST if found is None else min(SCRIPT - 1 + int(found[1] or 1), LAST - 1)


def _kind(bench: Bench, name: str, file: str) -> str:
    suffix = Path(file).suffix.lower()
    if suffix not in (TALK, *SENT):
        raise UsageError(f"{file} cannot be sent by a host: expected a file whose name ends in .if1, .181x or .talk")
    if suffix != TALK and bench[name].product.suffix != suffix:
        made = bench[name].product
        wanted = f"a program for {made.indefinite}" if made.suffix else "a conversation (.talk)"
        raise UsageError(f"{file} is not a program for {name}: expected {wanted}")
    return suffix


def loader(bench: Bench, read: Callable[[str], str]) -> Load:
    """Return a function that loads a program into a controller.

    Loading switches the controller off and on.  A SmartMotor's source (.sms) is stored and run.  Command lines are sent
    by a new host, which replaces the controller's previous host. `read` returns the text of a file.
    """

    def load(name: str, file: str) -> Callable[[], object]:
        suffix, controller = Path(file).suffix.lower(), bench[name]
        if suffix == STORED:
            source = stored_programs.as_sent(read(file))
            stored_programs.check(source, file, controller)
            return partial(stored_programs.run, source, file, controller)
        if suffix not in SENT:
            raise UsageError(f"{file} cannot be loaded: expected a file whose name ends in .sms, .if1 or .181x")
        return partial(_send, controller, prepare_host(bench, name, file, read), bench.senders)

    return load


def _send(controller: Controller, start: Start, there: dict[str, Process]) -> None:
    if controller.name in there:
        kill(there[controller.name])
    if controller.name in controller.ports:
        controller.serial.drop_pending()
    controller.power_cycle()
    there[controller.name] = start()


def program_text(path: Path) -> str:
    """Return the text of a program file.  Raises UsageError or ProgramError if the file cannot be read."""
    return stored_programs.load_source(path).decode() if path.suffix.lower() == STORED else load_text(path)


def _conversation(bench: Bench, name: str, file: str, text: str) -> Conversation:
    model = bench[name].product.model if name in bench.controllers else ""
    conversation = parse(text, file, model=model)
    open_channels(conversation, bench)
    return conversation


class _ConversationHost:
    """A host that sends a conversation's data, and waits for the replies; it skips assertions (`=`)."""

    def __init__(self, bench: Bench, name: str, conversation: Conversation, runner: ActionRunner) -> None:
        self.bench, self.name, self.conversation = bench, name, conversation
        self._runner = runner
        self._patience_ns = to_ns(conversation.seconds_in("patience", PATIENCE_S))
        self._rank = rank_of(conversation.headers.get("host", ""))
        self._received: dict[str, bytearray] = {}
        self._waiting: Event | None = None
        self._acts = [(act, self._prepared(act)) for act in conversation.acts]
        bench.agenda_ns = max(bench.agenda_ns, sum(act.ns for act in conversation.acts if isinstance(act, Wait)))

    def _prepared(self, act: Act) -> Callable[[], object]:
        with self.conversation.placing_errors(act):
            match act:
                case Say(data=data):
                    self._check(self._endpoint(act))
                    return self._runner.prepare(Say(data, controller=self._endpoint(act)))
                case Do(target=target, value=value):
                    do = Do(target, value, controller=self._endpoint(act))
                    # Do not check a fault before its injection: it may refer to another fault that does not exist yet.
                    if target in FAULT_ACTS:
                        return lambda: self._runner.prepare(do)()
                    return self._runner.prepare(do)
                case Hear():
                    self._listen(self._endpoint(act))
        return lambda: None

    def _endpoint(self, act: Act) -> str:
        return act.controller or self.name

    def _check(self, name: str) -> None:
        if name not in endpoints.names(self.bench):
            known_names = ", ".join(endpoints.names(self.bench))
            raise UsageError(f"no controller {name!r} in the scene: expected one of {known_names}")

    def _listen(self, name: str) -> None:
        self._check(name)
        if name in self._received:
            return
        self._received[name] = bytearray()
        if endpoints.at_a_bus(self.bench, name):
            self.bench[name].bus.subscribe_received(partial(self._receive, name))
        else:
            self.bench.port(name).subscribe_received(lambda byte, _: self._receive(name, bytes([byte])))

    def _receive(self, name: str, data: bytes) -> None:
        self._received[name] += data
        self._resume()

    def _resume(self) -> None:
        waiting, self._waiting = self._waiting, None
        if waiting is not None:
            waiting.succeed()

    def converse(self) -> Procedure:
        """Perform the actions in order, each after all other events of its time."""
        time_ns = self.bench.now
        for act, do in self._acts:
            match act:
                case Wait():
                    time_ns += act.ns
                    yield self._last_event(time_ns)
                case Hear():
                    yield from self._hear(act)
                    time_ns = self.bench.now
                case _:
                    with self.conversation.placing_errors(act):
                        do()

    def _last_event(self, time_ns: int) -> Event:
        event = self.bench.clock.event()
        self.bench.clock.call_last(time_ns, event.succeed, rank=self._rank)
        return event

    def _hear(self, act: Hear) -> Procedure:
        heard, wanted, clock = self._received[self._endpoint(act)], len(act.data), self.bench.clock
        known = -1
        while known < len(heard) < wanted:
            known, self._waiting = len(heard), clock.event()
            forget = clock.call_last(clock.now + self._patience_ns, self._resume)
            yield self._waiting
            forget()
        del heard[:wanted]
        yield self._last_event(clock.now)


class _ControllerHost:
    def __init__(self, clock: Clock, controller: Controller, acts: Iterable[Act], file: str) -> None:
        self.clock, self.controller = clock, controller
        self.acts = [
            (act, prepared_action(controller, act, file) if isinstance(act, Do) else lambda: None) for act in acts
        ]

    # Simulated host on a serial line

    def send_lines(self) -> Procedure:
        """Initialise the IF1 or IF2, and send the lines, each character when the interface is ready."""
        port, wanted = self.controller.serial, self.controller.serial.host.format
        first, message = greeting(wanted)
        port.host.format = first
        yield self.clock.timeout(to_ns(SELF_TEST_S))
        yield from self._open()
        port.write(message)
        yield self.clock.timeout(to_ns(READY_S))
        port.host.format = wanted
        yield from self._perform(self._type, lambda: bool(port.pending))

    def _open(self) -> Procedure:
        port, heard = self.controller.serial, bytearray()
        unsubscribe = port.subscribe_received(lambda byte, _: heard.append(byte))
        for _ in range(ATTEMPTS):
            port.write(b"(")
            for _ in range(round(to_ns(ANSWER_S) / CHECK_NS)):
                yield self.clock.timeout(CHECK_NS)
                if heard.endswith(b"U\r"):
                    unsubscribe()
                    return
        unsubscribe()

    def _type(self, words: bytes) -> Procedure:
        port = self.controller.serial
        for character in words + b"\r":
            while not port.dtr or port.pending:
                yield self.clock.timeout(CHECK_NS if not port.dtr else port.host.format.frame_ns)
            port.write(bytes([character]))

    # Bus

    def send_commands(self) -> Procedure:
        with host_of(self.controller) as host:
            host.subscribe_received(lambda message: None)
            while not self.controller.bus.status:
                yield self.clock.timeout(CHECK_NS)
            yield from self._perform(partial(self._send, host), lambda: bool(host.pending))

    def _send(self, host: Host, command: bytes) -> Procedure:
        host.write(command)
        yield self.clock.timeout(0)

    # Both

    def _perform(self, say: Callable[[bytes], Procedure], pending: Callable[[], bool]) -> Procedure:
        timed = True
        for act, do in self.acts:
            if not (timed or isinstance(act, Wait)):
                yield from self._wait_until_idle(pending)
            timed = isinstance(act, Wait)
            match act:
                case Wait():
                    yield self.clock.timeout(act.ns)
                case Say():
                    yield from say(act.data)
                case _:
                    do()
        yield from self._wait_until_idle(pending)

    def _wait_until_idle(self, pending: Callable[[], bool]) -> Procedure:
        """Wait until all data are sent and the controller is idle.  Two successive checks must find this state."""
        checks = 0
        while checks < 2:
            yield self.clock.timeout(CHECK_NS)
            checks = 0 if pending() or self.controller.busy else checks + 1
