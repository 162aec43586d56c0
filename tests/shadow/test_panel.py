"""What the panel of a shadow shows: the state, the machine's position, and the moments of findings."""

import pytest

from axistwin.core.units import MS, S

from .test_supervision import SETTINGS

panel = pytest.importorskip("axistwin.cli.serving.shadow_panel", reason="needs NiceGUI")
from axistwin.real.shadow.feed import Record, What  # noqa: E402
from axistwin.real.shadow.process import Observer  # noqa: E402

SAID = [
    (What.HOST, 0, b"("), (What.MACHINE, 10, b"U\r"), (What.HOST, 50, b"U61\r"),
    (What.HOST, 2000, b"E\r"), (What.MACHINE, 2005, b"C\r"),
    (What.HOST, 3000, b">1<4^20@400 X400$\r"), (What.HOST, 6900, b"E\r"), (What.MACHINE, 6905, b"C\r"),
    (What.HOST, 7000, b"N\r"), (What.MACHINE, 7005, b"300\r"),
    (What.HOST, 9000, b"X-400$\r"), (What.HOST, 13000, b"N\r"), (What.MACHINE, 13005, b"400\r"),
    (What.HOST, 73100, b"E\r"), (What.MACHINE, 73105, b"B\r"),
]  # fmt: skip
"""An IF1 that makes 100 steps too few in its first move, and says B instead of C."""


def compared(*said):
    settings = {**SETTINGS, "options": ("self_test_s=0.05", "recalculation_s=0.01")}
    found = panel.Compared(settings, Observer(settings, lambda finding: None))
    observer = found.live.observer
    for what, at_ms, data in said:
        record = Record(what, 1_800_000_000 * S + at_ms * MS, data)
        found.kept.add(record)
        observer.take(record)
        found.tick()
    observer.tick(observer.now_ns + 3 * S)
    found.tick()
    return found


def test_it_waits_agrees_and_differs():
    assert compared().state == "waits for the first answer"
    assert compared(*SAID[:5]).state.startswith("agrees since ")
    whole = compared(*SAID)
    told = next(found for found in whole.found if "E answers B" in found.text)
    assert whole.differs and whole.state == f"differs since {told.at[:5]}: {told.text}"
    silent = compared(*SAID[:5], *((What.HOST, 50_000 + 3000 * number, b"E\r") for number in range(4)))
    assert silent.state == f"the machine is silent since {silent.found[0].at[:5]}"


def test_the_machine_stands_where_its_answers_say():
    assert compared(*SAID[:5]).beside("X") is None
    assert compared(*SAID[:10]).beside("X") == 300
    assert compared(*SAID).beside("X") == -100


def test_a_finding_leads_to_its_moment_and_back():
    whole = compared(*SAID)
    count = next(found for found in whole.found if found.text.startswith("N is"))
    live = whole.session.bench
    assert whole.go_back(count)
    while whole.advance():
        pass
    assert whole.past and whole.state == count.text and whole.clock == count.at
    assert (whole.session.bench["if1"].axes["X"].position, whole.beside("X")) == (400, 300)
    whole.go_on()
    assert whole.session.bench is live and not whole.past and whole.beside("X") == -100
    whole.kept = panel.Kept()
    assert not whole.go_back(count) and not whole.past


def test_what_is_kept_is_bounded(monkeypatch):
    monkeypatch.setattr(panel, "CHUNK", 100)
    kept = panel.Kept()
    for number in range(1000):
        kept.add(Record(What.HOST, number, b"E\r"))
    kept.add(Record(What.SUMMARY, 1000))
    times = [record.time_ns for record in kept]
    assert times == list(range(times[0], 1000)) and 80 < len(times) < 200
