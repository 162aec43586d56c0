"""Disturbances of characters on a line.

A `Passage` is a character on its way from the transmitter to the receiver.  Each `Disturbance` of the line changes the
passage.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from axistwin.sim.frames import UartFormat


@dataclass
class Passage:
    """The transmission of one character over a serial line, with the effects of line disturbances.

    `sent`: format of the character.  `copies`: number of times that the character is received.  `flips`: mask of the
    inverted data bits.  `delay_ns`: delay of the character.
    """

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
    """Simulated transmission errors on a serial line, e.g. lost or repeated characters.

    Applies `effect` to each character for which `strikes()` returns True.

    `left`: the number of characters still to be disturbed; None: no limit.
    """

    effect: Effect
    left: int | None = None
    strikes: Callable[[], bool] = always
    on_over: Callable[[], None] = lambda: None
    """Function that is called when the disturbance has finished."""

    @property
    def over(self) -> bool:
        """True if the disturbance of the serial line has ended."""
        return self.left == 0

    def meet(self, passage: Passage) -> None:
        """Disturb a character on a serial line, e.g. invert data bits of the character.

        No effect if `strikes()` returns False.  Otherwise the number `left` decreases by 1.
        """
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
    """Return a function that inverts data bits of a serial character, e.g. bit 0 if `mask` is 1.

    The parity bit is not inverted.
    """

    def effect(passage: Passage) -> None:
        passage.flips ^= mask

    return effect


def delay(delay_ns: Callable[[], int]) -> Effect:
    """Return a function that delays a character on a serial line.

    The parameter `delay_ns` is a function that returns the delay in ns.
    """

    def effect(passage: Passage) -> None:
        passage.delay_ns += delay_ns()

    return effect


def at_rate(baudrate: Callable[[int], int]) -> Effect:
    """Return a function that simulates the transmission of a character at a wrong baud rate.

    `baudrate(correct)` returns the wrong baud rate.
    """

    def effect(passage: Passage) -> None:
        passage.sent = replace(passage.sent, baudrate=baudrate(passage.sent.baudrate))

    return effect
