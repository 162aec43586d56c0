"""A small instance of `benchmarks/robustness/late_answers.py`."""

import asyncio
import importlib
import sys
from pathlib import Path

import pytest

from axistwin import Bench
from axistwin.drivers import AsyncController, DriverError, StoppedError, make

ROBUSTNESS = Path(__file__).parents[2] / "benchmarks" / "robustness"


@pytest.fixture(scope="module")
def late_answers():
    sys.path.insert(0, str(ROBUSTNESS))
    yield importlib.import_module("late_answers")
    sys.path.remove(str(ROBUSTNESS))


@pytest.mark.parametrize("late_s", [0.35, 2.3, 5])
@pytest.mark.parametrize("model", ["if1", "1811", "smartmotor"])
def test_a_late_answer_is_not_taken_for_another(late_answers, model, late_s):
    """These messages are of the connection, and of the beginning of the first move."""
    assert not [
        found for message in (10, 15, 25, 28) if (found := asyncio.run(late_answers.run(model, message, 0.05, late_s)))
    ]


async def twice_into_the_switch(late_answers, message, late_s):
    """Return the driver's status and the true position after two runs of as many steps into the same switch."""
    bench = Bench()
    twin = bench.add("if1", X={"limits": [-1000, 500]}).axes["X"]

    async def opening():
        return late_answers.LatePort(bench, "if1", message, 0.05, late_s)

    driver = AsyncController("", make("if1", {}), opening=opening)
    x = driver.axes["X"]

    async def until_done(act):
        for _ in range(late_answers.TRIES):
            try:
                return await act()
            except StoppedError as error:
                return error.status
            except DriverError:
                pass
        raise AssertionError("the driver never recovered")

    async def move(target):
        await x.clear_faults()
        if (await x.status()).position != target and not (target > 0 and (await x.status()).limit_plus):
            await x.move_to(target)
        return await x.wait(30)

    for target in (5000, 0, 5000):
        await until_done(lambda target=target: move(target))
    status = await until_done(x.status)
    await driver.close()
    return status, twin.position


@pytest.mark.parametrize("late_s", [0.35, 0.6])
def test_late_answers_of_a_second_run_into_a_switch(late_answers, late_s):
    for message in range(250, 330, 8):
        status, position = asyncio.run(twice_into_the_switch(late_answers, message, late_s))
        assert (status.lost, status.position) == ("", position) and position >= 500, message
