"""What a driver does with a virtual or a real controller.

`pytest tests/drivers/test_hardware.py --hardware if1=/dev/ttyUSB0` runs the tests with a real one: its first axis moves
by 400 counts to both sides.
"""

from contextlib import contextmanager

import pytest

import axistwin
from axistwin.drivers import RefusedError, connect

from ..told import raises
from .devices import url_of

MODELS = {"if1": ("X", 1000), "1811": ("motor", 4000), "smartmotor": ("shaft", 2000)}
"""First axis and its velocity."""


@contextmanager
def real_or_virtual(model, given):
    ports = dict(one.split("=", 1) for one in given)
    if model in ports:
        yield ports[model]
        return
    if ports:
        pytest.skip(f"--hardware names no {model}")
    with axistwin.serve(model, speed=20.0, **({"self_test_s": 0.1} if model == "if1" else {})) as twin:
        yield url_of(twin)


@pytest.fixture(scope="module", params=MODELS)
def first_axis(request):
    name, velocity = MODELS[request.param]
    with (
        real_or_virtual(request.param, request.config.getoption("--hardware")) as url,
        connect(url, request.param) as controller,
    ):
        yield controller.axes[name], velocity


@pytest.fixture
def axis(first_axis):
    axis, velocity = first_axis
    axis.clear_faults()
    axis.set_position(0)
    axis.set_profile(velocity, 10 * velocity)
    yield axis
    axis.stop()
    axis.wait(20)


@pytest.mark.slow
def test_moves_to_both_sides_end_at_the_target(axis):
    tolerance = 2 if axis.name == "shaft" else 0  # a loaded servo motor
    for target in (400, -400, 0):
        axis.move_to(target)
        status = axis.wait(20)
        assert not status.faults and not status.lost
        assert abs(status.position - target) <= tolerance


@pytest.mark.slow
def test_a_stop_ends_a_run(axis):
    axis.move_at(100)
    assert axis.status().moving
    axis.stop()
    status = axis.wait(20)
    assert 0 <= status.position <= 400 and not status.moving


def test_what_is_refused_moves_nothing(axis):
    for refused in (lambda: axis.set_profile(velocity=1e9), lambda: axis.move_to(float("nan"))):
        raises(RefusedError, "", refused)
    assert axis.status().position == 0
