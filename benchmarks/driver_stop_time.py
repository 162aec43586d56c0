"""Time from `abort` to standstill, while the axis is also polled at 10 Hz.

    python benchmarks/driver_stop_time.py --seed 17 --runs 40

Each run begins a motion of a virtual controller in real time, and aborts it at a random moment: a SmartMotor at 38,400
baud, an 1811, and an IF1 below its start/stop speed, at 9600 baud.  The time ends with the last pulse, or when the
trajectory of the SmartMotor has ended.  The exit code is 1 if one run in twenty takes more than 50 ms plus the time of
the characters of one poll.  On a loaded computer, `--speed 0.2` makes its delays count a fifth.
"""

import argparse
import random
import sys
import threading
import time
from contextlib import suppress

import axistwin
from axistwin.drivers import DriverError, connect
from axistwin.sim.serial_port import SerialPort

LIMIT_S = 0.05
CASES = {
    "smartmotor": ("shaft", {"line": "38400 8N1"}, 40_000, 40 * 10 / 38_400),
    "1811": ("motor", {}, 20_000, 0.0),
    "if1": ("X", {"self_test_s": 0.1}, 350, 24 * 11 / 9600),
}
"""Axis, options, velocity, and the time of the characters of one poll."""


def set_baud_rate(serial: SerialPort) -> None:
    """Set a SmartMotor, just switched on, to 38,400 baud."""
    serial.host.baudrate = 9600
    serial.write(b"BAUD38400\r")


def measure(model: str, runs: int, speed: float, chance: random.Random) -> list[float]:
    """Return the times of all runs in seconds."""
    name, options, velocity, _ = CASES[model]
    found = []
    with axistwin.serve(model, speed=speed, **options) as twin:
        made = next(iter(twin.bench.controllers.values()))
        plant = made.axes[name]
        time.sleep(1.5 / speed)
        if model == "smartmotor":
            twin.do(lambda: set_baud_rate(made.serial))
            time.sleep(0.3 / speed)
        with connect(next(iter(twin.ports.values())), model, timeout=10.0) as controller:
            axis = controller.axes[name]
            ended = threading.Event()

            def poll() -> None:
                while not ended.wait(0.1):
                    with suppress(DriverError):
                        axis.status()

            polling = threading.Thread(target=poll)
            polling.start()
            for _ in range(runs):
                axis.move_at(velocity * chance.choice((-1, 1)))
                time.sleep(chance.uniform(0.2, 0.4) / speed)
                begun_ns = twin.do(lambda: twin.bench.now)
                axis.abort()
                if model == "smartmotor":
                    while twin.do(lambda: plant.velocity):
                        pass
                    ended_ns = twin.do(lambda: twin.bench.now)
                else:
                    axis.wait(5)
                    times = twin.do(lambda begun_ns=begun_ns: plant.pulse_times(begun_ns))
                    ended_ns = int(times[-1]) if len(times) else begun_ns
                found.append((ended_ns - begun_ns) / 1e9)
                axis.wait(5)
            ended.set()
            polling.join()
    return sorted(found)


def main() -> bool:
    """Print the figures."""
    given = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    given.add_argument("--seed", type=int, default=17)
    given.add_argument("--runs", type=int, default=40)
    given.add_argument("--speed", type=float, default=1.0, help="virtual time per real time")
    arguments = given.parse_args()
    failed = False
    for model, case in CASES.items():
        found = measure(model, arguments.runs, arguments.speed, random.Random(f"{arguments.seed} {model}"))
        most = found[len(found) * 19 // 20]
        limit = LIMIT_S + case[3]
        failed |= most > limit
        print(f"{model}: median {found[len(found) // 2] * 1000:.1f} ms, 19 of 20 within {most * 1000:.1f} ms, "
              f"longest {found[-1] * 1000:.1f} ms, limit {limit * 1000:.1f} ms")  # fmt: skip
    print("failed" if failed else "passed")
    return failed


if __name__ == "__main__":
    sys.exit(main())
