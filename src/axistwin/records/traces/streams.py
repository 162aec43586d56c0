"""Trace the messages on a line as text signals, which grow with each character."""

from collections.abc import Callable
from contextlib import ExitStack

from axistwin.bench import Bench, endpoints
from axistwin.records.traces.batch import Value

LONGEST = 256  # Longest message without a terminator, in characters.


class Dialogue:
    """The messages of both ends of a line.  The signal of one end is cleared when the other end transmits."""

    def __init__(self, add: Callable[[int, int, Value], None], host: int | None, controller: int | None) -> None:
        self._host = _Message(add, host)
        self._controller = _Message(add, controller)

    def observe(self, bench: Bench, name: str, stack: ExitStack) -> None:
        """Observe the line until the stack is closed."""
        clock = bench.clock
        if endpoints.at_a_bus(bench, name):
            show, bus = endpoints.codec_at(bench, name).show, bench[name].bus
            self._host.whole = self._controller.whole = True
            stack.callback(bus.subscribe_sent(lambda data: self._extend(self._host, clock.now, show(data).encode())))
            stack.callback(
                bus.subscribe_received(lambda data: self._extend(self._controller, clock.now, show(data).encode()))
            )
            return
        port = bench.port(name)
        stack.callback(port.subscribe_sent(lambda data: self._extend(self._host, clock.now, data)))
        stack.callback(
            port.subscribe_received(lambda byte, _: self._extend(self._controller, clock.now, bytes((byte,))))
        )

    def _extend(self, message: "_Message", now_ns: int, data: bytes) -> None:
        message.extend(now_ns, data)
        other = self._controller if message is self._host else self._host
        other.clear(now_ns, message.complete)


class _Message:
    def __init__(self, add: Callable[[int, int, Value], None], place: int | None) -> None:
        self._add, self._place, self._message, self._shown = add, place, b"", b""
        self.whole = False

    @property
    def complete(self) -> bool:
        return self.whole or self._message.endswith((b"\r", b"\n")) or len(self._message) >= LONGEST

    def extend(self, time_ns: int, data: bytes) -> None:
        self._message = data if self.complete and data != b"\n" else self._message + data
        self._show(time_ns, self._message)

    def clear(self, time_ns: int, answered: bool) -> None:
        """Clear the signal, because the other end transmits; `answered`: True if the stored message is deleted, too."""
        if answered:
            self._message = b""
        self._show(time_ns, b"")

    def _show(self, time_ns: int, text: bytes) -> None:
        if text != self._shown:
            self._shown = text
            if self._place is not None:
                self._add(time_ns, self._place, text)
