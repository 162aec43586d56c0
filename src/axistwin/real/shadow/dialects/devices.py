"""The answers of a device of others beside a real one: its table tells what is answered, its driver what moves."""

from collections.abc import Iterator
from contextlib import suppress
from struct import Struct

from axistwin.controllers.patterns import Refused
from axistwin.devices.framing import Datagrams, Framing, Port, Request
from axistwin.devices.making import Hardware, address_of
from axistwin.devices.table import collected
from axistwin.drivers.text import TextDriver, core_of_device
from axistwin.real.shadow.dialects.dialect import Dialect, Reading
from axistwin.real.shadow.talk import Command
from axistwin.real.shadow.twin import Twin
from axistwin.sim.frames import SOUND

SERVO_GRAIN = 2.0  # Counts by which a servo at rest may stand off its target.


class Table(Dialect):
    """A query is answered once; the driver's own queries say whether an axis moves, and where it is."""

    def __init__(self, twin: Twin) -> None:
        super().__init__(twin)
        hardware = twin.controller._device
        assert isinstance(hardware, Hardware)
        self._hardware, kind = hardware, hardware.kind
        self._find = kind.framing.finder(collected(kind), kind.axes)
        self._driver: TextDriver | None = None
        if isinstance(kind.driver, TextDriver):
            self._driver = core_of_device(kind)  # type: ignore[assignment]  # with the terminator of the device
        self._cut_messages(kind.framing)
        self._asks = {(what, axis): self._asked(what, axis) for what in ("busy", "position") for axis in kind.axes}
        self._meanings: dict[str, tuple[str, str]] = {}  # By the names of the host's queries.
        if self._driver is not None and not self._driver.confirmed:
            self.stop = b"".join(self._driver.said("stop", axis=axis) for axis in kind.axes)
        self.clear()

    def _cut_messages(self, framing: Framing) -> None:
        if isinstance(framing, Datagrams):
            self.message_size = Struct(framing.answer.split()[0]).size + len(framing.check(b""))
        elif (last := framing.endings[1][-1:]) not in self.terminators:
            self.terminators = last

    def _asked(self, what: str, axis: str) -> Request | None:
        """Return a query of the driver as the device reads it."""
        if self._driver is None:
            return None
        self.clear()
        found = list(self._requests(self._driver.said(what, axis=axis)))
        return found[-1][1] if found else None

    def clear(self) -> None:
        self._taken: list[bytes] = []
        kind = self._hardware.kind
        address = address_of(kind, self._hardware.options)
        port = Port(address, lambda data, _: self._taken.append(data), lambda _: None, lambda: self.twin.now)
        self._receive = kind.framing.reader(port)

    def _requests(self, data: bytes) -> Iterator[tuple[bytes, Request | None]]:
        for byte in data:
            self._receive(byte, SOUND)
        taken, self._taken[:] = list(self._taken), []
        for said in taken:
            request = None
            with suppress(Refused):
                request = self._find(said)
            yield said, request

    def commands(self, data: bytes) -> Iterator[Command]:
        for said, request in self._requests(data):
            text = said.decode("latin-1").strip() if not self.message_size else said.hex(" ")
            entry = None if request is None else request.entry
            asks = entry is not None and entry.asks
            name = text if asks or entry is None else str(entry.code)
            answers = int(asks or bool(self._driver and self._driver.confirmed))
            starts = not asks and not (entry is not None and entry.blocks)
            meaning = next((key for key, known in self._asks.items() if _same(known, request)), None)
            if meaning is not None:
                self._meanings[name] = meaning
            yield Command(name, entry.chapter if entry else "", said, answers=answers, starts=starts, words=text[:40])

    def read(self, command: Command | None, data: bytes) -> Reading:
        what, axis = self._meanings.get("" if command is None else command.name, ("", ""))
        value = self._number(data)
        if not what or value is None:
            return Reading(data, soft=command is not None)  # It may say something about the motion.
        assert self._driver is not None
        if what == "position":
            grain = SERVO_GRAIN if self._hardware.kind.axes[axis].servo else 0.0
            return Reading(position=round(value * self._driver.counts), grain=grain, moving_grain=grain)
        rest = self._driver.at_rest
        busy = not (rest(axis, value) if callable(rest) else value == rest)
        return Reading(busy=busy if axis == self.twin.busiest()[0] else None)

    def _number(self, data: bytes) -> float | None:
        if self._driver is None:
            return None
        try:
            return float(self._driver.value(data))
        except Exception:  # noqa: BLE001  # of a function of the user's
            return None

    def axis_of(self, command: Command) -> str:
        return self._meanings.get(command.name, ("", ""))[1] or super().axis_of(command)

    def set_position(self, command: Command, position: int) -> bool:
        """Give the twin's axis the machine's number, if that is what it says then."""
        _, axis = self._meanings.get(command.name, ("", ""))
        device = self._hardware.device
        if not axis or device is None or self.twin.busy or not self.twin.idle:
            return False
        device.axes[axis].define(position)
        return True


def _same(one: Request | None, other: Request | None) -> bool:
    """Return True if two requests ask the same, perhaps in other words."""
    if one is None or other is None:
        return False
    return one.entry.handler is other.entry.handler and one.values == other.values
