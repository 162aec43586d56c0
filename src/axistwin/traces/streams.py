"""What the two ends of a line say, as changes of signals: each message as it grows."""

from collections.abc import Callable
from contextlib import ExitStack

from axistwin.bench import Bench, endpoints
from axistwin.traces.batch import Value

LONGEST = 256
"""Characters in a row without a terminator that are one message."""


class Dialogue:
    """What the two ends of a line say, each message as it grows; it is wiped when the other end has answered."""

    def __init__(self, add: Callable[[int, int, Value], None], host: int | None, controller: int | None) -> None:
        self._host = _Speaker(add, host)
        self._controller = _Speaker(add, controller)

    def listen(self, bench: Bench, name: str, stack: ExitStack) -> None:
        """Until the stack is left."""
        clock = bench.clock
        if endpoints.at_a_bus(bench, name):
            show, bus = endpoints.codec_at(bench, name).show, bench[name].bus
            self._host.whole = self._controller.whole = True
            stack.callback(bus.listen(lambda data: self._say(self._host, clock.now, show(data).encode())))
            stack.callback(bus.hear(lambda data: self._say(self._controller, clock.now, show(data).encode())))
            return
        port = bench.port(name)
        stack.callback(port.listen(lambda data: self._say(self._host, clock.now, data)))
        stack.callback(port.hear(lambda byte, _: self._say(self._controller, clock.now, bytes((byte,)))))

    def _say(self, speaker: "_Speaker", now_ns: int, data: bytes) -> None:
        speaker.say(now_ns, data)
        other = self._controller if speaker is self._host else self._host
        other.listen(now_ns, speaker.over)


class _Speaker:
    """The message that one end is saying; `whole`: it is said at once, as on a bus."""

    def __init__(self, add: Callable[[int, int, Value], None], place: int | None) -> None:
        self._add, self._place, self._message, self._shown = add, place, b"", b""
        self.whole = False

    @property
    def over(self) -> bool:
        """Whether the terminator has been said."""
        return self.whole or self._message.endswith((b"\r", b"\n")) or len(self._message) >= LONGEST

    def say(self, time_ns: int, data: bytes) -> None:
        """More characters, or the first of the next message."""
        self._message = data if self.over and data != b"\n" else self._message + data
        self._show(time_ns, self._message)

    def listen(self, time_ns: int, answered: bool) -> None:
        """The other end speaks; if that was a whole message, the next words here are a new one."""
        if answered:
            self._message = b""
        self._show(time_ns, b"")

    def _show(self, time_ns: int, text: bytes) -> None:
        if text != self._shown:
            self._shown = text
            if self._place is not None:
                self._add(time_ns, self._place, text)
