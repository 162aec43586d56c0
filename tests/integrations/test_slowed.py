"""Drivers at controllers of a scene that is slower than real time: their time-outs are in the controller's time."""

import asyncio
from types import SimpleNamespace

import pytest

from axistwin import Bench
from axistwin.real.integrations import of_scene, paced_port

OPTIONS = {"if1": {"self_test_s": 0.1, "recalculation_s": 0.1}, "1811": {}}
"""The self-test of the IF1 takes 0.5 s of real time at a fifth of the speed."""


@pytest.mark.slow
@pytest.mark.parametrize(("model", "axis"), [("if1", "X"), ("1811", "motor")])
def test_a_slow_controller_is_no_silent_one(model, axis):
    async def move():
        bench = Bench()
        bench.add(model, name=model, **OPTIONS[model])
        machine = await of_scene(bench, {model: {"timeout": 0.3}}, speed=0.2)
        async with machine:
            polling = asyncio.ensure_future(machine.run())
            await machine.stations[0].axes[axis].move_to(20)
            polling.cancel()
            await asyncio.gather(polling, return_exceptions=True)
            return machine.stations[0].axes[axis].status.position

    assert asyncio.run(move()) == 20


class Slow:
    """A pacer and a port in one: each read and each look at the clock takes 100 ms of virtual time."""

    speed = 0.5

    def __init__(self, data=b""):
        self.clock, self.waits, self._data = SimpleNamespace(now=0), [], data

    def work(self):
        self.clock.now += 100_000_000

    async def read(self, timeout):
        self.waits.append(timeout)
        return self._data if len(self.waits) == 3 else b""


def test_a_time_out_ends_in_virtual_time():
    slow = Slow()
    assert asyncio.run(paced_port.PacedPort(slow, slow).read(0.5)) == b""
    # The clock reads 0.1 s at first, so the end is at 0.6 s: 0.4 s of 0.5 times real time is left after the next look.
    assert slow.waits == pytest.approx([0.8, 0.4, 0.001, 0.001])
    assert asyncio.run(paced_port.PacedPort(given := Slow(b"A"), given).read(10)) == b"A"
