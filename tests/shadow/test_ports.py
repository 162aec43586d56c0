"""The shadow on real ports, and hosts that do not know of it; slow, as bytes go through the system."""

import sys

import pytest

from axistwin.real.shadow.findings import Kind

from ..basic.listings import MANUAL
from .campaign import campaign, hosts, ports

pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore:set.* is deprecated:DeprecationWarning"),  # pyserial's reader thread
]
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="pseudo terminals as serial devices")


@pytest.mark.parametrize(("kind", "model", "name"), [
    pytest.param("pty", "if1", "limit 50 pulses early", marks=LINUX),
    ("rfc2217", "smartmotor", "limit 50 counts early"),
    ("bus", "1811", "limit 50 pulses early"),
])  # fmt: skip
def test_wear_is_found_on_real_ports(kind, model, name):
    plant = next(plant for plant in campaign.PLANTS if (plant.model, plant.name) == (model, name))
    with ports.wired(kind) as make:
        before, found = campaign.tried(plant, learning=3, make=make)
    assert before == []
    assert Kind.COUNT in {finding.kind for finding in found}, [finding.line() for finding in found]


@pytest.mark.skipif(not MANUAL.exists(), reason="the manual is not here")
def test_a_basic_program_does_not_notice_the_shadow():
    """Sample 7 of the manual: the same bytes on both sides of the shadow, and the same moves."""
    verdict = hosts.basic(7)
    assert verdict.same and verdict.sent > 100 and verdict.received > 10


def test_a_driver_does_not_notice_the_shadow():
    verdict = hosts.talked("if1", "9600 8N2", hosts.driver_host)
    assert verdict.same and verdict.sent > 100 and verdict.received > 100
