"""Random bytes at every baud rate to a served controller, while a host polls another controller of the same process.

    python benchmarks/robustness/fairness.py [--seed 11] [--bytes 1000]

Printed, as processor time of the process: the longest step of the simulation, and the longest time from a request of
the other host to its answer, at 9600 baud.  Exit code 0: no step above 5 ms, no answer after more than 50 ms.
"""

import asyncio
import contextlib
import gc
from time import process_time

from axistwin.links.server import Server
from axistwin.links.urls import PortUrl, parse
from axistwin.sim.clock import Clock
from fuzz import BAUD_RATES, PORTS, arguments, garbage, motors

BYTES = 1000
LONGEST_STEP_S, LONGEST_WAIT_S = 0.005, 0.050
FLOOD_S = 0.6
"""Duration of the attack: the bytes are sent repeatedly, as fast as they are received."""
ATTACKED = {
    **PORTS,
    "smartmotor moving": lambda: motors("single", moving=True),
    "smartmotor chain moving": lambda: motors("chain", moving=True),
    "smartmotor rs485 moving": lambda: motors("rs485", moving=True),
}


class Steps:
    """Clock that measures the time of each step."""

    def __init__(self, clock: Clock) -> None:
        self.longest_s, self._step = 0.0, clock.step
        clock.step = self._measured  # type: ignore[method-assign]

    def _measured(self) -> None:
        began = process_time()
        self._step()
        self.longest_s = max(self.longest_s, process_time() - began)


async def attack(name: str, baudrate: int, data: bytes) -> tuple[float, float]:
    """Return the longest step and the longest wait of the other host, in seconds of processor time."""
    target = ATTACKED[name]()
    bench = target.bench
    other = bench.add("if1", "other")
    bench.run(1.1)
    for text in (b"(", b"U61\r"):
        other.serial.write(text)
        bench.run(1.2)
    gc.collect()
    gc.freeze()  # `axistwin serve` does this too
    steps = Steps(bench.clock)
    server = Server(bench, speed=1.0)
    try:
        attacked = await server.open(target.name, parse("tcp://127.0.0.1:0"))
        asked = await server.open("other", parse("tcp://127.0.0.1:0"))
        server.start()
        flooding = asyncio.ensure_future(flood(server, target.name, attacked, baudrate, data))
        waited_s = await ask_until(asked, flooding)
    finally:
        server.close()
    return steps.longest_s, waited_s


async def flood(server: Server, name: str, url: PortUrl, baudrate: int, data: bytes) -> None:
    """Send data without end, as a host at a wrong baud rate."""
    reader, writer = await asyncio.open_connection(url.host, url.port)
    await asyncio.sleep(0.02)
    plug = server._plug(name)
    plug.change(lambda: setattr(plug.serial.host, "baudrate", baudrate))
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(FLOOD_S):
            while True:
                writer.write(data)
                await writer.drain()
                await asyncio.sleep(0)
    writer.close()
    del reader


async def ask_until(url: PortUrl, flooding: "asyncio.Future[None]") -> float:
    """Repeat a request; return the longest time to an answer."""
    reader, writer = await asyncio.open_connection(url.host, url.port)
    longest_s = 0.0
    while not flooding.done():
        began = process_time()
        writer.write(b"E\r")
        await reader.readuntil(b"\r")
        longest_s = max(longest_s, process_time() - began)
        await asyncio.sleep(0.002)
    await flooding
    writer.close()
    return longest_s


def main() -> int:
    """Print the measurements and the verdict."""
    given = arguments(__doc__, BYTES)
    seed, count = given.seed, given.bytes
    good = True
    print(f"seed {seed}, {count} bytes each; milliseconds of processor time")
    for name in ATTACKED:
        for baudrate in BAUD_RATES:
            step_s, wait_s = asyncio.run(attack(name, baudrate, garbage(seed, count)))
            bad = step_s > LONGEST_STEP_S or wait_s > LONGEST_WAIT_S
            good &= not bad
            print(f"{name:24} {baudrate:>9,} baud: longest step {step_s * 1e3:6.2f} ms, "
                  f"longest wait {wait_s * 1e3:6.2f} ms{'  BAD' if bad else ''}", flush=True)  # fmt: skip
    print("verdict:", "good" if good else "BAD")
    return 0 if good else 1


if __name__ == "__main__":
    raise SystemExit(main())
