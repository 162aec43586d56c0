"""Going back in a session: processor time to return to the last second of an hour with ten polls a second.

The reference is a bare SimPy environment with two events for each character, in the same run.  The polled controllers
are an IF1, a SmartMotor at rest, and a SmartMotor in motion.
"""

import asyncio
import sys
from pathlib import Path
from time import process_time

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

import simpy

from axistwin import Bench
from axistwin.core.units import MS, S
from axistwin.scenes.sessions.session import Session

SECONDS, PERIOD_MS, RUNS = 3600, 100, 3
GOAL_S = 5.0
IF1 = ((1200, b"("), (2400, b"U61\r"))
REST = ((500, b"UCI UDI ZS "), (1000, b"A=100 V=100000 P=4000 G "))
MOTION = ((500, b"UCI UDI ZS "), (1000, b"A=100 MV V=200000 G "))
HOSTS = (
    ("an IF1", "if1", IF1, b"E\r"),
    ("a SmartMotor at rest", "smartmotor", REST, b"RP "),
    ("a SmartMotor in motion", "smartmotor", MOTION, b"RP "),
)
"""Name, model, first messages with their times in ms, poll."""


def main() -> None:
    """Print the processor times and the ratios."""
    for name, model, first, poll in HOSTS:
        seconds, characters = asyncio.run(measure(model, first, poll))
        ratio = seconds / min(bare(characters) for _ in range(RUNS))
        print(f"back to the last second of an hour, {name}: {seconds:.1f} s of processor time (goal <= {GOAL_S:g})")
        print(f"  {ratio:.1f} times the {2 * characters:,} events of a bare SimPy environment")


async def measure(model: str, first: tuple[tuple[int, bytes], ...], poll: bytes) -> tuple[float, int]:
    """Return the processor time of going back, the least of some runs, and the number of characters in the hour."""

    def build() -> Bench:
        bench = Bench()
        bench.add(model)
        return bench

    session = Session(build)
    port, characters = session.input.serial(model), 0
    for at_ms, data in first:
        session.advance(at_ms * MS)
        port.write(data)
    for at_ms in range(3500, SECONDS * 1000, PERIOD_MS):
        session.advance(at_ms * MS)
        port.write(poll)
        characters += len(poll) + len(port.read())
    session.advance(SECONDS * S)
    assert characters > 0.99 * SECONDS * 1000 / PERIOD_MS * (len(poll) + len(b"0\r")), "it does not answer"
    spent = []
    for _ in range(RUNS):
        began = process_time()
        await session.go_to(SECONDS - 1)
        spent.append(process_time() - began)
        await session.go_to(SECONDS)
    return min(spent), characters


def bare(characters: int) -> float:
    """Return the processor time of as many characters in a bare SimPy environment, with two events for each."""
    environment = simpy.Environment()

    def sending() -> simpy.events.ProcessGenerator:
        for _ in range(characters):
            yield environment.timeout(MS)
            yield environment.timeout(0)

    environment.process(sending())
    began = process_time()
    environment.run()
    return process_time() - began


if __name__ == "__main__":
    main()
