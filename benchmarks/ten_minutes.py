"""Speed of ten minutes of a scene with three controllers in motion, times real time.

An IF1 feeds lengths of material.  Its output starts a turn of the rotary knife, which a SmartMotor drives, with servo
and motor physics.  An 1811 winds.
"""

import sys
import tempfile
from pathlib import Path
from time import perf_counter

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

from axistwin import Bench, Scene

SECONDS, RUNS, GOAL = 600, 3, 1000
SCENE = """
[[controller]]
model = "if1"
name = "feeder"

[[controller]]
model = "1811"
name = "winder"

[[controller]]
model = "smartmotor"
name = "knife"
axes.shaft = { motor = "frame23", load = { inertia_kg_m2 = 2e-5 } }

[[wire]]
from = "feeder.output1"
to = "knife.G"
"""
FEED = ":X4000@4000S1:P0,50:R1:P0,10:=0,1:$\r"
CUT = b"UCI UDI ZS A=200 V=800000 MP O=0 D=2000 "
WIND = ("31 00 00 00 00 13 88 00 03 D0 90", "D9 01", "20 01 FF FF", "33 00 00 61 A8", "D8", "41 01")


def main() -> None:
    """Print the ratio."""
    measure(60)  # the kernels are compiled before the measurement
    ratio = max(measure(SECONDS) for _ in range(RUNS))
    print(f"ten minutes of three controllers: {ratio:,.0f} times real (goal >= {GOAL:,})")


def measure(seconds: float) -> float:
    """Return the ratio of virtual to real seconds."""
    bench = at_work()
    began = perf_counter()
    bench.run(seconds)
    took = perf_counter() - began
    cuts = bench["feeder"].axes["X"].pulses // 4000
    assert cuts > seconds / 3, "it waits for something"
    assert abs(bench["knife"].axes["shaft"].position - 2000 * cuts) <= 2000, "it misses cuts"
    return seconds / took


def at_work() -> Bench:
    """Return the bench of the scene, with a program in each controller."""
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "scene.toml"
        path.write_text(SCENE)
        bench = Scene.load(path).build()
    bench.run(1.6)
    bench["knife"].serial.write(CUT)
    for text in WIND:
        for byte in bytes.fromhex(text):
            bench["winder"].bus.write(0, byte)
        bench["winder"].bus.write(1, 0x10)
        bench.run(0.02)
    for message in ("(", "U61\r", FEED):
        bench["feeder"].serial.write(message.encode())
        bench.run(1.2)
    return bench


if __name__ == "__main__":
    main()
