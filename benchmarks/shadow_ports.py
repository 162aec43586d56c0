"""The plants of `shadow.py` on real ports: `python benchmarks/shadow.py ports`.

The machine is served on a pty, at RFC 2217 or at a bus socket, the relay of `axistwin shadow` is connected to it, and
the host to the relay, by the same kind of port.  Virtual time stands still while bytes are on their way, so that a run
is the same on fast and slow computers.
"""

import socket
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from queue import Empty, Queue
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))

import shadow as campaign
from axistwin.bench import Bench
from axistwin.core.units import MS
from axistwin.links.loop_thread import LoopThread
from axistwin.links.manual_pacer import ManualPacer
from axistwin.links.relay import Relay
from axistwin.links.server import Server
from axistwin.links.urls import PortUrl, parse
from axistwin.real.hosts.real_time import COMMAND_READY, INPUT_READY, MESSAGE_READY, MESSAGE_TAKEN, open_end
from axistwin.real.shadow.bus_relay import BusRelay
from axistwin.real.shadow.dialects.compumotor import BusTalk
from axistwin.sim.serial_port import Flow

PATIENCE_S = 60.0
POLL_NS = 5 * MS
LEARNING = 8
PORTS = ("pty", "rfc2217")
WORN = {
    "if1": ("limit 50 pulses early", "answers 40 ms late"),
    "1811": ("limit 50 pulses early", "lost steps, seen by the encoder"),
    "smartmotor": ("limit 50 counts early", "ramp 5 % slower"),
    "esp300": ("limit 50 counts early", "a lost character"),
}


class WiredRig(campaign.Rig):
    """A rig whose machine is at the far end of real ports; `folder` contains the links of ptys."""

    def __init__(self, kind: str, folder: Path, model: str, machine: Bench, twin: Bench, **settings: Any) -> None:
        super().__init__(model, machine, twin, **settings)
        self.machine.detach()
        self._far, self._near = LoopThread(), LoopThread()  # Of the machine's server, and of the relay.
        self._pacer = ManualPacer(machine)
        self._server = Server(machine, flow=Flow.NONE, pacer=self._pacer)
        self._queues: dict[bool, Queue[bytes]] = {True: Queue(), False: Queue()}  # From the host, from the machine.
        self._url = f"pty:{folder}/" if kind == "pty" else f"{kind}://127.0.0.1:0"
        name = self.controller.name
        self._connect(name, self._far.run(self._server.open(name, self._port("machine"))))

    def _port(self, end: str) -> PortUrl:
        return parse(self._url + end if self._url.startswith("pty:") else self._url)

    def _connect(self, name: str, port: PortUrl) -> None:
        line = self.controller.product.line
        assert line is not None
        self._heard = Queue[bytes]()
        self.controller.serial.subscribe_sent(self._heard.put)
        self.controller.serial.subscribe_received(self._byte)
        self._relay = Relay(port.path or str(port), name, line)

        async def begin() -> PortUrl:
            self._host_side = Server(self._relay.bench, flow=Flow.NONE)
            opened = await self._host_side.open(name, self._port("host"))
            self._host_side.start()
            self._relay.relayed.subscribe(lambda by_host, data: self._queues[by_host].put(data))
            self._relay.start(self._host_side.pacer, print)
            return opened

        self._end = open_end(str(self._near.run(begin())), line)
        self._settle()

    def _settle(self) -> None:
        """Wait until what the opening of the ports has caused is over: settings, and emptied buffers."""
        before, now = (-1, -1), (0, 0)
        while before != now:
            for _ in range(10):
                self._near.do(lambda: None)
            if self._relay._latest is not None:
                self._relay._latest.result(PATIENCE_S)
            before, now = now, (self._relay._done, self._far.run(self._pacer.receive_all()))

    def say(self, data: bytes) -> None:
        self._late_ns = self._random.randrange(self._jitter_ns + 1)
        while not self._heard.empty():
            self._heard.get()
        self._end.send(data)
        relayed = exactly(self._queues[True], len(data))
        assert relayed == data == exactly(self._heard, len(data))
        self.shadow.host(self.now, relayed)

    def _byte(self, byte: int, _: object) -> None:
        self._far.do(self._pacer.work)
        relayed, received = exactly(self._queues[False], 1), b""
        while not received:
            received = self._end.receive()
        assert relayed == received == bytes((byte,))
        self._said(self.bench.now, relayed)

    def close(self) -> None:
        self._end.close()
        self._near.do(self._host_side.close)
        self._relay.close()
        self._far.do(self._server.close)
        self._near.stop()
        self._far.stop()


class BusRig(WiredRig):
    """A rig whose board is at a bus socket: the host polls its status byte."""

    def _connect(self, name: str, port: PortUrl) -> None:  # noqa: ARG002
        self._passed: Queue[tuple[bool, bytes]] = Queue()
        self._bus = BusRelay(port, lambda by_host, data: self._passed.put((by_host, data)))
        opened = self._near.run(self._bus.open(self._port("host")))
        with socket.create_connection((opened.host, opened.port), PATIENCE_S) as connection:
            self._line = connection.makefile("rw", newline="\n")  # It keeps the connection open.
        self._talk = BusTalk(
            lambda data: self.shadow.host(self.now, data), lambda data: self._said(self.bench.now, data),
            lambda: self.shadow.absent(self.now),
        )  # fmt: skip

    def _request(self, words: str) -> str:
        self._line.write(words + "\n")
        self._line.flush()
        answer, relayed = self._line.readline(), 0
        while relayed < len(answer):  # The relay tells what it has passed on afterwards.
            by_host, data = self._passed.get(timeout=PATIENCE_S)
            (self._talk.host if by_host else self._talk.board)(data)
            relayed += 0 if by_host else len(data)
        return answer.strip()

    def say(self, data: bytes) -> None:
        self._late_ns = self._random.randrange(self._jitter_ns + 1)
        while not int(self._request("r 1"), 16) & INPUT_READY:
            self.run(0.001)
        self._request("w 0 " + data.hex(" "))
        self._request(f"w 1 {COMMAND_READY:02x}")

    def _run_until(self, end_ns: int, enough: Callable[[], bool] = lambda: False) -> None:
        while not enough() and self.bench.now < end_ns:
            super()._run_until(min(end_ns, self.bench.now + POLL_NS), enough)
            if int(self._request("r 1"), 16) & MESSAGE_READY:
                self._request("r 0 16")
                self._request(f"w 1 {MESSAGE_TAKEN:02x}")

    def close(self) -> None:
        self._line.close()
        self._near.do(self._bus.close)
        self._far.do(self._server.close)
        self._near.stop()
        self._far.stop()


def exactly(queue: "Queue[bytes]", size: int) -> bytes:
    """Return this number of bytes.  Raises TimeoutError if they do not come."""
    data = b""
    while len(data) < size:
        try:
            data += queue.get(timeout=PATIENCE_S)
        except Empty:
            raise TimeoutError(f"{data!r} instead of {size} bytes") from None
    return data


@contextmanager
def wired(kind: str) -> Iterator[Callable[..., WiredRig]]:
    """Yield a function that makes rigs on this kind of port."""
    made: list[WiredRig] = []

    def make(*given: Any, **settings: Any) -> WiredRig:
        made.append((BusRig if kind == "bus" else WiredRig)(kind, Path(folder), *given, **settings))
        return made[-1]

    with tempfile.TemporaryDirectory() as folder:
        try:
            yield make
        finally:
            for rig in made:
                rig.close()


def ports(seed: int, only: str) -> bool:
    """Plant two signs of wear for each model and kind of port; print what was found."""
    good, count, began = 0, 0, time.monotonic()
    for plant in campaign.PLANTS:
        for kind in ("bus",) if plant.model == "1811" else PORTS:
            if plant.name in WORN[plant.model] and only in f"{plant.model} {kind} {plant.name}":
                with wired(kind) as make:
                    verdict = campaign.verdict(plant, *campaign.tried(plant, seed, LEARNING, make=make))
                good, count = good + verdict.startswith("found"), count + 1
                print(f"{plant.model:10} {kind:8} {plant.name:32} {verdict}", flush=True)
    print(f"{good} of {count} found on real ports within three occurrences ({time.monotonic() - began:.0f} s)")
    return good == count
