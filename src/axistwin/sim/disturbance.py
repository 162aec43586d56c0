"""Disturbances of characters on a line.

A `Passage` is a character on its way from the transmitter to the receiver.  Each `Disturbance` of the line changes the
passage.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from axistwin.sim.frames import UartFormat


@dataclass
class Passage:
    """A character in transit: number of copies, inverted data bits, delay, and format."""

    sent: UartFormat
    copies: int = 1
    flips: int = 0
    delay_ns: int = 0


Effect = Callable[[Passage], None]


def always() -> bool:
    """Always return True: the disturbance affects every character on the serial line."""
    return True


@dataclass(eq=False)
class Disturbance:
    """A disturbance: applies `effect` where `strikes()`; `left`: number of characters to come, None: all."""

    effect: Effect
    left: int | None = None
    strikes: Callable[[], bool] = always
    on_over: Callable[[], None] = lambda: None  # Function that is called when the disturbance has finished.

    @property
    def over(self) -> bool:
        return self.left == 0

    def meet(self, passage: Passage) -> None:
        """Apply the disturbance to a character if `strikes()` is True; count the character."""
        if self.left == 0 or not self.strikes():
            return
        self.effect(passage)
        if self.left is not None:
            self.left -= 1
            if self.left == 0:
                self.on_over()


def lose(passage: Passage) -> None:
    """Effect of a disturbance: the character is lost."""
    passage.copies = 0


def double(passage: Passage) -> None:
    """Effect of a disturbance: the character arrives twice."""
    passage.copies *= 2


def flip(mask: int) -> Effect:
    """Return an effect that inverts the data bits in `mask`; the parity bit stays."""

    def effect(passage: Passage) -> None:
        passage.flips ^= mask

    return effect


def delay(delay_ns: Callable[[], int]) -> Effect:
    def effect(passage: Passage) -> None:
        passage.delay_ns += delay_ns()

    return effect


def at_rate(baudrate: Callable[[int], int]) -> Effect:
    """Return an effect that transmits at a wrong baud rate; `baudrate(correct)` returns the wrong one."""

    def effect(passage: Passage) -> None:
        passage.sent = replace(passage.sent, baudrate=baudrate(passage.sent.baudrate))

    return effect
