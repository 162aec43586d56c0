"""Example devices without a driver, given one here: pulses, distances and reported positions agree."""

from struct import pack, unpack

import pytest

from axistwin.devices import add8
from axistwin.drivers import TextDriver
from axistwin.testing import device_checks

from .made import example


class MDrive(example("mdrive", "MDrive")):
    """In echo mode 2 a motor answers questions only."""

    model = "driven-mdrive"
    driver = TextDriver(
        move="{axis}MA {position}",
        stop="{axis}SL 0",
        position="{axis}PR P",
        busy="{axis}PR MV",
        begin="{axis}EM 2",
        at_rest=0,
    )


def tmcl(code: int, number: int, axis: str, value: int = 0) -> bytes:
    data = pack(">BBBBi", 1, code, number, int(axis), value)
    return data + add8(data)


class Tmcl(example("tmcl", "Tmcl")):
    """Each datagram is answered by one of nine bytes; parameter 8 says that the target is reached."""

    model = "driven-tmcl"
    driver = TextDriver(
        move=lambda axis, position: tmcl(4, 0, axis, position), stop=lambda axis: tmcl(3, 0, axis),
        position=lambda axis: tmcl(6, 1, axis), busy=lambda axis: tmcl(6, 3, axis), at_rest=0,
        confirmed=True, size=9, value=lambda answer: unpack(">i", answer[4:8])[0],
    )  # fmt: skip


@pytest.mark.parametrize("kind", [MDrive, Tmcl])
def test_pulses_are_the_distance_commanded(kind):
    (check,) = (each.values[0] for each in device_checks(kind) if each.id == "distance")
    check()
