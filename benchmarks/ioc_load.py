"""Processor time of an IOC with 100 axes at 10 Hz, beside the motors.

    python benchmarks/ioc_load.py --seconds 20

34 virtual IF1s with 102 axes run in a process of their own, on served ports at 9600 baud.  The IOC is another process.
A client subscribes to VAL, RBV, DMOV and MOVN of each axis, and keeps one axis of each IF1 moving.  The exit code is 1
if the IOC needs half a core or more at 10 Hz.  On a loaded computer the virtual IF1s answer more slowly; the processor
time per reading is then multiplied by 10 Hz.
"""

import argparse
import asyncio
import json
import logging
import multiprocessing
import os
import socket
import sys
import time
from collections.abc import Awaitable, Callable
from multiprocessing.connection import Connection
from typing import Any

CONTROLLERS, RATE_HZ = 34, 10


def motors(ports: Connection) -> None:
    """Serve the controllers until the process is ended."""
    import axistwin

    bench = axistwin.Bench()
    for number in range(CONTROLLERS):
        bench.add("if1", name=f"c{number:02}", self_test_s=0.1)
    with axistwin.serve(bench) as twin:
        ports.send({name: str(url) for name, url in twin.ports.items()})
        time.sleep(3600)


def ioc(ports: dict[str, str], port: int, figures: Connection) -> None:
    """Serve the axes until the process is ended; count the polls."""
    from axistwin.drivers import AsyncController, make
    from axistwin.real.integrations import Machine, Station
    from axistwin.real.integrations.epics.ioc import Ioc

    async def run() -> None:
        stations = [Station(name, "if1", AsyncController(url, make("if1", {}))) for name, url in ports.items()]
        async with Machine(stations, 1 / RATE_HZ) as machine:
            served = Ioc(machine, "LAB:")
            polls = [0]
            for station in stations:
                axis = station.axes["Z"]
                axis.changed = counting(axis.changed, polls)
            async with served.serving(port=port):
                figures.send("ready")
                while True:
                    await asyncio.sleep(0.01)
                    if figures.poll():
                        figures.recv()
                        figures.send((time.process_time(), polls[0]))

    asyncio.run(run())


def counting(function: Callable[[], Awaitable[None]], counter: list[int]) -> Callable[[], Awaitable[None]]:
    """Return a function that counts its calls."""

    async def counted() -> None:
        counter[0] += 1
        await function()

    return counted


def client(port: int, events: Connection) -> None:
    """Subscribe to all axes, and keep one axis of each controller moving."""
    os.environ.update(EPICS_CA_ADDR_LIST="127.0.0.1", EPICS_CA_AUTO_ADDR_LIST="NO", EPICS_CA_SERVER_PORT=str(port))
    import epics

    logging.disable()
    heard = {"events": 0}

    def count(**_: object) -> None:
        heard["events"] += 1

    names = [f"LAB:c{number:02}:{axis}" for number in range(CONTROLLERS) for axis in "XYZ"]
    fields = ("VAL", "RBV", "DMOV", "MOVN")
    channels = [epics.PV(f"{name}.{field}", callback=count) for name in names for field in fields]
    for channel in channels:
        assert channel.wait_for_connection(60), channel.pvname
    for name in names[::3]:
        epics.caput(f"{name}.TWV", 100_000)
        epics.PV(f"{name}.TWF").put(1)
    events.send("moving")
    while True:
        if events.poll(0.05):
            events.recv()
            events.send(heard["events"])


def main() -> int:
    """Print the figures."""
    given = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    given.add_argument("--seconds", type=float, default=20)
    seconds = given.parse_args().seconds
    context = multiprocessing.get_context("spawn")
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]

    def begin(function: Callable[..., None], *arguments: object) -> Connection:
        here, there = context.Pipe()
        process = context.Process(target=function, args=(*arguments, there), daemon=True)
        process.start()
        processes.append(process)
        return here

    processes: list[Any] = []
    ports = begin(motors).recv()
    figures = begin(ioc, ports, port)
    assert figures.recv() == "ready"
    events = begin(client, port)
    assert events.recv() == "moving"
    time.sleep(2)

    def reading() -> tuple[float, ...]:
        figures.send(None)
        events.send(None)
        return (*figures.recv(), events.recv(), time.monotonic())

    first = reading()
    time.sleep(seconds)
    busy, polls, heard, wall = (late - early for early, late in zip(first, reading(), strict=True))
    for process in processes:
        process.terminate()
    rate = polls / CONTROLLERS / wall
    share = busy / wall * RATE_HZ / rate
    found = {"axes": 3 * CONTROLLERS, "polls_per_second": round(rate, 2), "events_per_second": round(heard / wall)}
    print(json.dumps({**found, "cores_at_10_hz": round(share, 3), "load": os.getloadavg()[0]}))
    print("passed" if share < 0.5 else "failed")
    return share >= 0.5


if __name__ == "__main__":
    sys.exit(main())
