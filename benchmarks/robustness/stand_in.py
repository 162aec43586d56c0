"""A stand-in with a simulated board in virtual time: programs, kills, limits, damaged bytes and drifting clocks.

    python benchmarks/robustness/stand_in.py [--seed 1] [--programs 200] [--kills 100] [--limits 100] [--damage 100]
        [--drift-s 3600]

Programs: an IF1 moves up to three axes, an 1811 one, with changes of direction and stops; the pulses at the pins must
be those of the controller in number, direction and time.  A SmartMotor's net pulses must be its position.
Kills: the host stops sending during a move; the motors must stop and the drives switch off within 120 ms.  Limits: a
switch opens at a random pulse of a move at 4,000/s; at most one more pulse, and the IF1's step count is the board's;
then the axis moves back.  Damage: 1 % of the bytes in both directions are lost, doubled or changed; each pulse is made
at its time, or the motion stops with a reason.  Drift: two boards with clocks that are 200 ppm fast and slow, read with
an error that jumps by up to 50 µs; no edge is off by more than 25 µs.  Prints the errors and a verdict; the exit code
is 1 if there are errors.
"""

import argparse
import random
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
from tests.standin.metal import LIMIT, TICK_S, Metal, X
from tests.standin.small_board import SmallBoard
from tests.standin.test_driver import Twin

from axistwin.real.standin.wiring import AxisPins, BoardPin, InputPin

MOST_ERROR_US, MOST_STANDSTILL_S, MOST_DRIFT_US = 5.0, 0.12, 25.0
DAMAGED, PPM, JUMP_S = 0.01, 200e-6, 50e-6
PINS = {"X": (2, +1), "Y": (5, -1), "Z": (12, +1)}


def message(rng: random.Random) -> bytes:
    """Return a random move or run."""
    axes = rng.sample("XYZ", rng.randint(1, 3))
    signs = "".join(f"{axis}{rng.choice('+-')}" for axis in axes)
    return f"{signs}{rng.randint(1, 1500)} @ {rng.choice((400, 1000, 1500, 3300, 4000))} $ \r".encode()


def program(seed: int) -> list[str]:
    """Run one program of a random family; return its errors."""
    return (if1_program, if1_program, compumotor_program, smartmotor_program)[seed % 4](seed)


def if1_program(seed: int) -> list[str]:
    """Run one program of an IF1."""
    rng, twin = random.Random(seed), Twin(line="instant")
    twin.initialise()
    for _ in range(rng.randint(1, 4)):
        twin.say(message(rng), rng.uniform(0.1, 2.0))
        if rng.random() < 0.4:
            twin.say(b"#", 0.3)
    twin.run(6.0)
    return [line for name, (pin, sign) in PINS.items() for line in compared(seed, twin, name, pin, sign)]


def compared(seed: int, twin: Twin, name: str, pin: int, sign: int) -> list[str]:
    """Return the differences between the pulses at a pin and those of an axis."""
    axis, made = twin.controller.axes[name], twin.metal.small.pulses[pin]
    virtual = axis.pulse_times() / 1e9
    if len(made) != len(virtual) or sign * sum(direction for _, direction in made) != axis.position:
        return [f"program {seed}: {name}: {len(made)} pulses for {len(virtual)}: {twin.lines}"]
    if not len(made):
        return []
    late = np.array([twin.metal.small.time_s(tick) for tick, _ in made]) - virtual
    worst = np.abs(late - np.median(late)).max() * 1e6
    return [f"program {seed}: {name}: an edge is off by {worst:.1f} µs"] if worst > MOST_ERROR_US else []


def compumotor_program(seed: int) -> list[str]:
    """Run one program of an 1811: relative moves, one after the other or interrupted by a stop."""
    rng = random.Random(seed)
    limit = InputPin("table.cw_limit", BoardPin("P8", inverted=True), stops=+1, stops_at=True)
    twin = Twin("1811", (AxisPins("table.motor", X.step, X.direction, X.enable),), (limit,), ())
    twin.run(1.2)

    def command(*values: int) -> None:
        for value in values:
            twin.controller.bus.write(0, value)
        twin.controller.bus.write(1, 0x10)
        twin.run(0.05)

    for _ in range(rng.randint(1, 4)):
        velocity, distance = rng.randint(300, 4000), rng.choice((-1, 1)) * rng.randint(1, 2000)
        command(0x31, 0, 0, *velocity.to_bytes(4, "big"), *rng.randint(20_000, 200_000).to_bytes(4, "big"))
        command(0x33, *(distance & 0xFFFF_FFFF).to_bytes(4, "big"))
        twin.run(rng.uniform(0.1, 1.0) if rng.random() < 0.3 else abs(distance) / velocity + 1.0)
    twin.run(8.0)
    return compared(seed, twin, "motor", 2, +1)


def smartmotor_program(seed: int) -> list[str]:
    """Run one program of a SmartMotor; its net pulses are its position after each move."""
    rng, wrong = random.Random(seed), []
    limits = tuple(
        InputPin(f"table.{pin}", BoardPin(at, inverted=True), stops=way, stops_at=True)
        for pin, at, way in (("C", "P8", +1), ("D", "P9", -1))
    )
    twin = Twin("smartmotor", (AxisPins("table.shaft", X.step, X.direction, X.enable),), limits, ())
    twin.say(b"ZS ", 1.0)
    for _ in range(rng.randint(1, 4)):
        order = f"A={rng.randint(20, 400)} V={rng.randint(10_000, 120_000)} P={rng.randint(-4000, 4000)} G "
        twin.say(order.encode(), rng.uniform(0.1, 2.0))
        if rng.random() < 0.3:
            twin.say(rng.choice((b"X ", b"S ")), 0.5)
    twin.run(5.0)
    net, position = sum(way for _, way in twin.metal.small.pulses[2]), twin.controller.axes["shaft"].position
    if net != position or twin.lines:
        wrong.append(f"program {seed}: shaft at {position}, {net} net pulses: {twin.lines}")
    return wrong


def kill(seed: int) -> list[str]:
    """Stop sending at a random time in a move; return the errors."""
    rng, metal = random.Random(seed), Metal(horizon_s=random.Random(seed).choice((0.1, 0.5))).start()
    metal.move("table.X", +1, metal.even(8000, rng.choice((500, 4000))), rng.uniform(0.02, 1.5))
    metal.alive, died = False, metal.now
    metal.run(1.0)
    last = max((metal.small.time_s(tick) for tick, _ in metal.small.pulses[2]), default=died)
    wrong = [f"kill {seed}: moving for {last - died:.3f} s"] if last - died > MOST_STANDSTILL_S else []
    return wrong + ([] if metal.small.levels[4] == 1 else [f"kill {seed}: the drive is enabled"])


def limit(seed: int) -> list[str]:
    """Open a limit switch at a random pulse; return the errors."""
    rng, twin = random.Random(seed), Twin(line="instant", axes=(X,), inputs=(LIMIT,), outputs=())
    twin.initialise()
    small, pulse = twin.metal.small, rng.randint(1, 1900)
    opened: list[int] = []

    def open_switch() -> None:
        opened.append(len(small.pulses[2]))
        small.levels[8] = 0

    twin.controller.serial.write(b"X2000 @ 4000 $ \r")
    while len(small.pulses[2]) < pulse - 9:  # at most 8 pulses in a tick
        twin.run(TICK_S)
    small.at(small.ticks + round(rng.uniform(0, 1.2 * TICK_S) * small.hz), open_switch)
    twin.run(1.0)
    made, axis, wrong = len(small.pulses[2]), twin.controller.axes["X"], []
    if made - opened[0] > 1:
        wrong.append(f"limit {seed}: {made - opened[0]} pulses after the switch at {opened[0]}")
    if axis.position != made or twin.say(b"N\r") != b"%d\r" % made:
        wrong.append(f"limit {seed}: position {axis.position}, {made} pulses")
    twin.say(b"K\r")
    twin.say(b"X-25 $ \r", 1.0)
    if axis.position != made - 25 or len(small.pulses[2]) != made + 25:
        wrong.append(f"limit {seed}: position {axis.position} after 25 pulses back from {made}: {twin.lines}")
    return wrong


def damage(seed: int) -> list[str]:
    """Damage 1 % of the bytes in both directions during a move; return the errors."""
    rng = random.Random(seed)

    def wire(data: bytes) -> bytes:
        out = bytearray()
        for byte in data:
            kind = rng.choice((0, 1, 2)) if rng.random() < DAMAGED else 3
            out += (b"", bytes((byte, byte)), bytes((rng.randrange(256),)), bytes((byte,)))[kind]
        return bytes(out)

    metal = Metal(horizon_s=0.5)
    metal.start()
    metal.wire = wire
    times = metal.even(rng.randint(500, 4000), rng.choice((500, 4000)))
    metal.move("table.X", rng.choice((+1, -1)), times)
    made = [metal.small.time_s(tick) for tick, _ in metal.small.pulses[2]]
    reasons = [event for event in metal.events[1:] if getattr(event, "reason", "")]
    wrong = []
    if len(made) > len(times) or (len(made) < len(times) and not reasons):
        wrong.append(f"damage {seed}: {len(made)} of {len(times)} pulses: {metal.events}")
    late = np.array(made) - times[: len(made)]
    if len(made) and (worst := np.abs(late - np.median(late)).max() * 1e6) > MOST_DRIFT_US:
        wrong.append(f"damage {seed}: an edge is off by {worst:.1f} µs")
    DAMAGE_STOPS.extend(reasons)
    return wrong


DAMAGE_STOPS: list[object] = []
"""Stops with a reason in the campaign of damaged bytes."""


class Jumping(SmallBoard):
    """A board whose clock is read with an error that jumps."""

    rng = random.Random(0)

    def run_to(self, seconds: float) -> None:
        """Advance to this time, later by up to 50 µs."""
        super().run_to(seconds + self.rng.uniform(0, JUMP_S))


def drift(seed: int, seconds: float) -> list[str]:
    """Make 100 pulses in each second for a long time, on boards with drifting clocks; return the errors."""
    wrong = []
    for sign in (+1, -1):
        small = Jumping(drift=sign * PPM)
        small.rng = random.Random(seed)
        metal = Metal(small, axes=(X,), inputs=(), outputs=()).start()
        times = metal.now + 0.5 + np.arange(1, round(seconds) * 100 + 1) / 100
        metal.move("table.X", +1, times)
        made = np.array([small.time_s(tick) for tick, _ in small.pulses[2]])
        if len(made) != len(times):
            wrong.append(f"drift {sign * PPM:+g}: {len(made)} of {len(times)} pulses: {metal.events[-1]}")
            continue
        late = (made - times) * 1e6
        worst = np.abs(late - np.median(late)).max()
        print(f"drift {sign * PPM:+g}: {len(made)} pulses, worst edge {worst:.1f} µs, sd {late.std():.1f} µs")
        if worst > MOST_DRIFT_US:
            wrong.append(f"drift {sign * PPM:+g}: an edge is off by {worst:.1f} µs")
    return wrong


CAMPAIGNS = {"programs": (program, 200), "kills": (kill, 100), "limits": (limit, 100), "damage": (damage, 100)}


def main() -> int:
    """Run the campaigns."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    for name, (_, number) in CAMPAIGNS.items():
        parser.add_argument(f"--{name}", type=int, default=number)
    parser.add_argument("--drift-s", type=float, default=3600.0)
    given = parser.parse_args()
    first, failed = given.seed * 10_000, False
    for name, (run, _) in CAMPAIGNS.items():
        number = getattr(given, name)
        wrong = [line for seed in range(first, first + number) for line in run(seed)]
        print("\n".join([*wrong, f"{'FAILED' if wrong else 'held'}: {number} {name}, seed {given.seed}"]), flush=True)
        failed = failed or bool(wrong)
    print(f"damage: {len(DAMAGE_STOPS)} stops with a reason")
    wrong = drift(given.seed, given.drift_s) if given.drift_s else []
    print("\n".join([*wrong, f"{'FAILED' if wrong else 'held'}: drift of {given.drift_s:g} s, seed {given.seed}"]))
    return 1 if failed or wrong else 0


if __name__ == "__main__":
    sys.exit(main())
