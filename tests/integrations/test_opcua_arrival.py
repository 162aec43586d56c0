"""`Arrived` is true only where an axis stands at its target, and `LastError` says why it does not."""

import asyncio

import pytest

asyncua = pytest.importorskip("asyncua", reason="asyncua is not installed")

from .test_opcua_values import with_client  # noqa: E402

STOPS = {
    "1811": lambda core: core._send_command(0x70),
    "if1": lambda core: core.message("#"),
    "smartmotor": lambda core: core.send(b"", "X"),
}


class Watched:
    def __init__(self, client, model, axis):
        self.names = ("Busy", "Moving", "Arrived")
        self._node, self._client, self._base = client.get_node(f"ns=2;s={model}.{axis}"), client, f"{model}.Axes.{axis}"
        self.reported = asyncio.Queue()

    def variable(self, name):
        return self._client.get_node(f"ns=2;s={self._base}.{name}")

    async def watch(self):
        subscription = await self._client.create_subscription(10, self)
        await subscription.subscribe_data_change([self.variable(name) for name in self.names])

    def datachange_notification(self, node, value, data):
        self.reported.put_nowait((node.nodeid.Identifier.rpartition(".")[2], value))

    async def until(self, name, value):
        while await self.reported.get() != (name, value):
            pass

    async def call(self, name, *arguments):
        await self._node.call_method(f"2:{name}", *map(float, arguments))

    async def at_rest(self):
        await self.until("Busy", False)
        return [await self.variable(name).read_value() for name in ("Arrived", "LastError", "Position")]


@pytest.mark.slow
def test_a_motion_has_arrived_only_at_its_target():
    async def move(client, station):
        axis, driver = Watched(client, station.name, next(iter(station.axes))), station.driver
        await axis.watch()
        await axis.until("Busy", False)
        ends = {}
        for way in ("another host", "Stop", "nobody", "a run"):
            await axis.call(*{"a run": ("MoveAt", 900), "nobody": ("MoveBy", 300)}.get(way, ("MoveTo", 90_000)))
            if way != "nobody":
                await axis.until("Moving", True)
                stop = STOPS[station.name](driver.core)
                await (driver.run(stop) if way == "another host" else axis.call("Stop"))
            ends[way] = await axis.at_rest()
        await axis.call("SetPosition", 7)
        return ends, await axis.variable("Arrived").read_value()

    async def all_at_once(client, machine):
        return await asyncio.gather(*(move(client, station) for station in machine.stations))

    reasons = {"another host": "another host or program stopped it", "Stop": "a client stopped the axis"}
    for ends, after in with_client(all_at_once, *STOPS, speed=5):
        for way, reason in reasons.items():
            arrived, error, position = ends[way]
            assert not arrived and reason in error and 0 < position < 90_000
        assert ends["nobody"] == [True, "", ends["Stop"][2] + 300] and ends["a run"][:2] == [False, ""]
        assert not after


@pytest.mark.slow
def test_a_motion_into_a_switch_has_not_arrived_and_the_way_back_has():
    async def move(client, station):
        axis = Watched(client, station.name, next(iter(station.axes)))
        await axis.watch()
        await axis.until("Busy", False)
        await axis.call("MoveTo", 90_000)
        switch = await axis.at_rest()
        await axis.call("ClearFaults")
        await axis.call("MoveTo", 100)
        return switch, await axis.at_rest()

    async def all_at_once(client, machine):
        return await asyncio.gather(*(move(client, station) for station in machine.stations))

    limits = {"limits": [-2000, 2000]}
    for switch, back in with_client(all_at_once, *STOPS, speed=5, X=limits, motor=limits, shaft=limits):
        arrived, error, position = switch
        assert not arrived and "limit" in error and 2000 <= position < 3000
        assert back == [True, "", 100]
