"""Devices of ophyd-async in bluesky's plans."""

import asyncio

import pytest

import axistwin
from axistwin.drivers import RefusedError

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

    found = []
    engine = RunEngine()
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
        with pytest.raises(RefusedError, match="expected X, Y, Z"):
            controller.motor("W")
        motor = controller.motor("X", name="m", poll_s=0.005)
        await motor.connect()
        with pytest.raises(RefusedError, match=r"stopped at .*limit"):
            await motor.set(50_000)
        await controller.close()

    with axistwin.serve("if1", speed=20.0, X={"limits": [-1000, 500]}) as twin:
        asyncio.run(session(twin))
