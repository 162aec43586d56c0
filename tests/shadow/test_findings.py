"""The twin beside a second bench: what is found, and what is not; in virtual time, without ports."""

import pytest

from axistwin.core.units import MS
from axistwin.real.shadow.findings import Kind
from axistwin.real.shadow.shadow import EARLY_NS

from ..devices.conftest import names  # noqa: F401  # a fixture
from .campaign import campaign

pytestmark = pytest.mark.usefixtures("names")

SOME = (
    "if1 limit 50 pulses early", "if1 answers 40 ms late", "if1 a lost character", "1811 a stuck output bit",
    "1811 lost steps, seen by the encoder", "smartmotor a fault bit: overheat", "esp300 ramp 5 % slower",
)  # fmt: skip


def planted(name):
    return next(plant for plant in campaign.PLANTS if f"{plant.model} {plant.name}" == name)


@pytest.mark.parametrize("name", SOME)
def test_wear_is_found_within_three_occurrences(name):
    plant = planted(name)
    before, found = campaign.tried(plant, learning=6)
    assert before == []
    assert any(finding.kind in plant.kinds for finding in found), [finding.line() for finding in found]


@pytest.mark.parametrize("model", ["if1", "1811", "smartmotor"])
def test_ten_minutes_of_ordinary_work_are_no_finding(model):
    rig, _ = campaign.day(model, hours=1 / 6, seed=3)
    assert [finding.line() for finding in rig.differences()] == []
    assert rig.shadow.pairs > 500


def ready(**settings):
    """An IF1 whose host has just initialised it."""
    rig = campaign.Rig("if1", jitter_ns=0, **settings)
    assert rig.ask(b"(") == b"U\r"
    rig.say(b"U61\r")
    rig.run(1.3)
    assert rig.ask(b"E\r") == b"C\r"
    return rig


def echoing(**settings):
    rig = campaign.Rig("if1", **settings)
    rig.ask(b"(")
    rig.say(b"U62\r")
    rig.run(1.3)
    return rig


def test_a_twin_that_is_stopped_with_its_machine_echoes_nothing_of_its_own():
    rig = echoing(jitter_ns=0)
    rig.say(b"X9000$\r")
    rig.run(0.5)
    rig.machine.private(b"#\r", seconds=1)
    for _ in range(3):
        rig.ask(b"E\r")
        rig.run(0.2)
    rig.run(6)
    assert [finding.line() for finding in rig.differences()] == []


def test_echoed_characters_that_come_slowly_are_one_message():
    rig = echoing()
    for gap_ms in range(50, 70):  # 60 ms of silence end an answer.
        rig.say(b"E")
        rig.run(gap_ms / 1000)
        rig.say(b"\r")
        rig.run(0.2)
    rig.run(3)
    assert [finding.line() for finding in rig.differences()] == [] and rig.shadow.pairs >= 40


def test_one_surprise_is_one_finding():
    rig = ready()
    rig.to_host = lambda data: data.replace(b"C", b"B")
    for _ in range(5):
        rig.ask(b"E\r")
    rig.run(1)
    (finding,) = rig.differences()
    assert (finding.kind, finding.section) == (Kind.ANSWER, "Busy status")
    assert (finding.expected, finding.got) == ("C\\r", "B\\r")


def test_a_finding_counts_how_often_it_has_come():
    rig = ready()
    for _ in range(3):
        rig.to_host = lambda data: data.replace(b"C", b"B")
        rig.ask(b"E\r")
        rig.to_host = lambda data: data
        rig.ask(b"E\r")
    rig.run(1)
    (finding,) = rig.differences()
    assert finding.count == 3 and finding.last_ns > finding.time_ns


def test_an_input_is_taken_from_the_machine_and_named():
    rig = ready()
    rig.controller.pins["input1"].drive(True)
    assert rig.ask(b"I\r") == b"192\r"  # 200 without bit 8, input 1
    rig.run(1)
    assert rig.differences() == []
    assert [note.text for note in rig.found] == ["the machine says input1 high"]
    assert rig.shadow.twin.level("input1")


def test_an_emergency_stop_is_no_finding():
    rig = ready()
    rig.say(b"X4000$\r")
    rig.run(0.5)
    rig.controller.pins["estop"].drive(False)
    rig.run(0.5)
    assert rig.ask(b"E\r") == b"F\r"
    assert rig.ask(b"K\r") == b"32\r"
    rig.ask(b"N\r")
    rig.run(10)
    assert rig.differences() == []
    assert "the machine says emergency stop" in [note.text for note in rig.found]


def test_the_shadow_joins_a_machine_that_moves():
    rig = campaign.Rig("if1", jitter_ns=0)
    rig.machine.private(b"(", b"U61\r", b"X4000$\r", seconds=1.3)
    while rig.ask(b"E\r") == b"E\r":
        rig.run(0.05)
    rig.ask(b"N\r")
    rig.ask(b"K\r")
    rig.run(3)
    assert rig.differences() == []


@pytest.mark.parametrize(("before", "worn", "percent"), [("@2000", "@1000", "(68."), ("@300", "@250", "(15.")])
def test_a_speed_from_before_the_beginning_is_learnt(before, worn, percent):
    rig = campaign.Rig("if1")
    rig.machine.private(b"(", b"U61\r", f"{before}\r".encode(), seconds=1.3)

    def work(times):
        for number in range(times):
            rig.say(b"X-1000$\r" if number % 2 else b"X1000$\r")
            rig.run(0.1)
            while rig.ask(b"E\r") != b"C\r":
                rig.ask(b"N\r")
                rig.run(0.1)
            rig.ask(b"N\r")

    work(34)
    assert [finding.line() for finding in rig.differences()] == []
    rig.machine.private(f"{worn}\r".encode(), seconds=1.3)
    rig.shadow.tick(rig.now)
    work(8)
    assert {finding.kind for finding in rig.differences()} == {Kind.DURATION}
    assert any(percent in finding.text for finding in rig.differences()), rig.differences()


def test_a_motor_that_has_its_acceleration_from_before_the_beginning():
    rig = campaign.Rig("smartmotor", jitter_ns=0)
    rig.machine.private(b"ZS A=100 V=200000 MP ", seconds=0.3)
    for number in range(10):
        rig.say(b"P=0 G " if number % 2 else b"P=4000 G ")
        rig.run(0.05)
        while rig.ask(b"RBt ") != b"0\r":
            rig.ask(b"RP ")
            rig.run(0.05)
        rig.run(0.2)
        rig.ask(b"RP ")
        rig.ask(b"RW ")
    rig.run(10)
    assert rig.differences() == []
    assert any("settings from before" in note.text for note in rig.found)


def test_a_host_that_never_asks_whether_the_motor_rests():
    rig = campaign.Rig("if1", jitter_ns=0)
    rig.machine.private(b"(", b"U61\r", b"@4000\r", seconds=1.3)
    for number in range(24):
        rig.say(b"X-1000$\r" if number % 2 else b"X1000$\r")
        rig.run(0.5)
        for request in (b"I\r", b"N\r"):
            rig.ask(request, timeout=3)
    rig.run(3)
    assert [finding.line() for finding in rig.differences()] == []


def test_a_lost_character_of_a_request_is_a_missing_answer():
    rig = ready()
    rig.to_machine = lambda data: data[1:]
    assert rig.ask(b"E\r") == b""
    rig.to_machine = lambda data: data
    assert rig.ask(b"E\r") == b"C\r"
    rig.run(3)
    assert [finding.text for finding in rig.differences()] == ["E is not answered"]


def test_a_machine_that_is_off_at_night_is_no_finding():
    rig = ready()
    rig.controller.power(False)
    for _ in range(5):
        assert rig.ask(b"E\r") == b""
        rig.run(3600)
    rig.controller.power(True)
    rig.run(2)
    assert rig.ask(b"(") == b"U\r"
    rig.say(b"U61\r")
    rig.run(1.3)
    assert rig.ask(b"E\r") == b"C\r"
    rig.run(3)
    assert rig.differences() == []
    assert [note.subject for note in rig.found] == ["silent", "back"]


def test_a_fault_that_nobody_has_read_before_the_beginning_is_no_finding():
    rig = campaign.Rig("if1", jitter_ns=0)
    rig.machine.private(b"(", b"U61\r", b"IN\r", seconds=1.3)
    assert (rig.ask(b"E\r"), rig.ask(b"K\r"), rig.ask(b"F\r")) == (b"F\r", b"128\r", b"8\r")
    rig.say(b"IN\r")
    assert (rig.ask(b"K\r"), rig.ask(b"F\r"), rig.ask(b"F\r")) == (b"128\r", b"8\r", b"0\r")
    rig.run(3)
    assert rig.differences() == []
    rig.to_host = lambda data: data.replace(b"0", b"1")
    rig.ask(b"F\r")
    rig.run(3)
    assert [finding.kind for finding in rig.differences()] == [Kind.FAULT]


def test_what_is_sent_while_the_port_is_away_is_no_finding():
    rig = ready()
    rig.to_machine = lambda data: b""
    rig.say(b"E\r")
    rig.run(0.2)
    rig.shadow.port(rig.now, away=True)
    for request in (b"I\r", b"X100$\r", b"E\r"):
        assert rig.ask(request) == b""
    rig.shadow.port(rig.now, away=False)
    rig.to_machine = lambda data: data
    rig.ask(b"N\r")
    assert rig.ask(b"E\r") == b"C\r"
    rig.run(3)
    assert rig.differences() == []
    assert [note.text for note in rig.found] == [f"the port of the machine is {words}" for words in ("away", "back")]


def test_an_answer_that_is_seen_before_its_request():
    rig = ready()
    rig.shadow.early_ns = EARLY_NS
    at_ns = rig.now + 100 * MS
    for request, answer in ((b"E\r", b"C\r"), (b"N\r", b"0\r"), (b"I\r", b"200\r")):
        rig.shadow.machine(at_ns, answer)  # Each adapter has a delay of its own.
        rig.shadow.host(at_ns + 16 * MS, request)
        at_ns += 100 * MS
    rig.shadow.tick(at_ns + 3000 * MS)
    assert rig.found == [] and rig.shadow.pairs == 4


def test_times_of_a_late_relay_are_not_judged():
    rig = ready()
    for _ in range(20):
        rig.ask(b"E\r")
        rig.run(0.1)
    rig.delay_ns = 80 * MS
    for _ in range(3):
        rig.ask(b"E\r")
        rig.shadow.blind(rig.now, 100 * MS)
    rig.run(2)
    assert rig.differences() == []


@pytest.mark.parametrize("ppm", [-200, 200])
def test_a_machine_whose_clock_drifts(ppm):
    rig, _ = campaign.day("if1", hours=0.1, seed=3, ppm=ppm)
    assert rig.differences() == [] and rig.shadow.pairs > 500


def test_a_host_that_connects_again_in_the_middle_of_a_request():
    rig = ready()
    rig.say(b"X1")
    rig.run(60)
    assert rig.ask(b"#\rE\r") == b"C\r"
    rig.run(3)
    assert rig.differences() == []
