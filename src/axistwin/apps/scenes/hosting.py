"""Hosts that live in the virtual time of a scene, each at its own controller, side by side.

A host sends the lines of an `.if1` or `.181x` file.  As everywhere, a line is sent when the controller is done with the
one before, and after `+2.5` when that time has passed; but here others move, so only that one controller is looked at.
"""

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

from axistwin.apps.conversations.conversation import Act, Do, Say, Wait, load_text
from axistwin.apps.conversations.host import Host, host_of
from axistwin.apps.conversations.machine import action
from axistwin.apps.conversations.operator import command_strings
from axistwin.apps.conversations.typist import ATTEMPTS, PATIENCE_S, READY_S, SELF_TEST_S, command_lines, greeting
from axistwin.bench import FAMILIES, Bench, Controller
from axistwin.errors import ProgramError, UsageError
from axistwin.sim.clock import Clock, Event, Procedure
from axistwin.units import MS, to_ns

LOOK_NS = 20 * MS
"""So often a host looks whether its controller is done."""
KINDS = {".if1": "digiplan", ".181x": "compumotor"}
"""What is sent to whom."""


def start(bench: Bench, controller: Controller, path: Path) -> None:
    """Have a host send this file to this controller.  Raises ProgramError or UsageError if it cannot."""
    family = KINDS.get(path.suffix)
    if family is None:
        raise UsageError(f"{path} is nothing that a host sends by itself: give command lines .if1 or .181x")
    if FAMILIES[controller.product.model] != family:
        raise UsageError(f"{path} is not for {controller.name}, which is a {controller.product.model}")
    text, file = load_text(path), str(path)
    if family == "digiplan":
        host = _Host(bench.clock, controller, command_lines(text, file), file)
        bench.clock.process(host.type_lines())
    else:
        assert controller.product.language is not None, "a board has one"
        commands = command_strings(text, controller.product.language, file)
        host = _Host(bench.clock, controller, commands, file)
        bench.clock.process(host.send_commands())


class _Host:
    """At one controller, with what it is going to do."""

    def __init__(self, clock: Clock, controller: Controller, acts: Iterable[Act], file: str) -> None:
        self.clock, self.controller, self.file = clock, controller, file
        self.acts = [(act, self._prepared(act)) for act in acts]

    def _prepared(self, act: Act) -> Callable[[], object]:
        """What somebody at the machine does, as something to call; what cannot be done is found now."""
        if not isinstance(act, Do):
            return lambda: None
        try:
            return action(self.controller, act.target, act.value)
        except ProgramError as error:
            raise ProgramError(error.message, file=self.file, line=act.line) from None

    # At a serial line

    def type_lines(self) -> Procedure:
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
        deafen = port.hear(lambda byte, _: heard.append(byte))
        for _ in range(ATTEMPTS):
            port.write(b"(")
            for _ in range(round(to_ns(PATIENCE_S) / LOOK_NS)):
                yield self.clock.timeout(LOOK_NS)
                if heard.endswith(b"U\r"):
                    deafen()
                    return
        deafen()

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
