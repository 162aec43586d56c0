"""The parts of a shadow: cutting, pairing, learning, logging, and the pipe to the twin's process."""

import io
import json
import os
import select
import threading
from pathlib import Path

import pytest

from axistwin.bench import Bench
from axistwin.core.units import MS, S
from axistwin.real.hosts.virtual_time import VirtualEnd
from axistwin.real.shadow.dialects.compumotor import BusTalk
from axistwin.real.shadow.dialects.dialect import Reading
from axistwin.real.shadow.dialects.smartmotor import SmartMotor
from axistwin.real.shadow.feed import Feed, Record, What, records
from axistwin.real.shadow.findings import MOST, Findings, Kind
from axistwin.real.shadow.learning import MOST_KINDS, Learned, Usual
from axistwin.real.shadow.log import MOST_BYTES, Log
from axistwin.real.shadow.moves import Timed
from axistwin.real.shadow.pairing import Pairing
from axistwin.real.shadow.talk import Command, Messages
from axistwin.real.shadow.twin import Twin

from ..command import refused, run


def cut(*received, size=0):
    found = []
    messages = Messages(lambda time_ns, data: found.append((time_ns // MS, data)), size)
    for time_ms, data in received:
        messages.receive(time_ms * MS, data)
    return messages, found


def test_messages_end_at_cr_and_an_lf_is_left_out():
    assert cut((1, b"C\r"), (2, b"\n64"), (3, b"\r"))[1] == [(1, b"C\r"), (3, b"64\r")]


def test_a_message_without_a_terminator_ends_in_a_silence():
    messages, found = cut((1, b"C"))
    messages.catch_up(60 * MS)
    assert found == []
    messages.catch_up(62 * MS)
    assert found == [(1, b"C")]


def test_messages_of_a_board_have_sixteen_bytes():
    assert cut((1, bytes(10)), (2, b"\r" * 22), size=16)[1] == [(2, bytes(10) + b"\r" * 6), (2, b"\r" * 16)]


def paired(*events):
    both, alone = [], []
    pairing = Pairing(lambda a, b: both.append((a.data, b.data)), lambda it, ours: alone.append((it.data, ours)))
    for time_ms, who, what in events:
        if who == "host":
            pairing.ask(time_ms * MS, Command(what, "", b"", answers=1), echo=False)
        else:
            getattr(pairing, who).take(time_ms * MS, what)
        pairing.pair(time_ms * MS)
    return both, alone


def test_answers_to_two_requests_at_once_are_paired_in_order():
    assert paired(
        (0, "host", "E"), (0, "host", "N"), (5, "machine", b"C"), (6, "twin", b"C"), (7, "twin", b"5"),
        (9, "machine", b"6"),
    ) == ([(b"C", b"C"), (b"6", b"5")], [])  # fmt: skip


def test_an_answer_that_is_missing_does_not_move_the_others():
    assert paired(
        (0, "host", "E"), (5, "twin", b"C"), (1000, "host", "N"), (1005, "twin", b"5"), (1006, "machine", b"5"),
    ) == ([(b"5", b"5")], [(b"C", True)])  # fmt: skip


def test_what_comes_unasked_is_alone_after_two_seconds():
    assert paired((0, "machine", b"%"), (3000, "host", "E")) == ([], [(b"%", False)])


def test_the_usual_value_is_the_median_and_one_outlier_is_no_difference():
    usual = Usual(5)
    for value in (1, 2, 3, 4, 50):
        assert not usual.add(0, value, value, 10)
    assert (usual.median, usual.spread) == (3, 1)
    assert [usual.add(0, value, value, 10) for value in (20, 3, 20, 20)] == [False, False, True, True]


def test_intervals_are_learnt_by_what_they_have_in_common():
    usual = Usual(3)
    for low, high in ((-30, 10), (-10, 30), (0, 40)):
        usual.add(0, low, high, 10)
    assert usual.median == 5  # between 0 and 10
    assert usual.beyond(-10, 30) == 0 and usual.beyond(25, 65) == 20


def test_an_interval_that_says_nothing_is_no_drift():
    usual = Usual(5)
    moves = [(-1, 598), (-1, 597), (-2, 596), (-1, 598), (0, 597), (-596, 1), (-1, 598), (-597, 0), (-1, 597)]
    assert not any(usual.add(0, low, high, 10) for low, high in moves)
    assert usual.median == 0.5 and abs(usual.drift) < 1


def test_a_slow_drift_is_found_and_has_a_trend():
    usual = Usual(3)
    day_ns = 86_400 * S
    found = [usual.add(day * day_ns, day, day, 10) for day in range(40)]
    assert found.index(True) > 12 and usual.trend == pytest.approx(day_ns / day_ns, abs=0.2)


def test_what_is_learnt_survives_and_is_bounded():
    learned = Learned()
    for number in range(MOST_KINDS + 20):
        learned.usual(f"move {number}", 1).add(0, 7, 7, 1)
    stored = json.loads(json.dumps(learned.as_dict()))
    assert len(stored) == MOST_KINDS
    assert Learned.of(stored).usual("move 310", 1).median == 7
    assert Learned.of({"move 1": {"count": "x"}}).as_dict() == {}


def test_findings_are_bounded():
    told = []
    findings = Findings(told.append)
    for number in range(MOST + 3):
        findings.add(Kind.ANSWER, str(number), "", 0)
    assert len(told) == MOST and findings.further == 3


def test_position_and_status_word_come_in_one_answer_of_a_motor():
    bench = Bench()
    bench.add("smartmotor")
    dialect = SmartMotor(Twin(bench, "smartmotor"))
    (command,) = dialect.commands(b"RPW ")
    assert dialect.read(command, b"21,1\r") == Reading(0, busy=True, position=21, grain=8, moving_grain=8)


def bus(*said):
    commands, messages, absences = [], [], []
    talk = BusTalk(commands.append, messages.append, lambda: absences.append(1))
    for who, text in said:
        getattr(talk, who)(text)
    return commands, messages, len(absences)


def test_a_bus_socket_is_read_as_commands_and_messages():
    message = b"83 " + b"00 " * 14 + b"05\n"
    assert bus(
        ("host", b"r 1\n"), ("board", b"50\n"), ("host", b"w 0 8"), ("host", b"3\nw 1 10\n"),
        ("board", b"ok\nok\n! 1\n"),
        ("host", b"r 0 16\n"), ("board", message),
    ) == ([b"\x83"], [bytes.fromhex(message.decode())], 0)  # fmt: skip


def test_nobody_on_the_bus():
    assert bus(("host", b"r 1\n"), ("board", b"ff\n")) == ([], [], 1)


def test_nonsense_on_a_bus_socket_is_ignored():
    assert bus(("host", b"w 0 zz\n\n?\nw 1 10\n"), ("board", b"error: x\n\xff\n"), ("host", b"x" * 5000))[1:] == ([], 0)


def test_records_go_through_a_pipe():
    sent = [Record(What.HOST, 5, b"E\r"), Record(What.MACHINE, -1, b"")]
    assert list(records(io.BytesIO(b"".join(record.pack() for record in sent)))) == sent
    assert list(records(io.BytesIO(sent[0].pack()[:-1] + b""))) != sent  # a killed relay leaves half a record


def test_the_relay_never_waits_for_a_twin_that_reads_nothing(monkeypatch):
    monkeypatch.setattr("axistwin.real.shadow.feed.MOST_WAITING", 10)
    reading, writing = os.pipe()
    with open(writing, "wb") as stream, open(reading, "rb") as end:
        feed = Feed(stream, 0)
        for _ in range(1000):
            feed.add(What.HOST, bytes(4096))
        assert not feed.broken
        found = []
        reader = threading.Thread(target=lambda: found.extend(records(end)))
        reader.start()
        feed.close()
        reader.join(60)
    assert 0 < len(found) < 1000


def test_a_twin_receives_its_settings_before_anything_is_relayed():
    reading, writing = os.pipe()
    with open(writing, "wb") as stream, open(reading, "rb") as end:
        feed = Feed(stream, 0, b"{}\n")
        assert select.select([end], [], [], 10)[0]
        assert end.readline() == b"{}\n"
        feed.close()


def test_a_twin_that_has_ended_does_not_disturb_the_relay():
    reading, writing = os.pipe()
    os.close(reading)
    stream = os.fdopen(writing, "wb", 0)
    feed = Feed(stream, 0)
    feed.add(What.HOST, b"E\r")
    feed.close()
    assert feed.broken
    stream.close()


def timed(at_s, kind="X100$ 1 s", later_ms=4):
    return Timed(kind, Command("X100$", "", b""), at_s * S, S, (later_ms - 1) * MS, (later_ms + 1) * MS)


def test_the_log_has_one_line_an_hour_for_each_kind_of_move(tmp_path):
    log = Log(tmp_path / "table.jsonl", pytest.fail)
    log.learned().usual("move X100$ 1 s", 1).add(0, 7 * MS, 7 * MS, 1)
    for minute in range(130):
        log.timed(timed(60 * minute, later_ms=minute))
    log.write_hour()
    lines = [json.loads(line) for line in (tmp_path / "table.jsonl").read_text().splitlines()]
    assert [(line["count"], line["later_ms"]) for line in lines] == [(60, 29.5), (60, 89.5), (10, 124.5)]
    assert (lines[0]["duration_s"], lines[0]["usual_ms"]) == (1.0295, 7)


def test_each_day_is_a_parquet_file(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    log = Log(tmp_path / "table.jsonl", pytest.fail)
    for day in range(3):
        log.timed(timed(86_400 * day))
    assert [path.name for path in sorted(tmp_path.glob("*.parquet"))] == [
        "table-1970-01-01.parquet",
        "table-1970-01-02.parquet",
    ]
    assert parquet.read_table(tmp_path / "table-1970-01-01.parquet").to_pylist()[0]["later_high_ms"] == 5.0


def test_a_log_that_is_full_is_followed_by_another(tmp_path):
    path = tmp_path / "table.jsonl"
    path.write_bytes(b"x" * (MOST_BYTES + 1))
    log = Log(path, pytest.fail)
    log.add("note", text="first of the new file")
    assert (tmp_path / "table.jsonl.1").stat().st_size > MOST_BYTES and path.stat().st_size < 100


def test_a_full_disk_is_told_once(tmp_path):
    told = []
    log = Log(tmp_path / "gone" / "table.jsonl", told.append)
    for _ in range(3):
        log.add("note")
    log.save(Learned())
    assert len(told) == 1 and "cannot be written" in told[0]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that is always full")
def test_the_log_goes_on_when_the_disk_has_room_again(tmp_path):
    told, path = [], tmp_path / "table.jsonl"
    path.symlink_to("/dev/full")
    log = Log(path, told.append)
    for number in range(4):
        if number == 3:
            path.unlink()
        log.add("note", number=number)
    assert len(told) == 1 and "no space left" in told[0]
    assert json.loads(path.read_text())["number"] == 3


def test_a_restart_goes_on_with_what_was_learnt(tmp_path):
    log = Log(tmp_path / "table.jsonl", pytest.fail)
    learned = Learned()
    learned.usual("late E", 1).add(0, 7, 7, 1)
    log.tick(100 * S, learned)  # a process that is killed now has written it
    assert Log(tmp_path / "table.jsonl", pytest.fail).learned().usual("late E", 1).median == 7
    (tmp_path / "table.jsonl.learned.json").write_text("[1")
    assert Log(tmp_path / "table.jsonl", pytest.fail).learned().as_dict() == {}


def test_the_log_is_drawn(tmp_path):
    pytest.importorskip("matplotlib")
    log = Log(tmp_path / "table.jsonl", pytest.fail)
    for hour in range(4):
        log.timed(timed(3600 * hour, later_ms=2 * hour))
    log.write_hour()
    log.add("finding", time="1970-01-01T02:00:00.000Z", text="E is late")
    assert run("plot", tmp_path / "table.jsonl", "-o", tmp_path / "day.svg").code == 0
    picture = (tmp_path / "day.svg").read_text()
    assert all(words in picture for words in ("X100$ 1 s: +6 ms (+0.6 %)", "1 finding", "E is late"))


def test_a_log_that_cannot_be_drawn(tmp_path):
    empty, wrong = tmp_path / "empty.jsonl", tmp_path / "wrong.jsonl"
    empty.write_text("")
    wrong.write_text('{"type": "note"}\nX')
    assert "empty.jsonl contains no moves: they are written every hour" in refused("plot", empty)[1]
    assert "wrong.jsonl:2: expected a line of JSON" in refused("plot", wrong)[1]


@pytest.mark.parametrize("attend", [Twin, lambda bench, name: VirtualEnd(bench, bench[name])])
def test_who_listens_to_a_port_for_weeks_leaves_nothing_unread_in_it(bench, attend):
    serial = bench.add("if1").serial
    listener = attend(bench, "if1")
    bench.run(1.1)
    serial.write(b"(")
    bench.run(0.1)
    if isinstance(listener, VirtualEnd):
        assert listener.receive() == b"U\r"
    assert serial.read() == b""
