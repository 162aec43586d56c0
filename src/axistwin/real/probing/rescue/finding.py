"""Find the model, baud rate and frame of a controller at a serial port.

The first characters at each rate spoil a message or a command that another host has not ended, so that the following
terminator cannot start it.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

from axistwin.bench import product
from axistwin.core.errors import LinkError
from axistwin.real.hosts.end import End
from axistwin.real.hosts.exchange import Exchange
from axistwin.real.probing.rescue import digiplan, smartmotor
from axistwin.sim.frames import Parity, UartFormat

RATES = {"smartmotor": (9600, 19200, 38400, 4800, 2400), "if1": (9600, 4800, 2400, 1200, 600, 300, 110)}
FRAMES: dict[str, tuple[tuple[int, Parity], ...]] = {
    "smartmotor": ((8, "N"),), "if1": ((8, "N"), (7, "E"), (7, "O"), (8, "E"), (8, "O"), (7, "N")),
}  # fmt: skip
"""Data bits and parity that are tried.  Wrong parities could begin binary records of a SmartMotor."""
STOP_BITS = {"smartmotor": 1, "if1": 2}
PATIENCE_S = 0.15  # Longest silence before an answer, beyond the time of the characters on the line.
BOARD = "1811"
Report = Callable[[UartFormat], None]
Test = Callable[[Exchange], bool]  # Returns True if a controller answers.
Attempt = tuple[UartFormat, str, Test]


@dataclass(frozen=True)
class Found:
    """A controller that answers."""

    model: str
    line: UartFormat | None = None  # Line format; None for a board on a bus.


def find(
    end: End, model: str | None = None, line: UartFormat | None = None, report: Report = lambda line: None
) -> Found:
    """Find the model and the serial line format (e.g. the baud rate) of a connected controller.

    `model`, `line`: given by the user; then only these are tried.  `report` is called with each line format.  Raises
    LinkError if no controller answers.
    """
    if end.messages:
        return Found(model or BOARD)
    kinds = tuple(RATES) if model is None else (_kind(model),)
    heard = ""
    for fmt, kind, answers in _attempts(kinds, line, fixed=not end.has_line):
        report(fmt)
        end.set_line(fmt)
        exchange = Exchange(end, kind, fmt)
        if answers(exchange):
            return Found(model or kind, fmt)
        if exchange.heard and not heard:
            heard = f"{exchange.heard!r} at {fmt}"
    if heard:
        raise LinkError(
            f"the controller answers with {heard}: expected an answer of a SmartMotor, IF1 or IF2; "
            "check --model and --line, and close other programs that use the port"
        )
    if line is None and end.has_line:
        raise LinkError(
            "the controller does not answer at any baud rate or in any character format: "
            "check cable, power and --model, and close other programs that use the port"
        )
    raise LinkError("the controller does not answer: check cable, power, --model and --line")


def _kind(model: str) -> str:
    return "if1" if product(model).family == "digiplan" else "smartmotor"


def _attempts(kinds: tuple[str, ...], line: UartFormat | None, *, fixed: bool) -> Iterator[Attempt]:
    """Yield line formats, each with the kind of controller and its test, the most usual first.

    The first test of each kind cannot be taken for the open bracket of an interface that has no baud rate yet.
    """
    usual = {kind: line or product(kind).line or UartFormat() for kind in kinds}
    for kind, fmt in usual.items():
        yield fmt, kind, FIRST_TESTS[kind]
    for kind, fmt in usual.items():
        yield from ((each, kind, TESTS[kind]) for each in ([fmt] if line is not None or fixed else _formats(kind)))


def _formats(kind: str) -> Iterator[UartFormat]:
    for bits, parity in FRAMES[kind]:
        for rate in RATES[kind]:
            yield UartFormat(rate, bits, parity, STOP_BITS[kind])


def _motor(exchange: Exchange, first: bytes = smartmotor.FIRST) -> bool:
    """True if a SmartMotor reports variable `a`; the first report may end, and spoil, another host's command."""
    reported = partial(smartmotor.reported, first)
    return any(reported(exchange.ask(first, complete=reported, patience_s=PATIENCE_S)) for _ in range(2))


def _interface(exchange: Exchange) -> bool:
    return digiplan.terminator(exchange, PATIENCE_S) is not None


def _uninitialised(exchange: Exchange) -> bool:
    """Raise LinkError if an IF1 or IF2 waits for its data format message, e.g. `U61`; else return False."""
    if exchange.ask(b"(", patience_s=PATIENCE_S) == b"U\r":
        raise LinkError(
            "the interface has no data format yet: send the data format, e.g. U61, and run axistwin rescue again "
            "(caution: U61 can start a stored sequence, so motors can move)"
        )
    return False


FIRST_TESTS: dict[str, Test] = {"smartmotor": partial(_motor, first=smartmotor.REPORT), "if1": _uninitialised}
TESTS: dict[str, Test] = {"smartmotor": _motor, "if1": _interface}
