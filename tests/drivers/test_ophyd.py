"""Devices of ophyd-async in bluesky's plans."""

import asyncio
from itertools import pairwise

import pytest

import axistwin
from axistwin.core.errors import UsageError
from axistwin.drivers import RefusedError, SilentError, StoppedError
from axistwin.real.integrations import driver_inside

from ..bad_values import BAD, NOT_NUMBERS
from ..told import raises
from .devices import model_of, url_of


@pytest.fixture
def ophyd():
    pytest.importorskip("bluesky", reason="the extra [ophyd] is not installed")
    pytest.importorskip("ophyd_async", reason="the extra [ophyd] is not installed")
    import axistwin.ophyd

    return axistwin.ophyd


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize(("model", "axis"), [("if1", "X"), ("1811", "motor"), ("smartmotor", "shaft")])
def test_a_scan_of_11_points_has_exact_positions(ophyd, model, axis):
    import bluesky.plan_stubs as bps
    from bluesky import RunEngine
    from bluesky.plans import list_scan, scan

    found, engine = [], RunEngine()
    engine.subscribe(lambda name, document: found.append(document["data"]["m"]) if name == "event" else None)
    with axistwin.serve(model, speed=50.0) as twin:
        controller = ophyd.Controller(url_of(twin), model)
        motor = controller.motor(axis, name="m", counts_per_unit=100, unit="mm", poll_s=0.005)

        async def connect():
            await motor.connect()

        asyncio.run_coroutine_threadsafe(connect(), engine.loop).result(10)
        engine(scan([], motor, 0, 5, 11))
        assert found == [0.5 * n for n in range(11)]
        assert twin.do(lambda: model_of(twin).axes[axis].position) == 500
        engine(list_scan([motor], motor, [1, 2]))
        engine(bps.stop(motor))
        location = asyncio.run_coroutine_threadsafe(motor.locate(), engine.loop).result(10)
        assert location == {"setpoint": 2, "readback": 2}
        asyncio.run_coroutine_threadsafe(controller.close(), engine.loop).result(10)


def test_a_move_that_a_limit_ends_fails(ophyd):
    async def session(twin):
        controller = ophyd.Controller(url_of(twin), "if1")
        raises(RefusedError, "expected one of X, Y, Z", controller.motor, "W")
        motor = controller.motor("X", name="m", poll_s=0.005)
        await motor.connect()
        with pytest.raises(RefusedError, match=r"stopped at .*limit"):
            await motor.set(50_000)
        await controller.close()

    with axistwin.serve("if1", speed=20.0, X={"limits": [-1000, 500]}) as twin:
        asyncio.run(session(twin))


@pytest.mark.parametrize(("success", "ends"), [(None, "program stopped it"), (False, "or another move"), (True, "")])
def test_a_move_that_something_stops_fails(ophyd, success, ends):
    """None: another host stops the motor; else an own stop, which may count as a success of the move."""

    async def session():
        bench = axistwin.Bench()
        bench.add("smartmotor")
        motor = ophyd.Controller.inside(bench, "smartmotor").motor("shaft", name="m")
        await motor.connect()
        move = motor.set(8000)
        while (await motor.locate())["readback"] < 2000:
            pass
        if success is None:
            await motor.controller.driver.send(b"", "X")
        else:
            await motor.stop(success)
        if success:
            await move
        else:
            with pytest.raises(StoppedError, match=ends):
                await move
        assert 2000 < (await motor.locate())["readback"] < 8000
        await motor.set(8000)  # as the message says: begin the motion again
        assert (await motor.locate())["readback"] == 8000

    asyncio.run(session())


def test_bad_values_are_refused_and_nothing_moves(ophyd):
    async def session():
        bench = axistwin.Bench()
        bench.add("if1")
        controller = ophyd.Controller.inside(bench, "if1")
        motor = controller.motor("X", name="m")
        await motor.connect()
        for value in (*BAD["move_to"], *NOT_NUMBERS):
            with pytest.raises(RefusedError, match="invalid position"):
                await motor.set(value)
        assert await motor.locate() == {"setpoint": 0, "readback": 0}
        for words in ({"counts_per_unit": 0}, {"poll_s": -1}):
            raises(RefusedError, "expected a number", controller.motor, "X", **words)

    asyncio.run(session())


def scan_inside(ophyd, model, axis, points):
    """Scan with the twin inside; return the points' times in ns and positions, and the final position."""
    from bluesky import RunEngine
    from bluesky.plans import list_scan

    bench, seen, engine = axistwin.Bench(), [], RunEngine()
    bench.add(model)
    engine.subscribe(lambda name, found: seen.append((bench.now, found["data"]["m"])) if name == "event" else None)
    controller = ophyd.Controller.inside(bench, model)
    motor = controller.motor(axis, name="m", poll_s=0.2)
    motor.axis.set_profile(velocity=300)

    async def connect():
        await motor.connect()

    asyncio.run_coroutine_threadsafe(connect(), engine.loop).result(10)
    engine(list_scan([], motor, points))
    asyncio.run_coroutine_threadsafe(controller.close(), engine.loop).result(10)
    return seen, bench[model].axes[axis].position


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize(("model", "axis"), [("if1", "X"), ("1811", "motor"), ("smartmotor", "shaft")])
def test_a_scan_with_the_twin_inside_takes_virtual_time_only(ophyd, model, axis):
    points = [0, 1800, -200, 1500]
    seen, final = scan_inside(ophyd, model, axis, points)
    assert [position for _, position in seen] == points and final == 1500
    times = [ns for ns, _ in seen]
    assert all(late - early > 5e9 for early, late in pairwise(times))  # 1700 counts at 300 per second
    assert scan_inside(ophyd, model, axis, points) == (seen, final)


def test_a_driver_inside_waits_in_virtual_time():
    async def session():
        bench = axistwin.Bench()
        bench.add("if1")
        driver = driver_inside(bench, "if1", timeout=3.0)
        x = driver.axes["X"]
        await x.move_at(100)
        began = bench.seconds
        with pytest.raises(SilentError, match="still moving after 15 s"):
            await x.wait(15)
        assert 15 <= bench.seconds - began < 15.3
        await x.stop()
        assert (await x.wait(5)).position == bench["if1"].axes["X"].position > 1500
        bench["if1"].power(False)
        with pytest.raises(SilentError, match=r"no answer to N|no answer to K"):
            await x.status()
        bench["if1"].power(True)
        assert "power" in (await x.status()).lost
        await driver.close()
        await driver.clock.pause(0)
        raises(UsageError, "no controller 'table': expected one of if1", driver_inside, bench, "table")

    asyncio.run(session())


def test_a_chain_inside():
    async def session():
        bench = axistwin.Bench()
        motors = [bench.add("smartmotor", f"m{number}") for number in (1, 2)]
        bench.chain(*motors, name="chain")
        driver = driver_inside(bench, "chain")
        await driver.axes["shaft2"].move_to(300)
        await driver.axes["shaft2"].wait(5)
        assert [motor.axes["shaft"].position for motor in motors] == [0, 300]

    asyncio.run(session())
