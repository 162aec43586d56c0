"""CSV and VCD traces: they contain every change in order of time, also after an interrupt."""

import csv
from pathlib import Path

import pytest
from vcd.reader import TokenKind, tokenize

from axistwin import Bench
from axistwin.core.errors import UsageError
from axistwin.records.traces.files import VcdSink
from axistwin.records.traces.trace import tracing

from ..told import raises


def send_and_run(bench: Bench, *messages: str) -> None:
    bench.run(1.5)
    for message in ("(", "U61\r", *messages):
        bench["if1"].serial.write(message.encode())
        bench.run(2.0)


MESSAGES = ("S1$\r", "X100Y-60@500$\r", "X-Y$\r", "E\r", "E\r", "Z@800G$\r", "#\r")


def traced(path: Path, *messages: str, model: str = "if1", **options) -> Bench:
    bench = Bench()
    bench.add(model, "if1", **options)
    with tracing(bench, path):
        send_and_run(bench, *messages)
    return bench


def read_csv(path: Path) -> list[tuple[int, str, str]]:
    header, *rows = csv.reader(line for line in path.read_text().splitlines() if not line.startswith("#"))
    assert header == ["time_ns", "signal", "value"]
    return [(int(time), signal, value) for time, signal, value in rows]


def read_vcd(path: Path) -> list[tuple[int, str, object]]:
    """Return the changes after the initial values: time, full name of the signal, and value."""
    names: dict[str, str] = {}
    scopes: list[str] = []
    changes: list[tuple[int, str, object]] = []
    now_ns, dumping = 0, False
    with path.open("rb") as file:
        for token in tokenize(file):
            match token.kind:
                case TokenKind.SCOPE:
                    scopes.append(token.scope.ident)
                case TokenKind.UPSCOPE:
                    scopes.pop()
                case TokenKind.VAR:
                    names[token.var.id_code] = ".".join((*scopes, token.var.reference))
                case TokenKind.TIMESCALE:
                    assert (token.timescale.magnitude, token.timescale.unit.value) == (1, "ns")
                case TokenKind.DUMPVARS:
                    dumping = True
                case TokenKind.END:
                    dumping = False
                case TokenKind.CHANGE_TIME:
                    now_ns = token.time_change
                case TokenKind.CHANGE_SCALAR | TokenKind.CHANGE_VECTOR | TokenKind.CHANGE_STRING:
                    change = token.data
                    if not dumping:
                        changes.append((now_ns, names[change.id_code], change.value))
    return changes


def of(rows, signal):
    return [(time, value) for time, name, value in rows if name == signal]


def test_csv_has_every_pulse_with_its_position(tmp_path):
    bench = traced(tmp_path / "a.csv", *MESSAGES)
    rows = read_csv(tmp_path / "a.csv")
    assert [time for time, *_ in rows] == sorted(time for time, *_ in rows)
    for name, axis in bench["if1"].axes.items():
        first, *pulses = of(rows, f"if1.{name}.pulses")
        assert first == (0, "0")
        assert [time for time, _ in pulses] == axis.pulse_times().tolist() and int(pulses[-1][1]) == axis.pulses
        assert not of(rows, f"if1.{name}.step")
    directions = [value for _, value in of(rows, "if1.Y.direction")]
    assert directions == ["1", "0", "1"]
    assert of(rows, "if1.output1")[1:] == [(of(rows, "if1.output1")[1][0], "1")]


def test_csv_has_the_messages(tmp_path):
    traced(tmp_path / "a.csv", "E\r", "E\r")
    rows = read_csv(tmp_path / "a.csv")
    assert [v for _, v in of(rows, "if1.host_says")] == ["", "(", "", r"U61\r", r"E\r", "", r"E\r", ""]
    assert [v for _, v in of(rows, "if1.controller_says")] == ["", "U", r"U\r", "", "C", r"C\r", "", "C", r"C\r"]


def test_vcd_has_real_step_pulses(tmp_path):
    bench = traced(tmp_path / "a.vcd", *MESSAGES)
    changes = read_vcd(tmp_path / "a.vcd")
    assert [time for time, *_ in changes] == sorted(time for time, *_ in changes)
    for name, axis in bench["if1"].axes.items():
        steps = of(changes, f"if1.{name}.step")
        assert [time for time, level in steps if level == "1"] == axis.pulse_times().tolist()
        assert [level for _, level in steps] == ["1", "0"] * (len(steps) // 2)
        assert {fall - rise for (rise, _), (fall, _) in zip(steps[::2], steps[1::2], strict=True)} == {250}
        assert of(changes, f"if1.{name}.pulses")[-1][1] == axis.pulses % (1 << 64)


def test_vcd_has_pins_and_messages(tmp_path):
    traced(tmp_path / "a.vcd", "S1$\r", "E\r")
    changes = read_vcd(tmp_path / "a.vcd")
    assert [value for _, value in of(changes, "if1.output1")] == ["1"]
    assert [value for _, value in of(changes, "if1.rts")] == ["1", "0"] * 2
    assert r"C\r" in [value for _, value in of(changes, "if1.controller_says")]
    assert "axistwin" in (tmp_path / "a.vcd").read_text().split("$end")[0]


def test_tracing_does_not_change_a_bench(tmp_path):
    bench = traced(tmp_path / "a.csv", *MESSAGES)
    plain = Bench()
    plain.add("if1")
    send_and_run(plain, *MESSAGES)
    assert plain["if1"].serial.read() == bench["if1"].serial.read()
    for name, axis in plain["if1"].axes.items():
        assert axis.pulse_times().tolist() == bench["if1"].axes[name].pulse_times().tolist()
    assert (plain.clock.next_event_ns(), plain.now) == (bench.clock.next_event_ns(), bench.now)


def test_a_trace_has_pulses_that_the_train_has_deleted(tmp_path):
    bench = traced(tmp_path / "a.csv", ":X5@200:X-:=9,1:$\r", "\r", history=4)
    assert len(of(read_csv(tmp_path / "a.csv"), "if1.X.pulses")[1:]) == 100
    assert bench["if1"].axes["X"].train.forgotten


def test_a_trace_begins_with_the_present_values(tmp_path):
    bench = Bench()
    bench.add("if1")
    send_and_run(bench, "S1$\r", "X100$\r")
    with tracing(bench, tmp_path / "a.csv"):
        bench["if1"].serial.write(b"X$\r")
        bench.run(2.0)
    rows = read_csv(tmp_path / "a.csv")
    assert of(rows, "if1.output1") == [(9_500_000_000, "1")]
    assert of(rows, "if1.X.pulses")[0] == (9_500_000_000, "100") and of(rows, "if1.X.pulses")[-1][1] == "200"


def test_an_unfinished_motion_is_traced_up_to_the_end(tmp_path):
    bench = traced(tmp_path / "a.csv", "X@1000G$\r")
    assert bench["if1"].axes["X"].moving
    assert int(of(read_csv(tmp_path / "a.csv"), "if1.X.pulses")[-1][1]) == bench["if1"].axes["X"].pulses


def end_with(error: BaseException, bench: Bench, path: Path) -> None:
    bench.add("if1")
    with tracing(bench, path):
        send_and_run(bench, "X10$\r")
        raise error


@pytest.mark.parametrize("error", [KeyboardInterrupt(), ValueError()], ids=repr)
def test_after_an_exception_the_file_is_complete(tmp_path, bench, error):
    with pytest.raises(type(error)):
        end_with(error, bench, tmp_path / "a.vcd")
    assert of(read_vcd(tmp_path / "a.vcd"), "if1.X.pulses")[-1][1] == 10
    assert {file.name for file in tmp_path.iterdir()} == {"a.vcd", "a.gtkw"}


def interrupt_in_the_middle_of_writing(bench: Bench, path: Path, monkeypatch) -> None:
    bench.add("if1")
    with tracing(bench, path) as trace:
        send_and_run(bench, "X100$\r")
        trace.catch_up()
        monkeypatch.setattr(VcdSink, "write", interrupt)
        send_and_run(bench, "X100$\r")


def interrupt(*_):
    raise KeyboardInterrupt


def test_an_interrupt_in_the_middle_of_writing_leaves_a_file_that_can_be_read(tmp_path, bench, monkeypatch):
    raises(KeyboardInterrupt, "", interrupt_in_the_middle_of_writing, bench, tmp_path / "a.vcd", monkeypatch)
    times = [time_ns for time_ns, _ in of(read_vcd(tmp_path / "a.vcd"), "if1.X.pulses")]
    assert times == sorted(times) and len(times) == 100


def test_a_closed_trace_has_unsubscribed(tmp_path, bench):
    if1 = bench.add("if1")
    before = [bool(axis.on_motion) for axis in if1.axes.values()]
    with tracing(bench, tmp_path / "a.csv"):
        pass
    assert [bool(axis.on_motion) for axis in if1.axes.values()] == before
    send_and_run(bench, "X10$\r")


@pytest.mark.parametrize("name", ["a.txt", "a"])
def test_an_unknown_suffix_is_rejected(tmp_path, bench, name):
    raises(UsageError, "ends in .csv, .vcd, .sigrok.vcd or .parquet", tracing, bench, tmp_path / name)
