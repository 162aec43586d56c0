"""Values that clients write and read by OPC UA: bad ones are refused and have no effect; each has its time stamps."""

import asyncio

import pytest

from axistwin import Bench

from ..bad_values import NOT_NUMBERS, TABLE

asyncua = pytest.importorskip("asyncua", reason="asyncua is not installed")

from asyncua import Client, ua  # noqa: E402

from axistwin.real.integrations import of_scene  # noqa: E402
from axistwin.real.integrations.opcua import server  # noqa: E402

from .conftest import PATIENCE, free_port  # noqa: E402
from .raw_opcua import code  # noqa: E402

METHODS = {
    "move_to": "MoveTo", "move_by": "MoveBy", "move_at": "MoveAt", "home": "Home", "set_position": "SetPosition",
}  # fmt: skip
VARIABLES = {"speed": "Speed", "acceleration": "Acceleration"}
KINDS = {bool: ua.VariantType.Boolean, str: ua.VariantType.String, type(None): ua.VariantType.Null}


def with_client(test, *models, speed=None, **options):
    """Run a test with a client of a served bench; `options`: of a model, by its first axis."""

    async def run():
        bench = Bench()
        for model in models:
            axis = {"if1": "X", "1811": "motor", "smartmotor": "shaft"}[model]
            bench.add(model, name=model, **({axis: options[axis]} if axis in options else {}))
        patient, registers = dict.fromkeys(models, PATIENCE), ["smartmotor.a"] if "smartmotor" in models else ()
        async with (
            await of_scene(bench, patient, speed=speed, registers=registers) as machine,
            server.serving(machine, port=free_port()) as url,
            Client(url, timeout=300) as client,
        ):
            return await test(client, machine)

    return asyncio.run(run())


@pytest.mark.slow
def test_bad_values_are_refused_and_have_no_effect():
    async def refuse(client, machine):
        accepted = []
        for model, axis in (("if1", "X"), ("1811", "motor"), ("smartmotor", "shaft")):
            core = next(station for station in machine.stations if station.name == model).axes[axis].core
            node, before = client.get_node(f"ns=2;s={model}.{axis}"), (core.velocity, core.acceleration)
            every = [*TABLE, *((name, value) for name in METHODS | VARIABLES for value in NOT_NUMBERS)]
            for name, value in every:
                given = ua.Variant(value, KINDS.get(type(value), ua.VariantType.Double))
                if name in METHODS:
                    answer = await code(node.call_method(f"2:{METHODS[name]}", given))
                else:
                    variable = client.get_node(f"ns=2;s={model}.Axes.{axis}.{VARIABLES[name]}")
                    answer = await code(variable.write_attribute(ua.AttributeIds.Value, ua.DataValue(given)))
                expected = "BadTypeMismatch" if value in NOT_NUMBERS and not isinstance(value, int | float) else None
                if answer not in ({expected} if expected else {"BadOutOfRange", "BadTypeMismatch"}):
                    accepted.append((model, name, value, answer))
            assert (core.velocity, core.acceleration) == before
            assert not await client.get_node(f"ns=2;s={model}.Axes.{axis}.Busy").read_value()
        return accepted

    assert with_client(refuse, "if1", "1811", "smartmotor") == []


@pytest.mark.slow
def test_a_value_of_another_type_is_not_written():
    async def write(client, machine):
        speed, pin = client.get_node("ns=2;s=1811.Axes.motor.Speed"), client.get_node("ns=2;s=1811.Pins.output1")
        register = client.get_node("ns=2;s=smartmotor.Registers.a")
        several = ua.WriteParameters()
        for node, value in ((speed, 5000.0), (speed, -1.0), (pin, True)):
            several.NodesToWrite.append(ua.WriteValue(node.nodeid, ua.AttributeIds.Value, Value=ua.DataValue(value)))
        bad = ua.DataValue(4000.0, StatusCode=ua.StatusCode(ua.StatusCodes.Bad))
        return {
            "integer": await code(speed.write_value(7, ua.VariantType.Int64)),
            "list": await code(speed.write_value([7.0], ua.VariantType.Double)),
            "bad": await code(speed.write_value(bad)),
            "33 bits": await code(register.write_value(2**31, ua.VariantType.Int64)),
            "pin": await code(pin.write_value(1, ua.VariantType.Int64)),
            "few": await code(client.get_node("ns=2;s=1811.motor").call_method("2:MoveTo")),
            "many": await code(client.get_node("ns=2;s=1811.motor").call_method("2:Stop", 1.0)),
            "each": [ua.StatusCode(each.value).name for each in await client.uaclient.write(several)],
            "speed": await speed.read_value(),
            "core": machine.stations[0].axes["motor"].core.velocity,
        }

    assert with_client(write, "1811", "smartmotor") == {
        "integer": "BadTypeMismatch", "list": "BadTypeMismatch", "bad": "BadWriteNotSupported",
        "33 bits": "BadOutOfRange", "pin": "BadTypeMismatch", "few": "BadArgumentsMissing",
        "many": "BadTooManyArguments", "each": ["Good", "BadOutOfRange", "Good"], "speed": 5000.0, "core": 5000.0,
    }  # fmt: skip


@pytest.mark.slow
def test_values_have_time_stamps_in_reads_and_subscriptions():
    async def read(client, _):
        found, seen = {}, asyncio.Queue()

        class Changes:
            def datachange_notification(self, node, value, data):
                seen.put_nowait((node, data.monitored_item.Value))

        names = ("Position", "Busy", "Faults", "LastError", "Speed")
        nodes = [client.get_node(f"ns=2;s=1811.Axes.motor.{name}") for name in names]
        nodes += [
            client.get_node(f"ns=2;s=1811.{name}") for name in ("Pins.output1", "Pins.trigger2", "Identification.Model")
        ]
        for node in nodes:
            found[node.nodeid.Identifier] = [await node.read_data_value(raise_on_bad_status=False)]
        subscription = await client.create_subscription(10, Changes())
        await subscription.subscribe_data_change(nodes)
        await nodes[4].write_value(4000.0)
        await client.get_node("ns=2;s=1811.motor").call_method("2:MoveTo", 100.0)
        while len(found["1811.Axes.motor.Speed"]) < 3 or found["1811.Axes.motor.Position"][-1].Value.Value != 100:
            node, value = await seen.get()
            found[node.nodeid.Identifier].append(value)
        return found

    found = with_client(read, "1811")
    assert all(len(values) > 1 for values in found.values())
    for values in found.values():
        assert all(value.SourceTimestamp and value.ServerTimestamp for value in values)
        assert all(value.SourceTimestamp <= value.ServerTimestamp for value in values)
        stamps = [value.SourceTimestamp for value in values]
        assert stamps == sorted(stamps)
