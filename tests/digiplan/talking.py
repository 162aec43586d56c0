"""What the tests of the IF1 and IF2 say and look at, in a few words."""

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.plant.stepper import StepperAxis
from axistwin.sim.frames import LineError, Parity
from axistwin.units import S

Segment = tuple[int | Fraction, Fraction]
"""A pulse rate, and for how many seconds."""

BITS_7_OR_8 = {1: 7, 2: 7, 3: 8, 4: 8, 5: 8, 6: 8, 7: 8, 8: 8}
PARITY: dict[int, Parity] = {1: "N", 2: "N", 3: "O", 4: "E", 5: "O", 6: "E", 7: "N", 8: "O", 9: "E"}


def tell(controller: Controller, text: str, end: str = "\r") -> None:
    """The host types a message and its terminator."""
    controller.serial.write((text + end).encode("latin-1"))


def ask(bench: Bench, controller: Controller, text: str, seconds: float = 0.2, end: str = "\r") -> bytes:
    """What comes back on a message within so many seconds, and what the host had not yet read before."""
    tell(controller, text, end)
    bench.run(seconds)
    return controller.serial.read()


def faults(bench: Bench, controller: Controller) -> tuple[bytes, bytes]:
    """The answers to K and to F.  F clears what it tells."""
    return ask(bench, controller, "K"), ask(bench, controller, "F")


def host_format(controller: Controller, message: str) -> None:
    """The host's end takes the format that a data format message such as `U61` asks for."""
    frame, parity = int(message[1]), int(message[2])
    host = controller.serial.host
    host.bytesize, host.stopbits, host.parity = BITS_7_OR_8[frame], 2 - frame % 2, PARITY[parity]


def find(bench: Bench, controller: Controller) -> None:
    """Wait for the self-test and let the interface find the baud rate."""
    bench.run(1.5)
    controller.serial.write(b"(")
    bench.run(1.0)
    assert controller.serial.read() == b"U\r"


def initialise(bench: Bench, controller: Controller, message: str = "U61") -> Controller:
    """From just switched on to ready, the ramp calculated and both ends in the same format."""
    find(bench, controller)
    end = "\r\n" if message[0] == "V" else "\r"
    each_character(bench, controller, message + end, lambda n: bench.run(0.02))  # so slowly that none is overwritten
    bench.run(0.15)
    host_format(controller, message)
    bench.run(1.2)
    assert controller.serial.read() == b""
    return controller


def ready(bench: Bench, message: str = "U61", model: str = "if1", **options: Any) -> Controller:
    """A controller of its own, initialised."""
    return initialise(bench, bench.add(model, **options), message)


def moving(controller: Controller) -> bool:
    """Whether any axis has pulses still to come."""
    return any(axis.moving for axis in controller.axes.values())


def start_ns(axis: StepperAxis) -> int:
    """When the latest motion began."""
    return axis.train.move.start_ns


def since_start(axis: StepperAxis, nth: int = -1) -> list[int]:
    """The times of the pulses of the latest motion, or of the nth, in nanoseconds from its start."""
    starts = [*(stroke.start_ns for stroke in axis.train.moves), axis.clock.now + 1]
    begin, end = starts[nth - 1 if nth < 0 else nth], starts[nth if nth < 0 else nth + 1]
    return [int(time) - begin for time in axis.pulse_times(begin, end)]


def pulse_times_of(segments: Sequence[Segment]) -> list[int]:
    """The same by an independent calculation: the phase runs at each rate in turn, pulse n is where it reaches n."""
    times: list[int] = []
    begin, phase = Fraction(0), Fraction(0)
    for rate, seconds in segments:
        last = phase + rate * seconds
        times += [int((begin + (n - phase) / rate) * S) for n in range(int(phase) + 1, int(last) + 1)]
        begin, phase = begin + seconds, last
    return times


def constant(rate: int | Fraction, pulses: int) -> list[int]:
    """Pulse times without a ramp: the n-th pulse n / rate seconds after the start."""
    return [int(n * S / Fraction(rate)) for n in range(1, pulses + 1)]


def ramped(distance: int, start: int, top: int | Fraction, increment: int, acceleration: int) -> list[Segment]:
    """An index by the book: up by `increment` every increment/acceleration seconds, along, and down the same way.

    A distance too short for the whole ramp uses as many levels as fit twice, and the rest runs at the next level.
    """
    interval = Fraction(increment, acceleration)
    levels: list[int | Fraction] = []
    level, up = start, Fraction(0)
    while level < top and 2 * (up + level * interval) <= distance:
        levels.append(level)
        up += level * interval
        level += increment
    plateau = min(Fraction(level), Fraction(top))
    ramp = [(rate, interval) for rate in levels]
    return [*ramp, (plateau, (distance - 2 * up) / plateau), *reversed(ramp)]


def at_speed(bench: Bench, controller: Controller, axis: str = "X") -> float:
    """The speed of a run when the ramp is over, in pulses per second."""
    bench.run_until(lambda: controller.axes[axis].moving, 3)
    bench.run(30)
    return controller.axes[axis].velocity


def heard(bench: Bench, controller: Controller) -> list[tuple[int, int, LineError]]:
    """A list that fills with (time in ns, byte, errors) for each character that the host receives from now on."""
    characters: list[tuple[int, int, LineError]] = []
    controller.serial.subscribe_received(lambda byte, errors: characters.append((bench.now, byte, errors)))
    return characters


def each_character(bench: Bench, controller: Controller, text: str, act: Callable[[int], None]) -> None:
    """Type `text`; `act(n)` is done just before character n goes onto the wire."""
    for n, character in enumerate(text):
        act(n)
        tell(controller, character, "")
        bench.run(controller.serial.host.format.frame_ns / S)
