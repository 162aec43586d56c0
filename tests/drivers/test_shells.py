"""The synchronous and the asyncio shell: ports, units, disconnections."""

import asyncio
import subprocess
import sys

import pytest

import axistwin
from axistwin.drivers import DriverError, PortError, RefusedError, Scale, SilentError, connect, connect_async

from ..told import raises
from .devices import answering, url_of


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:set:DeprecationWarning")  # pyserial
@pytest.mark.parametrize("scheme", ["tcp", "rfc2217"])
def test_asyncio(scheme):
    async def session(url):
        async with await connect_async(url, "smartmotor") as motor:
            shaft = motor.axes["shaft"]
            shaft.scale = Scale(-100, "mm")
            shaft.set_profile(velocity=50, acceleration=200)
            assert (shaft.core.velocity, shaft.core.acceleration) == (5000, 20_000)
            await shaft.move_to(2.5)
            assert (await shaft.wait(5)).position == 2.5
            await shaft.move_by(-1)
            await shaft.wait(5)
            await shaft.move_at(5)
            with pytest.raises(SilentError, match="still moving"):
                await shaft.wait(0)
            await shaft.stop()
            await shaft.move_at(5)
            await shaft.abort()
            await shaft.home(1)
            await shaft.stop()
            await shaft.wait(5)
            await shaft.clear_faults()
            await shaft.set_position(1)
            assert (await motor.inputs())["A"]
            return await shaft.position()

    with axistwin.serve("smartmotor", speed=5.0, scheme=scheme) as twin:
        assert asyncio.run(session(url_of(twin))) == 1


def test_asyncio_on_a_bus():
    async def session(url):
        async with await connect_async(url, "1811") as board:
            await board.axes["motor"].move_to(30)
            return (await board.axes["motor"].wait(5)).position

    with axistwin.serve("1811", speed=5.0) as twin:
        assert asyncio.run(session(url_of(twin))) == 30


@pytest.mark.slow
def test_a_cancelled_request_does_not_shift_the_answers():
    async def session(url):
        async with await connect_async(url, "smartmotor") as motor:
            shaft = motor.axes["shaft"]
            await shaft.move_to(40)
            await shaft.wait(5)
            for _ in range(3):
                task = asyncio.create_task(motor.number("RA"))
                await asyncio.sleep(0.001)
                task.cancel()
                assert (await shaft.status()).position == 40

    with axistwin.serve("smartmotor", speed=1.0) as twin:
        asyncio.run(session(url_of(twin)))


@pytest.mark.parametrize(("url", "says"), [
    ("tcp://127.0.0.1:9", r"connection refused\): start the server, and check the address"),
    ("/dev/nothing", r"no such file or directory\): check the name of the port, the cable and your permissions"),
    ("nonsense://x", "expected a port, e.g. socket://127.0.0.1:5001"),
    ("tcp://x", "expected a port, e.g. socket://127.0.0.1:5001")])  # fmt: skip
def test_a_port_that_cannot_be_opened(url, says):
    with pytest.raises(PortError, match=rf"cannot open {url} \(.*{says}"):
        connect(url, "if1")
    with pytest.raises(PortError, match=rf"cannot open {url} \(.*{says}"):
        asyncio.run(connect_async(url, "if1"))


def test_a_server_that_disconnects():
    with answering(lambda _: None) as url, pytest.raises(PortError, match="has closed the connection"):
        asyncio.run(connect_async(url, "if1"))


@pytest.mark.parametrize(("model", "options", "says"), [
    ("if3", {}, "unknown model 'if3'"), ("if1", {"speed_range": 5}, "expected 1 to 4"),
    ("if1", {"home_input": 4}, "expected 1, 2 or 3"), ("1811", {"marker_bit": 3}, "expected 0, 1, 2 or None"),
    ("1811", {"home_percent": 0}, "from 1 to 100"), ("smartmotor", {"addresses": [121]}, "from 1 to 120"),
    ("smartmotor", {"colour": "red"}, "colour")])  # fmt: skip
def test_invalid_options(model, options, says):
    with pytest.raises(DriverError, match=says):
        connect("socket://127.0.0.1:9", model, **options)


def test_a_reversed_axis_has_its_limits_exchanged(ports):
    twin = ports.add("smartmotor")
    with connect("smartmotor", "smartmotor", limits=True) as motor:
        twin.pins["C"].drive(False)
        shaft = motor.axes["shaft"]
        assert (shaft.status().limit_plus, shaft.status().limit_minus) == (False, True)
        shaft.scale = Scale(-1)
        assert (shaft.status().limit_plus, shaft.status().limit_minus) == (True, False)
        raises(RefusedError, "limit", shaft.home, 1)


def test_the_drivers_import_nothing_of_the_emulator():
    code = "import sys, axistwin.drivers; print([m for m in sys.modules if 'simpy' in m or 'numpy' in m])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
