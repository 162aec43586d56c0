"""What can happen to characters on their way along a line.

A `Passage` is one character that has just left its transmitter; each `Trouble` on the line changes it in turn.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from axistwin.sim.frames import UartFormat


@dataclass
class Passage:
    """A character on its way: how often it arrives, with which data bits inverted, how much later, how framed."""

    sent: UartFormat
    copies: int = 1
    flips: int = 0
    delay_ns: int = 0


Effect = Callable[[Passage], None]


def always() -> bool:
    """Each character is met."""
    return True


@dataclass(eq=False)
class Trouble:
    """Does `effect` to the characters that `strikes`, asked once for each, says; `left` of them (None: to all)."""

    effect: Effect
    left: int | None = None
    strikes: Callable[[], bool] = always
    on_over: Callable[[], None] = lambda: None
    """Called when it is over."""

    @property
    def over(self) -> bool:
        """Whether it has met all it was to meet."""
        return self.left == 0

    def meet(self, passage: Passage) -> None:
        """A character comes by."""
        if self.left == 0 or not self.strikes():
            return
        self.effect(passage)
        if self.left is not None:
            self.left -= 1
            if self.left == 0:
                self.on_over()


def lose(passage: Passage) -> None:
    """It never arrives."""
    passage.copies = 0


def double(passage: Passage) -> None:
    """It arrives twice as often."""
    passage.copies *= 2


def flip(mask: int) -> Effect:
    """The data bits in `mask` are inverted; the parity bit is not."""

    def effect(passage: Passage) -> None:
        passage.flips ^= mask

    return effect


def late(delay_ns: Callable[[], int]) -> Effect:
    """It arrives so much later."""

    def effect(passage: Passage) -> None:
        passage.delay_ns += delay_ns()

    return effect


def at_rate(baudrate: Callable[[int], int]) -> Effect:
    """Its bits have another length than the sender believes."""

    def effect(passage: Passage) -> None:
        passage.sent = replace(passage.sent, baudrate=baudrate(passage.sent.baudrate))

    return effect
