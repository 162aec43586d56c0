"""Controllers in random states, for campaigns in which nothing may move."""

import random

from axistwin import Bench
from axistwin.bench import product
from axistwin.real.hosts.virtual_time import VirtualEnd

PARTS = (
    "X", "Y", "+", "-", "100", "5", "$", "@400", "<4", "G", ":", "H1", "%", "[", "#", "B+5", "R1", "S2", "F", "\r",
)  # fmt: skip
WORDS = (
    "G", "X", "S", "OFF", "MP", "MV", "MT", "MF1", "MC", "MD", "MTB", "P=500", "D=-200", "V=100000", "A=1000", "T=50",
    "E=100", "O=7", "KP=50", "F", "F=16", "UCI", "UDI", "ZS", "Zs", "a=5", "ab[3]=7", "RP", "END", "RUN", "ECHO",
    "SLEEP", "SADDR1", "SLP=300", "SLE", "BASE=100", "SIZE=4", "EPTR=10", "LOCKP", "PRINT(a)", "GOSUB1", "WAIT=100",
)  # fmt: skip


PROGRAMS = ("MP A=1000 V=100000 P=500 G END", "RUN? MV V=50000 A=100 G END", "UAO UA=0 END", "a=1 END", "END\n", "")
"""Stored programs of a SmartMotor."""


def command(model: str, rng: random.Random, *, programs: bool = False) -> bytes:
    """Return a random command that may move, wait or set something; with `programs`, or load a program."""
    if product(model).line is None:
        code = rng.choice([command.code for command in product(model).commands])
        return bytes((code, *(rng.choice((0, 0, 1, 2, 50)) for _ in range(rng.randint(0, 14)))))
    if programs and model == "smartmotor" and rng.random() < 0.1:
        return b"LOAD " + rng.choice(PROGRAMS).encode() + b"\xff\xff "
    if model == "smartmotor":
        words = " ".join(rng.choices(WORDS, k=rng.randint(1, 6)))
        return words.encode() + rng.choice((b"\r", b"\r", b" ", b""))
    return "".join(rng.choices(PARTS, k=rng.randint(1, 9))).encode() + rng.choice((b"\r", b"\r", b""))


def random_state(
    model: str, rng: random.Random, *, programs: bool = False
) -> tuple[Bench | None, VirtualEnd, list[bytes]]:
    """Return a controller at rest after random commands, and these; None instead of the bench if it moves by itself."""
    bench = Bench()
    controller = bench.add(model)
    end = VirtualEnd(bench, controller)
    bench.run(2)
    if model.startswith("if"):
        end.ask(b"(", 2)
        end.ask(b"U61\r", wait_s=1.5)
    if model == "smartmotor":
        end.ask(b"UCI UDI ZS A=100 V=100000\r")
    said = [command(model, rng, programs=programs) for _ in range(rng.randint(1, 6))]
    for message in said:
        end.ask(message)
    bench.run(rng.choice((0.5, 5)))
    restless = any(axis.moving for axis in controller.axes.values()) or (
        product(model).line is None and controller.busy
    )
    return None if restless else bench, end, said
