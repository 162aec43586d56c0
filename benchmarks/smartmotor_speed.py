"""Speed of a SmartMotor with servo and motor physics, times real time, compiled and in plain Python."""

import os
import sys
from collections.abc import Callable
from pathlib import Path
from subprocess import PIPE, run
from time import perf_counter

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.controllers.smartmotor.kernel import jit

RUNS = 3
ENDLESS_MOVES = b"A=100 MV V=%d G "
POLLING = b"A=100 V=400000 O=0 D=20000 C1 a=@P IF Bt==0 D=-D G ENDIF IF a>10000 b=b+1 ENDIF GOTO1 "
"""Program that moves to and fro, and polls the end of each move."""


def main() -> None:
    """Print the ratios."""
    ratio(moving, 30)  # the kernels are compiled before the measurement
    one, polling = best(moving, 600), best(running, 300)
    print(f"one motor moving, servo and physics: {one:,.0f} times real (goal >= 2,000)")
    print(f"with a program that polls: {polling:,.0f} times real (goal >= 500)")
    print(jit.note() or f"compiled against plain Python: {one / in_plain_python():,.0f} times (goal >= 50)")


def in_plain_python() -> float:
    """Return the speed of a moving motor, times real time, in a process without compilation."""
    plain = run([sys.executable, __file__, "plain"], env={**os.environ, "AXISTWIN_JIT": "off"}, stdout=PIPE, check=True)
    return float(plain.stdout)


Setting = Callable[[int], tuple[Bench, list[Controller]]]


def best(setting: Setting, seconds: float) -> float:
    """Return the best of several runs of one motor."""
    return max(ratio(setting, seconds) for _ in range(RUNS))


def ratio(setting: Setting, seconds: float) -> float:
    """Return the ratio of virtual to real seconds of one motor."""
    bench, all_motors = setting(1)
    before = [motor.axes["shaft"].position for motor in all_motors]
    began = perf_counter()
    bench.run(seconds)
    took = perf_counter() - began
    assert all(motor.axes["shaft"].position != at for motor, at in zip(all_motors, before, strict=True))
    return seconds / took


def moving(motors: int) -> tuple[Bench, list[Controller]]:
    """Return motors that turn, each at its own speed."""
    bench, all_motors = switched_on(motors)
    for n, motor in enumerate(all_motors):
        motor.serial.write(ENDLESS_MOVES % (200_000 + 1000 * n))
    bench.run(1)
    return bench, all_motors


def running(motors: int) -> tuple[Bench, list[Controller]]:
    """Return motors whose program moves them to and fro."""
    bench, all_motors = switched_on(motors)
    for motor in all_motors:
        load(bench, motor, POLLING)
        motor.serial.write(b"RUN ")
    bench.run(1)
    return bench, all_motors


def switched_on(motors: int) -> tuple[Bench, list[Controller]]:
    """Return motors with a data sheet, switched on, without faults."""
    bench = Bench()
    shaft = {"motor": "frame23", "load": {"inertia_kg_m2": 3e-5}}
    all_motors = [bench.add("smartmotor", name=f"motor{n}", line="instant", shaft=shaft) for n in range(motors)]
    for motor in all_motors:
        motor.serial.write(b"UCI UDI ZS ")
    bench.run(0.5)
    return bench, all_motors


def load(bench: Bench, motor: Controller, program: bytes) -> None:
    """Download a program in blocks of 8 bytes."""
    motor.serial.write(b"LOAD ")
    data = program + b"\xff\xff"
    for at in range(0, len(data), 8):
        bench.run(0.001)
        motor.serial.write(data[at : at + 8])
    bench.run(0.1)
    motor.serial.read()


if __name__ == "__main__":
    if "plain" in sys.argv:
        print(best(moving, 5))
    else:
        main()
