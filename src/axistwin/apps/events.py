"""What can be observed on a bench from outside: characters on lines, messages on a bus, and levels that change."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial

from axistwin.bench import Bench, Controller
from axistwin.sim.pins import Pin
from axistwin.sim.serial import LineError


@dataclass(frozen=True, slots=True)
class Said:
    """A host has something to transmit, from `time_ns` on; on a bus, it has handed over a command."""

    time_ns: int
    controller: str
    data: bytes


@dataclass(frozen=True, slots=True)
class Heard:
    """A host has received a character; on a bus, a message lies ready for it."""

    time_ns: int
    controller: str
    data: bytes
    errors: LineError = LineError.NONE


@dataclass(frozen=True, slots=True)
class Changed:
    """A terminal has taken another level; `driven` if somebody forces it to.

    The lines of the serial connection are called `dtr` and `rts` at the device, `host.dtr` and `host.rts` at the host.
    """

    time_ns: int
    controller: str
    pin: str
    level: bool
    driven: bool = False
    flashing: bool = False


@dataclass(frozen=True, slots=True)
class Broke:
    """A host has sent a break of so many seconds."""

    time_ns: int
    controller: str
    seconds: float


Event = Said | Heard | Changed | Broke


@contextmanager
def observing(bench: Bench, sink: Callable[[Event], None]) -> Iterator[None]:
    """Give `sink` everything that happens on the bench, as it happens."""
    with ExitStack() as stack:
        for controller in bench.controllers.values():
            _observe(bench, controller, sink, stack)
        yield


def terminals(controller: Controller) -> dict[str, Pin]:
    """All that has a level: the pins, and the control lines of the serial connection or the bus."""
    if controller.product.attend is not None:
        return {**controller.pins, "interrupt": controller.bus.interrupt_line}
    port = controller.serial
    lines = {"dtr": port.dtr_line, "rts": port.rts_line, "host.dtr": port.host.dtr_line, "host.rts": port.host.rts_line}
    return {**controller.pins, **lines}


def _observe(bench: Bench, controller: Controller, sink: Callable[[Event], None], stack: ExitStack) -> None:
    name, clock = controller.name, bench.clock

    def changed(pin_name: str, pin: Pin) -> None:
        sink(Changed(clock.now, name, pin_name, pin.level, pin.driven, pin.flashing))

    if controller.product.attend is not None:
        stack.callback(controller.bus.listen(lambda data: sink(Said(clock.now, name, data))))
        stack.callback(controller.bus.hear(lambda data: sink(Heard(clock.now, name, data))))
    else:
        port = controller.serial
        stack.callback(port.listen(lambda data: sink(Said(clock.now, name, data))))
        stack.callback(port.watch_breaks(lambda seconds: sink(Broke(clock.now, name, seconds))))
        stack.callback(port.hear(lambda byte, errors: sink(Heard(clock.now, name, bytes([byte]), errors))))
    for pin_name, pin in terminals(controller).items():
        stack.callback(pin.watch(partial(changed, pin_name)))
