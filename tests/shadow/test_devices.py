"""Devices of others beside their twin: their tables tell what is answered, their drivers when an axis moves."""

import pytest

from axistwin.bench import Bench
from axistwin.devices import load
from axistwin.real.shadow.dialects.devices import Table
from axistwin.real.shadow.dialects.dialect import Reading
from axistwin.real.shadow.twin import Twin

from ..devices.conftest import names  # noqa: F401  # a fixture
from .campaign import campaign

pytestmark = pytest.mark.usefixtures("names")


def table(model):
    load(campaign.ESP300.with_name(f"{model}.py"))
    bench = Bench()
    bench.add(model)
    return Table(Twin(bench, model))


def test_a_query_is_answered_once_and_a_wait_begins_no_motion():
    said = list(table("esp300").commands(b"1MO;1PA2;1WS;1tp\r1XX?\r"))
    assert [(it.text, it.answers, it.starts) for it in said] == [
        ("1MO", 0, True), ("1PA2", 0, True), ("1WS", 0, False), ("1tp", 1, False), ("1XX?", 0, True),
    ]  # fmt: skip


@pytest.mark.parametrize(("model", "request_", "answer", "reading"), [
    ("esp300", b"1TP?\r", b"-1.5000\r", Reading(position=-1500, grain=2, moving_grain=2)),  # the driver asks 1TP
    ("esp300", b"1MD?\r", b"0\r", Reading(busy=True)),
    ("esp300", b"2MD?\r", b"0\r", Reading()),  # not the axis that moves
    ("esp300", b"TS\r", b"Q\r", Reading(b"Q\r", soft=True)),
    ("tmcl", b"\1\6\3\0\0\0\0\0\n", b"\2\1d\6\0\0\0\0m", Reading(busy=False)),
    ("mdrive", b"XPR P\n", b"5\r", Reading(b"5\r", soft=True)),  # it has no driver
])  # fmt: skip
def test_what_an_answer_says(model, request_, answer, reading):
    dialect = table(model)
    (command,) = dialect.commands(request_)
    assert dialect.read(command, answer) == reading


def test_messages_are_cut_as_the_device_writes_them():
    assert [(it.message_size, it.terminators) for it in map(table, ("esp300", "tmcl"))] == [(0, b"\r\n"), (9, b"\r\n")]


def test_a_position_that_differs_is_taken_over_and_told_once():
    rig = campaign.Rig("esp300", jitter_ns=0)
    work = campaign.StageWork(rig)
    work.begin()
    work.move(b"1PR0.1\r")
    rig.machine.write(b"1DH0.5\r")
    for _ in range(2):
        work.move(b"1PR0.1\r")
    rig.run(1)
    (finding,) = rig.differences()
    assert finding.text == "1TP is 0.6000\\r, +400 from the twin's 0.2000\\r" and finding.count == 1
    assert rig.shadow.twin.private(b"1TP\r") == b"0.7000\r\n"
