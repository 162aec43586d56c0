"""Prove that `axistwin probe` finds faults of controllers, each by the name of a case or by its message.

    python benchmarks/robustness/probe_faults.py [--seed 1] [--only N]

Each fault is planted in a controller of one of three families: wrong line format, lost or damaged characters, slow
answers, stuck terminals, worn memories, wrong handlers, wrong scales.  The seed chooses places and sizes of the faults.
A fault is found if the differing cases include the expected one, or if the error message names the cause.  Everything
runs in virtual time.  The exit code is 1 if a fault is not found.
"""

import argparse
import random
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

from axistwin.bench import Bench, Controller, product
from axistwin.controllers.smartmotor.nonvolatile import Nonvolatile
from axistwin.core.errors import LinkError
from axistwin.real.hosts.virtual_time import VirtualEnd
from axistwin.real.probing.cases import dialect
from axistwin.real.probing.comparing import Settings, Verdict, probe
from axistwin.sim.frames import UartFormat
from probe import FULL, PLUGGED, changed, clear_caches, twin

Handler = Callable[..., Any]


@dataclass(frozen=True)
class Planted:
    """A planted fault: where, what, how it is planted, and how the probe must name it."""

    model: str
    what: str
    expected: str
    """Part of the name of a differing case, of a fitting option, or of the error."""
    options: tuple[tuple[str, Any], ...] = ()
    defect: Callable[[Controller], object] = lambda controller: None
    """Function that spoils a controller."""
    software: Callable[[], AbstractContextManager[object]] = nullcontext
    """Function that returns a context in which the software of the controller is wrong."""
    end: type[VirtualEnd] = VirtualEnd
    """The line to the controller."""
    settings: Settings = FULL


class Counting(VirtualEnd):
    """An IF1 whose position counts each message with a move, also without `$`."""

    _moves, _said = 0, b""

    def send(self, data: bytes) -> None:
        """Send a message."""
        self._said = data
        self._moves += data[:1] in (b"X", b"Y", b"Z")
        super().send(data)

    def receive(self, silence_s: float = 0.0) -> bytes:
        """Return received data; the position 0 becomes the number of moves."""
        data = super().receive(silence_s)
        return data.replace(b"0", b"%d" % self._moves) if self._said == b"N\r" else data


class Shortened(VirtualEnd):
    """A line that loses each CR."""

    def receive(self, silence_s: float = 0.0) -> bytes:
        """Return received data without CR."""
        return super().receive(silence_s).replace(b"\r", b"")


class Fast(VirtualEnd):
    """A clock of the controller that is 3 % too fast."""

    @property
    def now(self) -> float:
        """Time of the host in seconds."""
        return super().now / 1.03


class SeventhBit(VirtualEnd):
    """A receiver that clears bit 7 of each byte."""

    def receive(self, silence_s: float = 0.0) -> bytes:
        """Return received data without bit 7."""
        return bytes(byte & 0x7F for byte in super().receive(silence_s))


@contextmanager
def wrong(model: str, code: Any, change: Callable[[Handler], Handler]) -> Iterator[None]:
    """Replace the handler of one command."""
    table = product(model).commands
    command = table._by_code[code]
    assert command.handler is not None
    clear_caches()
    with patch.dict(table._by_code, {code: replace(command, handler=change(command.handler))}):
        yield
    clear_caches()


def answering(change: Callable[[str], str]) -> Callable[[Handler], Handler]:
    """Return a change of handlers that changes the text of the answer."""

    def changing(handler: Handler) -> Handler:
        def called(*arguments: Any, **keywords: Any) -> Any:
            answer = handler(*arguments, **keywords)
            if isinstance(answer, bytes):
                return change(answer.decode("latin-1")).encode("latin-1")
            return change(answer) if isinstance(answer, str) else answer

        return called

    return changing


def scaled(factor: int) -> Callable[[Handler], Handler]:
    """Return a change of handlers that multiplies each number of a parameter."""

    def changing(handler: Handler) -> Handler:
        def times(value: Any) -> Any:
            return value * factor if type(value) is int else value

        return lambda *given, **named: handler(
            *map(times, given), **{name: times(value) for name, value in named.items()}
        )

    return changing


def worn(bit: int) -> AbstractContextManager[object]:
    """Return a data EEPROM in which one bit of each byte reads as 0."""
    read = Nonvolatile.read

    def reads(memory: Nonvolatile, place: int, size: int) -> bytes:
        return bytes(byte & ~(1 << bit) for byte in read(memory, place, size))

    return patch.object(Nonvolatile, "read", reads)


def doubled(text: str) -> str:
    """Return an answer with twice its number."""
    number = text.strip()
    return text.replace(number, str(2 * int(number))) if number.isdigit() else text


def ignored(model: str, code: Any) -> Callable[[], AbstractContextManager[object]]:
    """Return a function that makes a controller ignore one command."""
    return lambda: changed(product(model), code, "ignored")


def planted(rng: random.Random) -> list[Planted]:
    """Return all faults; places and sizes are random."""
    pin, number, code = rng.choice("ABEFG"), rng.choice("123"), rng.choice("XYZ")
    level, bit, baud = rng.random() < 0.5, rng.randrange(3), rng.choice((2400, 4800, 19200))
    label = rng.choice("PIDLSVAG")
    reply, low = rng.choice((8.0, 15.0, 30.0)), rng.randrange(2)
    motor = "smartmotor"
    return [
        Planted("if1", "the wire to CTS is broken", "does not answer request E",
                options=(("wiring", "3-wire unlinked"),)),
        Planted(motor, f"the port has {baud} baud", "and the line format",
                defect=lambda one: _host(one, UartFormat(baud))),
        Planted(motor, f"RK{label} reports a wrong digit", f"RK{label}: report",
                software=lambda: changed(product(motor), f"RK{label}", "another answer")),
        Planted(motor, "the echo is lost", "echo", software=ignored(motor, "ECHO")),
        Planted(motor, f"pin {pin} is stuck {'high' if level else 'low'}", f"pin {pin} as output and input",
                defect=lambda one: one.pins[pin].hold(level)),
        Planted("if1", f"input {number} is stuck", "I: input status",
                defect=lambda one: one.pins[f"input{number}"].hold(True)),
        Planted("if1", "N counts double", "X by 50 steps and back", software=lambda: wrong("if1", "N",
        answering(doubled))),
        Planted("if1", f"distances of {code} are twice as long", f"{code} by 50 steps and back",
                software=lambda: wrong("if1", code, _longer)),
        Planted("1811", f"answers take {reply:g} ms instead of 4 ms", "the answer takes", options=(("reply_ms",
        reply),)),
        Planted("1811", "distances are twice as long", "33h go relative", software=lambda: wrong("1811", 0x33,
        scaled(2))),
        Planted("1811", f"user bit {low} cannot be set", "set user bit", software=ignored("1811", 0x09)),
        Planted(motor, f"bit {bit} of the EEPROM is worn", "bytes, words and longs", software=lambda: worn(bit)),
        Planted(motor, "the program memory loses a program", "load a program", software=_forgetful),
        Planted(motor, "each CR is lost", "the motor answers RSP with b'24576/476'", end=Shortened),
        Planted("1811", "bit 7 of each byte is lost", "the board answers request 90h with 10 50", end=SeventhBit),
        Planted(motor, "the clock is 3 % too fast", "WAIT", end=Fast),
        Planted("if1", "a message during a move is ignored", 'busy="ignore"', options=(("busy", "ignore"),)),
        Planted(motor, "GOSUB of a program calls the wrong label", "a subroutine in a subroutine",
                software=lambda: changed(product(motor), "GOSUBn", "another parameter")),
        Planted(motor, "limit switch C is stuck closed", "the limits' pins",
                defect=lambda one: one.pins["C"].hold(False)),
        Planted("1811", "a sequence forgets its repeats", "20h repeat", software=ignored("1811", 0x20)),
        *_answers(motor),
    ]  # fmt: skip


def _answers(motor: str) -> list[Planted]:
    """Return faults that show without motion, although the answers depend on the machine."""
    still = Settings(find_options=False)
    return [
        Planted("if1", "E never reports a fault", "a data fault in the busy status", settings=still,
                software=lambda: wrong("if1", "E", answering(lambda text: text.replace("F", "C")))),
        Planted("if1", "I has four digits", "I: input status", settings=still,
                software=lambda: wrong("if1", "I", answering(lambda text: "0" + text))),
        Planted("if1", "O is 1 without a sequence", "O: ", settings=still,
                software=lambda: wrong("if1", "O", answering(lambda text: text.replace("0", "1")))),
        Planted("if1", "X without $ counts", "X+1 without $, and N", settings=still, end=Counting),
        Planted(motor, "a flag is 2", "RBd: report", settings=still,
                software=lambda: wrong(motor, "RBd", answering(lambda text: text.replace("0", "2")))),
    ]  # fmt: skip


def _host(controller: Controller, fmt: UartFormat) -> None:
    controller.serial.host.format = fmt


def _longer(handler: Handler) -> Handler:
    """Return the handler of an axis with twice the distance, but the same direction."""

    def called(*arguments: Any, **keywords: Any) -> Any:
        *others, distance = arguments
        return handler(*others, 2 * distance if type(distance) is int else distance, **keywords)

    return called


def _forgetful() -> AbstractContextManager[object]:
    """Return a context in which a stored program is always empty."""
    stack = ExitStack()
    stack.enter_context(patch.object(Nonvolatile, "save", lambda memory, store: setattr(memory, "program", "")))
    return stack


def findings(fault: Planted) -> list[str]:
    """Probe a controller with a fault; return differing cases, reasons, fitting options, or the error."""
    twin(fault.model)  # before anything is spoilt
    with fault.software():
        bench = Bench()
        controller = bench.add(fault.model, **dict(fault.options))
        dialect(product(fault.model)).equip(controller, PLUGGED)
        bench.run(2)
        fault.defect(controller)
        end = fault.end(bench, controller)
        settings = replace(fault.settings, find_options="=" in fault.expected)
        try:
            found = probe(fault.model, end, settings, twin(fault.model))
        except LinkError as error:
            return [str(error)]
    different = found.of(Verdict.DIFFERS)
    return [*found.fits, *(result.case.name for result in different), *dict.fromkeys(r.reason for r in different)]


def main() -> int:
    """Plant all faults."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, help="number of one fault, from 0")
    given = parser.parse_args()
    faults = planted(random.Random(given.seed))
    faults = faults if given.only is None else faults[given.only : given.only + 1]
    missed = 0
    for fault in faults:
        names = findings(fault)
        found = any(fault.expected in name for name in names)
        missed += not found
        print(f"{'found' if found else 'MISSED'}: {fault.model}, {fault.what}: {fault.expected!r} among {len(names)}"
              + ("" if found else f": {names[:5]}"))  # fmt: skip
    print(
        f"{'held' if not missed else 'FAILED'}: {len(faults) - missed} of {len(faults)} planted faults found; "
        f"seed {given.seed}; {time.process_time():.0f} s of processor time"
    )
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
