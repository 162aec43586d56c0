"""Speed of a SmartMotor whose external encoder is mounted on another moving SmartMotor, times real time.

The independent reference reads the leader's position before each sample.
"""

import sys
from pathlib import Path
from time import perf_counter

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

from axistwin import Bench
from axistwin.bench import product
from axistwin.plant.servo_axis import ServoAxis

RUNS = 3
SHAFT = {"motor": "frame23", "load": {"inertia_kg_m2": 3e-5}}


def main() -> None:
    """Print the ratios."""
    product("smartmotor").prepare(None, 2)
    speed, positions = measure(120)
    reads_ahead, ServoAxis.positions_ahead = ServoAxis.positions_ahead, lambda axis, _: [axis.position]
    before, _ = measure(3)
    ServoAxis.positions_ahead = reads_ahead
    print(f"a servo that follows a servo, in mode follow: {speed:,.0f} times real (goal >= 500)")
    print(f"  {speed / before:.0f} times as fast as sample by sample; positions {positions}")


def measure(seconds: float) -> tuple[float, list[int]]:
    """Return the best ratio of virtual to real seconds, and both positions at the end."""
    best, positions = 0.0, [0]
    for _ in range(RUNS):
        bench = Bench()
        motors = [bench.add("smartmotor", name=f"motor{n}", line="instant", shaft=SHAFT) for n in range(2)]
        for motor in motors:
            motor.serial.write(b"UCI UDI ZS ")
        bench.run(0.5)
        motors[1].master.follow(motors[0].axes["shaft"], 1)
        motors[0].serial.write(b"A=100 MV V=300000 G ")
        motors[1].serial.write(b"MF4 ")
        bench.run(0.5)
        began = perf_counter()
        bench.run(seconds)
        best = max(best, seconds / (perf_counter() - began))
        positions = [motor.axes["shaft"].position for motor in motors]
    return best, positions


if __name__ == "__main__":
    main()
