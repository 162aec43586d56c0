"""Values that clients write by Channel Access and PV Access: bad ones are refused and have no effect."""

import asyncio
from contextlib import asynccontextmanager
from math import inf, nan

import pytest

from axistwin import Bench
from axistwin.real.integrations import of_scene

from ..bad_values import TABLE
from .conftest import PATIENCE, free_port

ca = pytest.importorskip("caproto", reason="caproto is not installed")

from axistwin.real.integrations.epics.ioc import Ioc  # noqa: E402

from .test_channel_access import Visitor  # noqa: E402

FIELDS = {
    "move_to": ("VAL", "DVAL", "RVAL"), "move_by": ("RLV",), "move_at": ("JVEL",), "home": ("HOMF", "HOMR"),
    "set_position": ("VAL", "DVAL", "RVAL", "OFF"), "speed": ("VELO", "VMAX", "JVEL"), "acceleration": ("ACCL",),
}  # fmt: skip
SWITCHES = ("JOGF", "JOGR", "HOMF", "HOMR", "TWF", "TWR", "STOP", "SYNC", "PROC")
MENUS = ("SPMG", "SET", "FOFF", "DIR", "STUP")
WRITES = [
    (field, value, name == "set_position")
    for name, value in TABLE
    for field in FIELDS[name]
    if field not in SWITCHES or value != 0  # which begins no search, as in EPICS
]
"""Field, value, and True if the field SET is 1."""
AXES = [("if1", "X"), ("1811", "motor"), ("smartmotor", "shaft")]


class Lab:
    """The axes of an IOC, and a client's way to write to them: `put` returns why a write was refused, or ""."""

    def __init__(self, ioc, put):
        self.records = {record.name: record for record in ioc.motors}
        self.points, self.put = ioc.points, put

    def state(self):
        """Return all fields but those that tell of a refusal, and the profile of each driver."""
        cores = [(record.axis.core.velocity, record.axis.core.acceleration) for record in self.records.values()]
        return [record.values | {"LVIO": 0, "SET": 0} for record in self.records.values()], cores

    async def accepted(self, writes, axis):
        """Return the writes that were not refused, or that had an effect."""
        found = []
        for record in self.records.values():
            record.axis.station.wake()
            await record.axis.station.polled()  # the first reading changes fields
        for field, value, setting in writes:
            await self.put(f"{axis}.SET", int(setting))
            before = self.state()
            if not await self.put(f"{axis}.{field}", value) or self.state() != before:
                found.append((field, value, setting))
        return found


@asynccontextmanager
async def ioc_of(*models, **options):
    bench = Bench()
    for model in models:
        bench.add(model, name=model)
    async with await of_scene(bench, dict.fromkeys(models, PATIENCE), speed=None, **options) as machine:
        made, port = Ioc(machine, "P:"), free_port()
        yield made, port


@asynccontextmanager
async def by_channel_access(*models, **options):
    async with ioc_of(*models, **options) as (ioc, port), ioc.serving(port=port):
        client = Visitor(*await asyncio.open_connection("127.0.0.1", port), port)
        client.send(ca.VersionRequest(0, 13))
        channels = {}

        async def put(name, value):
            if name not in channels:
                channels[name] = client.other(name)
                client.send(channels[name].create())
                await client.until(ca.CreateChanResponse)
            kind = ca.ChannelType.STRING if isinstance(value, bytes) else ca.ChannelType.DOUBLE
            client.send(channels[name].write((value,), data_type=kind, notify=True))
            answer = await client.until((ca.WriteNotifyResponse, ca.ErrorResponse))
            if isinstance(answer, ca.WriteNotifyResponse):
                return ""
            assert answer.status.name == "ECA_PUTFAIL"
            return bytes(answer.error_message).strip(b"\0").decode() or "refused"

        yield Lab(ioc, put)
        client.leave(abort=False)
        await client.gone()


@asynccontextmanager
async def pv_access_client(port):
    asynchronous = pytest.importorskip("p4p.client.asyncio", reason="p4p is not installed")
    here = {"ADDR_LIST": "127.0.0.1", "AUTO_ADDR_LIST": "NO"}
    here |= {"SERVER_PORT": str(port + 11), "BROADCAST_PORT": str(port + 12)}
    conf = {f"EPICS_PVA_{name}": value for name, value in here.items()}
    with asynchronous.Context("pva", conf=conf, useenv=False) as client:
        yield client


@asynccontextmanager
async def by_pv_access(*models, **options):
    remote = pytest.importorskip("p4p.client.raw", reason="p4p is not installed").RemoteError
    async with (
        ioc_of(*models, **options) as (ioc, port),
        ioc.serving(port=port, pv_access=True),
        pv_access_client(port) as client,
    ):

        async def put(name, value):
            try:
                await client.put(name, value)
            except remote as error:
                return str(error)
            return ""

        yield Lab(ioc, put)


def test_channel_access_refuses_bad_values():
    async def session():
        async with by_channel_access(*dict(AXES)) as lab:
            words = [(field, b"five", False) for field in dict.fromkeys(field for field, *_ in WRITES)]
            found = {model: await lab.accepted(WRITES + words, f"P:{model}:{axis}") for model, axis in AXES}
            return found, await lab.put("P:1811:motor.VAL", 100), lab.records["P:1811:motor"].values["RBV"]

    assert asyncio.run(session()) == ({model: [] for model, _ in AXES}, "", 100)


@pytest.mark.slow
def test_pv_access_refuses_bad_values():
    """The client's library itself refuses a text, and makes an integer of a number for an integer field."""

    async def session():
        async with by_pv_access(*dict(AXES)) as lab:
            writes = [write for write in WRITES if write[0] not in SWITCHES or write[1] in (2, -2)]
            found = {model: await lab.accepted(writes, f"P:{model}:{axis}") for model, axis in AXES}
            return found, await lab.put("P:1811:motor.VAL", 100), lab.records["P:1811:motor"].values["RBV"]

    assert asyncio.run(session()) == ({model: [] for model, _ in AXES}, "", 100)


def test_no_number_becomes_another_integer_by_channel_access():
    async def session():
        async with by_channel_access("1811", "smartmotor", registers=["smartmotor.a"]) as lab:
            numbers = (nan, inf, -inf, 0.5, -1, 2.0**31, 2.0**32 + 1, 1e300)
            writes = [(field, value, False) for field in SWITCHES + MENUS for value in (*numbers, 7)]
            accepted = await lab.accepted(writes + [("PREC", value, False) for value in numbers], "P:1811:motor")
            names = {"P:1811:output1": (*numbers, 2), "P:smartmotor:A": (*numbers, 2), "P:smartmotor:a": numbers}
            await lab.put("P:1811:output1", 1)
            await lab.put("P:smartmotor:a", 5)
            points = [
                (name, value)
                for name, values in names.items()
                for value in values
                if (name, value) != ("P:smartmotor:a", -1) and not await lab.put(name, value)
            ]
            return accepted, points, lab.points["P:1811:output1"].value, lab.points["P:smartmotor:a"].value

    assert asyncio.run(session()) == ([], [], 1, 5)


def test_pv_access_refuses_a_put_without_a_value():
    """Its default is 0, which would be a target, or Stop."""

    async def session():
        async with by_pv_access("1811") as lab:
            motor = "P:1811:motor"
            arrived = await lab.put(motor, 100)
            writes = [("VAL", {"alarm.severity": 1}), ("SPMG", {"value.choices": ["Go"]}), ("SPMG", 7), ("SPMG", -1)]
            writes += [("DESC", "x" * 40), ("PREC", -1), ("PREC", 16)]
            accepted = await lab.accepted([(*write, False) for write in writes], motor)
            pins = [await lab.put("P:1811:output1", 7), lab.points["P:1811:output1"].value]
            return arrived, accepted, pins, lab.records[motor].values["RBV"]

    assert asyncio.run(session()) == ("", [], ["output1 cannot be 7: expected 0 or 1", None], 100)


@pytest.mark.parametrize("stops", [False, True])
def test_a_client_of_pv_access_may_leave_before_its_move_ends(stops):
    async def session():
        escaped = []
        asyncio.get_running_loop().set_exception_handler(lambda _, context: escaped.append(context["message"]))
        async with ioc_of("1811") as (ioc, port), ioc.serving(port=port, pv_access=True):
            (record,) = ioc.motors
            async with pv_access_client(port) as client:
                put = asyncio.ensure_future(client.put(record.name, 5000))
                while not record.axis.busy:
                    await asyncio.sleep(0)
            put.cancel()
            await asyncio.gather(put, return_exceptions=True)
            if stops:
                await record.put("STOP", 1)
            while record.axis.busy:
                await record.axis.station.polled()
            async with pv_access_client(port) as client:
                return escaped, await client.get(f"{record.name}.RBV") == record.values["RBV"], record.values["DMOV"]

    assert asyncio.run(session()) == ([], True, 1)


def test_a_ramp_that_is_too_short_for_a_number_is_refused():
    async def session():
        async with by_channel_access("smartmotor") as lab:
            motor = "P:smartmotor:shaft"
            accepted = await lab.put(f"{motor}.ACCL", 1e-300)
            return accepted, await lab.put(motor, 100), lab.records[motor].values["DMOV"]

    expected = "Python exception: RefusedError ACCL=1e-300 is out of range: expected a longer time"
    assert asyncio.run(session()) == ("", expected, 1)
