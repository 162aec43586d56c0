"""After random acts at devices of others, going back to any time, and a run of the saved scene, repeat the session."""

from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.controllers import registry
from axistwin.devices import load

from ..sessions.driving import drive
from ..sessions.test_property import do, hurry, pause, repeat, say, speed, step, wait
from .stages import said

SAID = {
    "stage": [b"1PA500\r", b"1PA-300\r2PA80\r", b"1ST\r", b"1TP\r", b"WAIT\r", b"1MD\r", b"QQ\r", b"1P", b"\xff\r"],
    "module": [said(4, 0, "0", 400), said(4, 0, "2", -90), said(3, 0, "0"), said(6, 1, "0"), said(6, 1, "9"), b"\x01"],
}
DONE = {
    "stage": [("1+", "low"), ("1+", "release"), ("start", "high"), ("power", "off"), ("power", "on"), ("1.jam", "on"),
              ("1.jam", "off"), ("line", "4800 8N1"), ("break", "0.1"), ("fault", "lose 2 name=gap"), ("mend", "all"),
              ("fault", 'stuck 1- low when="1 passes 20" duration=0.05')],
    "module": [("power", "off"), ("power", "on"), ("0.jam", "on"), ("0.jam", "off"), ("hold", "on"), ("hold", "off")],
}  # fmt: skip


def both() -> Bench:
    bench = Bench()
    bench.add("stage", **{"1": {"limits": (-400, 600)}})
    bench.add("module")
    return bench


ACTS = st.lists(
    st.one_of(
        st.sampled_from([partial(say, name, data) for name, listed in SAID.items() for data in listed]),
        st.sampled_from([partial(do, name, act) for name, listed in DONE.items() for act in listed]),
        st.sampled_from([0.004, 0.03, 0.11, 0.4]).map(lambda seconds: partial(wait, seconds)),
        st.integers(1, 3).map(lambda turns: partial(hurry, turns)),
        st.just(pause),
        st.sampled_from(["event", "move"]).map(lambda kind: partial(step, kind)),
        st.sampled_from([0.1, 1.0, 3.0]).map(lambda times: partial(speed, times)),
    ),
    min_size=3,
    max_size=24,
)


@pytest.fixture
def models(names):
    load(Path(__file__).parent / "stages.py")
    assert {"stage", "module"} <= registry.LOADED.keys()


@settings(
    max_examples=20, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
)
@given(acts=ACTS, shares=st.lists(st.floats(0.01, 1), min_size=1, max_size=2))
def test_a_session_is_repeated(models, acts, shares):
    with TemporaryDirectory() as directory:
        drive(repeat(both, acts, shares, Path(directory)))
