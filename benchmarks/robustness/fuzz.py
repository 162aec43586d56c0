"""Random input against every model, at its own baud rate and at wrong ones: exceptions, and bytes per second.

    python benchmarks/robustness/fuzz.py [--seed 11] [--bytes 1000]

A rate is in characters per second of processor time. It counts the sent or the received characters, whichever are
more: a fast receiver reads the bits of one slow character as several characters.  The host's bytes per second are also
printed.  Exit code 0: no exception, and no rate below half of that at the model's own baud rate.
"""

import argparse
import random
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import process_time
from typing import Self

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

from axistwin import Bench
from axistwin.sim.frames import Break, LineError, UartFormat
from axistwin.sim.serial import Line, Uart
from axistwin.sim.serial_port import SerialPort

BAUD_RATES = (110, 300, 600, 1200, 2400, 4800, 9600, 19_200, 38_400, 115_200, 460_800, 1_000_000, 4_000_000)
MATCHED = 9600
SLOWEST = 0.5
"""Lowest rate, as a share of the rate at the model's own baud rate."""
SEED, BYTES = 11, 1000
ROUNDS = 3
WORDS = (
    *("G ", "S ", "MV ", "MP ", "V=", "A=", "P=", "RP ", "RS ", "ZS ", "GOTO", "CALL", "WAIT="),
    *("X", "Y", "Z", "@", "S1$", "E\r", "D", "F", "W", "B", "U61\r", "(", "*", "#\r", "[", "]"),
    *("\r", "\n", " ", "0", "1", "9", "-"),
)


@dataclass
class Target:
    """A port of a bench, and its name."""

    bench: Bench
    name: str

    @property
    def port(self) -> SerialPort:
        """Return the host's end of the line."""
        return self.bench.port(self.name)


def initialised(model: str) -> Target:
    """Return the port of an initialised interface."""
    bench = Bench()
    port = bench.add(model).serial
    bench.run(1.1)
    for text in (b"(", b"U61\r"):
        port.write(text)
        bench.run(1.2)
    port.read()
    return Target(bench, model)


def uninitialised(model: str) -> Target:
    """Return the port of an interface before its initialisation."""
    bench = Bench()
    bench.add(model)
    bench.run(1.1)
    return Target(bench, model)


def motors(kind: str, *, moving: bool = False) -> Target:
    """Return the port of one SmartMotor, or of three in a daisy chain or on RS485."""
    bench = Bench()
    found = [bench.add("smartmotor") for _ in range(1 if kind == "single" else 3)]
    bench.run(1.5)
    for motor in found:
        motor.serial.write(b"UCI UDI ZS MV A=100 V=100000 G " if moving else b"UCI UDI ZS ")
        if kind == "chain":
            motor.serial.write(b"ECHO ")
        if kind == "rs485":
            motor.serial.write(b"OCHN(RS4,1,N,9600,1,8,C) ")
    bench.run(0.5)
    if kind == "chain":
        bench.chain(*found, name=kind)
    elif kind == "rs485":
        bench.rs485(*found, name=kind)
    return Target(bench, "smartmotor" if kind == "single" else kind)


PORTS: dict[str, Callable[[], Target]] = {
    "if1": lambda: initialised("if1"),
    "if2": lambda: initialised("if2"),
    "if1 without a format": lambda: uninitialised("if1"),
    "smartmotor": lambda: motors("single"),
    "smartmotor chain": lambda: motors("chain"),
    "smartmotor rs485": lambda: motors("rs485"),
}


@dataclass
class Outcome:
    """Result of an attack."""

    sent: int
    carried: int
    """Number of characters sent on all wires, echoes included."""
    found: int
    """Number of characters received."""
    seconds: float
    """Seconds of processor time."""
    longest_s: float
    """Longest step, in seconds."""
    error: Exception | None = None

    @property
    def rate(self) -> float:
        """Return the characters per second."""
        return max(self.carried, self.found) / self.seconds


def garbage(seed: int, count: int) -> bytes:
    """Return bytes: half of them random, half valid words."""
    rng, data = random.Random(seed), bytearray()
    while len(data) < count:
        data += rng.randbytes(8) if rng.random() < 0.5 else rng.choice(WORDS).encode()
    return bytes(data[:count])


def attack(target: Target, baudrate: int, data: bytes) -> Outcome:
    """Send bytes at this baud rate, and step until the last character has ended."""
    port, counted = target.port, _Counted()
    clock = port.clock
    clock.patient = False  # as in `serve`, without a compilation during the run
    port.host.baudrate = baudrate
    error, longest_s, began = None, 0.0, process_time()
    with counted:
        try:
            port.write(data)
            while port.pending and clock.next_event_ns() is not None:
                before = process_time()
                clock.step()
                longest_s = max(longest_s, process_time() - before)
        except Exception as raised:  # noqa: BLE001  # that is what is looked for
            error = raised
    return Outcome(len(data), counted.carried, counted.found, process_time() - began, longest_s, error)


class _Counted:
    """Counter of all sent and received characters, as a context manager."""

    def __enter__(self) -> Self:
        self.carried = self.found = 0
        self._take, self._carry = Uart.take, Line.carry

        def take(uart: Uart, byte: int, errors: LineError) -> None:
            self.found += 1
            self._take(uart, byte, errors)

        def carry(line: Line, sent: UartFormat, item: int | Break) -> int:
            self.carried += 1
            return self._carry(line, sent, item)

        Uart.take, Line.carry = take, carry  # type: ignore[method-assign]
        return self

    def __exit__(self, *_: object) -> None:
        Uart.take, Line.carry = self._take, self._carry  # type: ignore[method-assign]


def attack_board(model: str, seed: int, count: int) -> Outcome:
    """Write random bytes into the registers of a board at random times."""
    rng, bench, error = random.Random(seed), Bench(), None
    bus = bench.add(model).bus
    bench.run(2)
    bench.clock.patient = False
    began = process_time()
    try:
        for _ in range(count):
            bus.write(rng.choice((0, 0, 0, 1)), rng.choice((rng.randrange(256), 0x10)))
            bus.read(rng.randrange(2))
            if rng.random() < 0.2:
                bench.run(rng.random() * 0.01)
    except Exception as raised:  # noqa: BLE001
        error = raised
    return Outcome(count, count, 0, process_time() - began, 0.0, error)


def arguments(about: str | None, count: int) -> argparse.Namespace:
    """Return the arguments of the command line: the seed, and the number of bytes for each port."""
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--bytes", type=int, default=count, help="bytes for each port at each baud rate")
    return parser.parse_args()


def main() -> int:
    """Print rates and the verdict."""
    given = arguments(__doc__, BYTES)
    seed, count = given.seed, given.bytes
    good = True
    print(f"seed {seed}, {count} bytes each; characters per second of processor time")
    for name, make in PORTS.items():
        outcomes = {baudrate: best(make, baudrate, garbage(seed, count)) for baudrate in BAUD_RATES}
        matched = outcomes[MATCHED].rate
        for baudrate, outcome in outcomes.items():
            bad = outcome.error or outcome.rate < SLOWEST * matched
            good &= not bad
            shown = f"{outcome.rate:>9,.0f}/s = {outcome.rate / matched:4.2f} of matched"
            speed = f"{outcome.sent / outcome.seconds:>8,.0f} B/s, longest step {outcome.longest_s * 1e3:.2f} ms"
            print(f"{name:22} {baudrate:>9,} baud {shown}, {speed} {'BAD' if bad else ''} {outcome.error or ''}")
    for model in ("1810", "1811"):
        outcome = attack_board(model, seed, count)
        good &= outcome.error is None
        print(f"{model:22} {outcome.rate:>9,.0f}/s {outcome.error or ''}")
    print("verdict:", "good" if good else "BAD")
    return 0 if good else 1


def best(make: Callable[[], Target], baudrate: int, data: bytes) -> Outcome:
    """Return the fastest of several rounds, or a failed round."""
    outcomes = [attack(make(), baudrate, data) for _ in range(ROUNDS)]
    return next((outcome for outcome in outcomes if outcome.error), max(outcomes, key=lambda outcome: outcome.rate))


if __name__ == "__main__":
    raise SystemExit(main())
