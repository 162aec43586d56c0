"""What the tests of sequences, reports, faults and the battery backup ask and look at."""

from collections.abc import Iterable
from itertools import pairwise

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.plant.stepper import StepperAxis
from axistwin.sim.pins import Pin
from axistwin.units import MS

from .talking import tell

OWN_TIME_NS = MS
"""What a sequence step that neither moves nor waits may take of the interface's own time; the manual is silent."""


def status(bench: Bench, controller: Controller, letter: str) -> str:
    """What is answered to K, F, I, O, Q, E or N, without the terminator."""
    controller.serial.read()
    tell(controller, letter)
    bench.run_until(lambda: not controller.serial.pending, 10)
    bench.run(0.05)
    reply = controller.serial.read().decode("latin-1")
    assert reply.endswith("\r") and reply.count("\r") == 1, f"{letter} answered {reply!r}"
    return reply[:-1]


def number(bench: Bench, controller: Controller, letter: str) -> int:
    """The figure answered to K, F, I, O or N."""
    return int(status(bench, controller, letter))


def settle(bench: Bench, controller: Controller, timeout: float = 100.0) -> None:
    """Let virtual time pass until nothing is going on; fails if it never ends."""
    left = timeout
    while status(bench, controller, "E") == "E":
        bench.run(0.1)
        left -= 0.15
        assert left > 0, "still busy"


def positions(controller: Controller) -> tuple[int, int, int]:
    """Where X, Y and Z stand."""
    axes = controller.axes
    return axes["X"].position, axes["Y"].position, axes["Z"].position


def strokes(axis: StepperAxis) -> list[int]:
    """The moves an axis has made, each as signed pulses; those without a pulse left out."""
    lengths = [
        stroke.direction * stroke.profile.pulses_by(axis.clock.now - stroke.start_ns) for stroke in axis.train.moves
    ]
    return [length for length in lengths if length]


def times(axis: StepperAxis) -> list[int]:
    """The nanoseconds at which an axis has been given pulses."""
    return [int(at_ns) for at_ns in axis.pulse_times()]


def gaps(times_ns: Iterable[int]) -> list[int]:
    """Nanoseconds from each to the next."""
    return [after - before for before, after in pairwise(times_ns)]


def edges(pin: Pin) -> list[tuple[int, bool]]:
    """A list that grows with each change of the pin's level: (nanoseconds, level)."""
    seen: list[tuple[int, bool]] = []
    pin.subscribe(lambda changed: seen.append((changed.clock.now, changed.level)))
    return seen
