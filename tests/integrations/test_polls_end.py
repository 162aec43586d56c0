"""Polls end only with their server, or loudly."""

import asyncio
from functools import partial

import pytest

from axistwin import Bench
from axistwin.real.integrations import of_scene

from .conftest import free_port


def serving_of(kind, machine):
    if kind == "epics":
        pytest.importorskip("caproto", reason="caproto is not installed")
        from axistwin.real.integrations.epics.ioc import Ioc

        return Ioc(machine, "P:").serving
    pytest.importorskip("asyncua", reason="asyncua is not installed")
    from axistwin.real.integrations.opcua import server

    return partial(server.serving, machine)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["epics", "opcua"])
def test_polls_that_end_by_an_error_of_ours_are_told(kind):
    """Otherwise clients would see an axis that never changes."""

    async def fails():
        raise ValueError("of ours")

    async def session():
        told = asyncio.get_running_loop().create_future()
        asyncio.get_running_loop().set_exception_handler(lambda _, context: told.set_result(context["exception"]))
        bench = Bench()
        bench.add("1811")
        async with await of_scene(bench, {}, speed=None) as machine, serving_of(kind, machine)(port=free_port()):
            machine.stations[0].axes["motor"].changed = fails
            return await told

    assert [str(one) for one in asyncio.run(session()).exceptions] == ["of ours"]
