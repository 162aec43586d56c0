"""Traces in all kinds of files: selection of signals, registers, Parquet, errors during writing, and reading."""

import errno
import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from axistwin import Bench, Scene
from axistwin.core.errors import TraceError, UsageError
from axistwin.core.units import S
from axistwin.records.traces import files as trace_files
from axistwin.records.traces import output
from axistwin.records.traces import trace as tracer
from axistwin.records.traces.reading import Trace, read
from axistwin.records.traces.signals import catalogue, choose
from axistwin.records.traces.trace import tracing

from ..told import raises

pq = pytest.importorskip("pyarrow.parquet")
KINDS = ("csv", "vcd", "parquet")
FEW = ("if1.*", "1811.*", "*volts", "*says")
"""Patterns of the signals with few changes, 300 together."""
WINDER = Path(__file__).parents[2] / "examples" / "winder" / "scene.toml"


def workshop() -> Bench:
    bench = Bench()
    bench.add("if1", X={"limits": (-50, 5000)})
    bench.add("1811")
    bench.add("smartmotor", "motor", shaft={"motor": "frame23"})
    return bench


def work(bench: Bench) -> None:
    bench.run(1.6)
    for message in ("(", "U61\r", "X40@1000S1$\r"):
        bench["if1"].serial.write(message.encode())
        bench.run(1.2)
    bench["motor"].serial.write(b"UCI UDI ZS A=100 V=400000 MP O=0 P=300 G a=7 RP ")
    for text in ("31 00 00 00 00 03 E8 00 03 D0 90", "33 00 00 00 64", "83"):
        for byte in bytes.fromhex(text):
            bench["1811"].bus.write(0, byte)
        bench["1811"].bus.write(1, 0x10)
        bench.run(0.02)
    bench["motor"].pins["A"].drive(2.5)
    bench.run(1.5)


def traced(path: Path, patterns: Sequence[str] = ("*",)) -> Trace:
    bench = workshop()
    with tracing(bench, path, patterns):
        work(bench)
    return read(path)


@pytest.fixture(scope="module")
def traces(tmp_path_factory) -> dict[str, Trace]:
    directory = tmp_path_factory.mktemp("traces")
    return {kind: traced(directory / f"a.{kind}") for kind in KINDS}


# Kinds of files


@pytest.mark.parametrize("kind", ["vcd", "parquet"])
def test_all_kinds_of_files_have_the_same_contents(traces, kind):
    csv, other = traces["csv"], traces[kind]
    assert (csv.begin_ns, csv.end_ns, csv.about) == (other.begin_ns, other.end_ns, other.about)
    for name, track in csv.tracks.items():
        same = other.tracks[name]
        assert (same.kind, same.times, same.values) == (track.kind, track.times, track.values), name
    assert {name.rpartition(".")[2] for name in other.tracks.keys() - csv.tracks.keys()} <= {"step"}


def test_only_changes_are_written(traces):
    for track in traces["csv"].tracks.values():
        pairs = zip(track.values, track.values[1:], strict=False)
        assert all(before != after for before, after in pairs), track.name
        assert list(track.times) == sorted(track.times)


def test_a_trace_contains_its_provenance(traces):
    about = traces["parquet"].about
    assert list(about) == ["axistwin", "controller if1", "controller 1811", "controller motor"]
    assert about["controller motor"] == 'smartmotor {"shaft": {"motor": "frame23"}}'


def test_the_provenance_contains_the_origin_of_a_bench(tmp_path):
    bench = workshop()
    bench.origin |= {"scene": "line.toml sha256:1234", "seed": "7"}
    with tracing(bench, tmp_path / "a.csv"):
        pass
    assert list(read(tmp_path / "a.csv").about.items())[1:3] == [("scene", "line.toml sha256:1234"), ("seed", "7")]


def test_numbers_of_axes_and_voltages_have_units(tmp_path, traces):
    units = json.loads(pq.read_schema(traces["parquet"].path).metadata[b"axistwin.units"])
    head = [line for line in traces["csv"].path.read_text().splitlines() if line.startswith("# unit of ")]
    assert head == [f"# unit of {name}: {unit}" for name, unit in units.items()]
    assert units["if1.X.velocity"] == "pulses/s" and units["motor.A_volts"] == "V"
    assert units["motor.shaft.position"] == "counts"
    assert not {"if1.output1", "motor.RPE", "if1.host_says"} & units.keys()


def test_sigrok_gets_levels_and_numbers_with_full_names_only(tmp_path, traces):
    path = tmp_path / "a.sigrok.vcd"
    found = traced(path, ("if1.*", "motor.shaft.*"))
    definitions = [line.split()[1:3] for line in path.read_text().splitlines() if line.startswith("$var")]
    assert {tuple(each) for each in definitions} == {("wire", "1"), ("real", "64")}
    assert "$scope" not in path.read_text()
    assert not any(line.startswith(("b", "s")) for line in path.read_text().splitlines())
    assert found.tracks["if1.X.step"].times == traces["vcd"].tracks["if1.X.step"].times
    assert list(found.tracks["motor.shaft.position"].values) == list(
        traces["csv"].tracks["motor.shaft.position"].values
    )


# The save file of GTKWave


def test_a_save_file_opens_the_waves_with_groups_and_analog_lanes(tmp_path):
    traced(tmp_path / "a.vcd", ("if1.output1", "if1.host_says", "if1.X.pulses"))
    *head, zoom = (tmp_path / "a.gtkw").read_text().splitlines()[:4]
    assert re.match(r"\*-22\.\d{6} -1 ", zoom)  # the zoom for the whole run in 1000 pixels of 2 ** 22.7 ns
    assert [*head, *(tmp_path / "a.gtkw").read_text().splitlines()[4:]] == [
        "[*] axistwin writes this file again with each trace; a file saved by GTKWave is kept",
        '[dumpfile] "a.vcd"',
        "[timestart] 0",
        "@800200", "-if1", "@28", "+{if1.output1} if1.output1", "@820", "+{if1.host_says} if1.host_says",
        "@1000200", "-if1",
        "@800200", "-if1.X", "@88420", "+{if1.X.pulses [pulses]} if1.X.pulses", "@20200", "-", "-",
        "@1000200", "-if1.X",
    ]  # fmt: skip


def test_a_save_file_of_the_user_is_kept(tmp_path):
    (tmp_path / "a.gtkw").write_text("[*] GTKWave Analyzer v3.3.118\n")
    traced(tmp_path / "a.vcd", ("if1.output1",))
    assert (tmp_path / "a.gtkw").read_text() == "[*] GTKWave Analyzer v3.3.118\n"


def test_a_save_file_that_cannot_be_written_is_reported_and_the_trace_continues(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(tracer, "write_save_file", full)
    told = []
    with tracing(Bench(), tmp_path / "a.vcd", (), told.append):
        pass
    assert told == ["no GTKWave save file beside a.vcd: No space left on device"] * 2


def test_a_trace_ends_at_its_limit(tmp_path, traces):
    told, bench = [], workshop()
    with tracing(bench, tmp_path / "a.csv", ("*",), told.append, limit=20_000):
        work(bench)
    assert len(told) == 1
    assert re.fullmatch(
        r"the trace a\.csv ends at \d\.\d{6} s, because the trace file has reached the size limit of 0\.02 MB "
        r"and receives no more data: set a larger limit, e\.g\. --trace-limit 5GB",
        told[0],
    )
    assert (tmp_path / "a.csv").stat().st_size <= 20_000
    short = read(tmp_path / "a.csv")
    assert all(track.times == traces["csv"].tracks[name].times[: len(track)] for name, track in short.tracks.items())


@pytest.mark.parametrize("ending", ["csv", "vcd"])
def test_a_limited_trace_uses_the_allowed_size(tmp_path, traces, ending):
    """All changes up to the reported time (in µs) are in the file, although they are written in large pieces."""
    told, bench = [], workshop()
    path = tmp_path / f"a.{ending}"
    limit = traces[ending].path.stat().st_size // 2
    with tracing(bench, path, ("*",), told.append, limit=limit):
        work(bench)
    assert limit - 200 < path.stat().st_size <= limit  # a line and a time are shorter than 200 characters
    (ends_s,) = re.findall(r"ends at (\d+\.\d+) s", told[0])
    short = read(path)
    assert set(short.tracks) == set(traces[ending].tracks)
    for name, track in short.tracks.items():
        whole = [time_ns for time_ns in traces[ending].tracks[name].times if time_ns < float(ends_s) * 1e9 - 1000]
        assert list(track.times[: len(whole)]) == whole


def test_parquet_has_plain_columns_in_compact_encodings(traces):
    path = traces["parquet"].path
    table = pq.read_table(path)
    assert table.column_names == ["time_ns", "signal", "integer", "number", "text"]
    assert table["time_ns"].to_pylist() == sorted(table["time_ns"].to_pylist())
    group = pq.ParquetFile(path).metadata.row_group(0)
    assert "DELTA_BINARY_PACKED" in group.column(0).encodings
    assert "BYTE_STREAM_SPLIT" in group.column(3).encodings and group.column(0).compression == "ZSTD"
    assert pq.read_schema(path).metadata[b"axistwin"]


@pytest.mark.parametrize(("rows", "patterns"), [(1, FEW), (7, FEW), (100, ("*",))])
def test_parquet_in_many_groups(tmp_path, traces, monkeypatch, rows, patterns):
    from axistwin.records.traces import parquet as trace_parquet

    monkeypatch.setattr(trace_parquet, "GROUP", rows)
    monkeypatch.setattr(tracer, "CHUNK", 50)
    again = traced(tmp_path / "a.parquet", patterns).tracks
    assert again == {name: traces["parquet"].tracks[name] for name in again}
    assert pq.ParquetFile(tmp_path / "a.parquet").num_row_groups > 10


def test_without_pyarrow_there_is_no_parquet(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(UsageError, match=r'needs pyarrow: pip install "pyarrow.*", or in a clone .*"\.\[traces\]"'):
        tracing(workshop(), tmp_path / "a.parquet")


# Signals


def names(*patterns: str) -> list[str]:
    return [signal.full for signal in choose(catalogue(workshop()), patterns)]


def test_patterns():
    assert names("if1.X.*") == ["if1.X.direction", "if1.X.step", "if1.X.pulses", "if1.X.velocity"]
    assert names("motor.RPE") == names("motor.@PE") == ["motor.RPE"] and names("if1.output?", "if1.K")[-1] == "if1.K"
    assert names("*.host_says") == ["if1.host_says", "1811.host_says", "motor.host_says"]


def test_the_default_pattern_selects_pins_axes_and_messages():
    default = names("default")
    assert {"if1.output1", "1811.motor.pulses", "motor.shaft.position", "motor.A_volts", "motor.host_says"} <= set(
        default
    )
    assert not {"if1.K", "1811.status", "motor.RPE"} & set(default) and set(names("*")) > set(default)


def test_a_pin_and_a_variable_of_the_same_name():
    assert names("motor.E") == ["motor.E"] and names("motor.RE") == ["motor.RE"]


def test_a_costly_signal_is_selected_only_by_its_full_name():
    assert "motor.RTEMP" not in names("*") and names("motor.RTEMP") == ["motor.RTEMP"]


def test_an_unknown_signal_is_rejected_with_a_suggestion():
    raises(UsageError, "no signal matches 'if1.outptu1': did you mean 'if1.output1'?", names, "if1.outptu1")
    with pytest.raises(UsageError, match=r"no signal matches 'nothing\*': there are if1.input1, if1.input2, .* …"):
        names("nothing*")


# Registers


def test_registers_of_the_families(traces):
    tracks = traces["csv"].tracks
    assert tracks["if1.state"].values == ["self-test", "waiting for (", "waiting for the data format", "ready"]
    assert tracks["if1.E"].values[-2:] == ["E", "C"] and "33 00 00 00 64" in tracks["1811.input"].values
    assert tracks["1811.phase"].values == ["rest", "accelerating", "constant", "decelerating", "rest"]
    assert 0x58 in tracks["1811.status"].values  # a message is ready
    assert list(tracks["motor.Ra"].values) == [0, 7]


def test_a_motors_variables_change_at_their_samples(tmp_path):
    """The trace has every sample with a change, although the motor computes its samples ahead of the clock."""
    bench = workshop()
    motor = bench["motor"]
    with tracing(bench, tmp_path / "a.csv", ("motor.RP", "motor.shaft.position", "motor.RBt", "motor.P")):
        work(bench)
    tracks = read(tmp_path / "a.csv").tracks
    actual, shaft = tracks["motor.RP"], tracks["motor.shaft.position"]
    assert actual.values[-1] == motor.axes["shaft"].position and set(shaft.times) <= set(actual.times) | {0}
    assert [value for _, value in zip(actual.times, actual.values, strict=True)][-50:] == list(shaft.values)[-50:]
    assert list(tracks["motor.RBt"].values) == [0, 1, 0] and tracks["motor.P"].times[1] < tracks["motor.RBt"].times[1]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("patterns", [("*",), ("motor.R*",), ("motor.shaft.*", "if1.*.pulses"), ("*says", "*volts")])
def test_the_size_of_the_pieces_does_not_change_a_file(tmp_path, monkeypatch, kind, patterns):
    monkeypatch.setattr("axistwin.records.traces.parquet.GROUP", 100)
    traced(tmp_path / f"a.{kind}", patterns)
    monkeypatch.setattr(tracer, "CHUNK", 3)
    traced(tmp_path / f"b.{kind}", patterns)
    assert (tmp_path / f"a.{kind}").read_bytes() == (tmp_path / f"b.{kind}").read_bytes()


def test_a_burst_after_a_long_rest_is_written_in_pieces(tmp_path, monkeypatch):
    """A piece has a limited number of changes, but may span any time."""
    sizes, write = [], trace_files.CsvSink.write
    monkeypatch.setattr(
        trace_files.CsvSink, "write", lambda sink, batch: (sizes.append(len(batch)), write(sink, batch))
    )
    monkeypatch.setattr(tracer, "CHUNK", 500)
    bench = workshop()
    with tracing(bench, tmp_path / "a.csv", ("if1.X.pulses", "if1.X.velocity")):
        for message in ("(", "U61\r"):
            bench.run(1.6)
            bench["if1"].serial.write(message.encode())
        bench.run(3600)
        bench["if1"].serial.write(b"X4000@10000$\r")
        bench.run(3600)
    assert sum(sizes) > 4000 and max(sizes) <= 600


def test_after_a_power_cycle_variables_have_their_initial_values(tmp_path):
    bench = workshop()
    with tracing(bench, tmp_path / "a.csv", ("motor.Ra", "motor.RA")):
        work(bench)
        bench["motor"].power_cycle()
        bench.run(0.5)
        bench["motor"].serial.write(b"a=5 ")
        bench.run(0.5)
    tracks = read(tmp_path / "a.csv").tracks
    assert list(tracks["motor.Ra"].values) == [0, 7, 0, 5] and list(tracks["motor.RA"].values) == [0, 100, 0]


def test_a_motor_at_rest_is_traced_while_it_warms(tmp_path):
    bench = workshop()
    bench["motor"].ambient = 150
    with tracing(bench, tmp_path / "a.csv", ("motor.RTEMP",)):
        bench.run(20)
    temperature = read(tmp_path / "a.csv").tracks["motor.RTEMP"]
    assert list(temperature.values[:2]) == [25, 26] and 0 < temperature.times[1] < 20 * S


def test_tracing_registers_does_not_change_a_bench(tmp_path):
    few, all_ = traced(tmp_path / "a.csv", ("default",)), traced(tmp_path / "b.csv", ("*",))
    for name, track in few.tracks.items():
        assert track == all_.tracks[name]


# Errors during writing


class Disk:
    def __init__(self, room: int, monkeypatch) -> None:
        self.room, self._write = room, output._write_part
        monkeypatch.setattr(output, "_write_part", self.write)

    def write(self, file: int, data: bytes, place: int) -> int:
        if place >= self.room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return self._write(file, bytes(data)[: self.room - place], place)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("room", [20_000, 31_000])
def test_a_full_disk_ends_only_the_trace(tmp_path, monkeypatch, kind, room, traces):
    monkeypatch.setattr(tracer, "CHUNK", 100)
    monkeypatch.setattr("axistwin.records.traces.parquet.GROUP", 100)
    path, told = tmp_path / f"a.{kind}", []
    Disk(room, monkeypatch)
    bench = workshop()
    with tracing(bench, path, ("*",), told.append):
        work(bench)
    assert bench["if1"].axes["X"].position == 40
    assert len(told) == 1 and told[0].startswith(f"the trace a.{kind} ends at ")
    assert told[0].endswith(" s, because writing failed: No space left on device")
    left = read(path)
    for name, track in left.tracks.items():
        whole = traces[kind].tracks[name]
        assert list(track.times) == list(whole.times)[: len(track)]
        assert list(track.values) == list(whole.values)[: len(track)]


def test_a_full_disk_from_the_beginning(tmp_path, monkeypatch):
    Disk(0, monkeypatch)
    told = []
    with tracing(workshop(), tmp_path / "a.csv", report=told.append) as trace:
        trace.catch_up()
    assert told == ["the trace a.csv ends at 0.000000 s, because writing failed: No space left on device"]


KILLED = """
import os, signal, sys
from contextlib import ExitStack
from pathlib import Path
from axistwin import Bench
from axistwin.records.traces.trace import tracing
bench = Bench()
if1 = bench.add("if1")
with ExitStack() as stack:
    traces = [stack.enter_context(tracing(bench, Path(file))) for file in sys.argv[1:]]
    bench.run(1.5)
    for message in (b"(", b"U61\\r", b"X100@1000$\\r"):
        if1.serial.write(message)
        bench.run(1.5)
    for trace in traces:
        trace.catch_up()
    if1.serial.write(b"X$\\r")
    bench.run(1.5)
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_files_are_readable_after_their_program_was_killed(tmp_path):
    files = [tmp_path / f"a.{kind}" for kind in KINDS]
    assert subprocess.run([sys.executable, "-c", KILLED, *files], check=False).returncode == -signal.SIGKILL
    for file in files:
        assert read(file).tracks["if1.X.pulses"].values[-1] == 100, file


# Reading


@pytest.mark.parametrize("kind", ["csv", "vcd"])
def test_an_incomplete_last_line_is_left_out(tmp_path, kind):
    path = tmp_path / f"a.{kind}"
    traced(path, FEW)
    whole = path.read_bytes()
    for length in range(len(whole) // 2, len(whole) // 2 + 60):
        path.write_bytes(whole[:length])
        assert read(path).tracks["if1.X.pulses"].values[0] == 0


@pytest.mark.parametrize("name", ["a.csv", "a.vcd", "a.parquet"])
@pytest.mark.parametrize("data", [b"", b"time,what\n1,2\n", b"#1\n#2\n"])
def test_other_files_are_rejected(tmp_path, name, data):
    (tmp_path / name).write_bytes(data)
    raises(TraceError, "", read, tmp_path / name)


@pytest.mark.parametrize(("kind", "old", "new", "message"), [
    ("csv", "0,if1.input1,0\n", "99999999999999999999,if1.input1,0\n", "invalid change"),
    ("csv", "0,if1.X.pulses,0\n", "0,if1.X.pulses,99999999999999999999\n", "invalid change"),
    ("csv", "# end_ns: ", "# end_ns: x", "invalid time"),
    ("csv", "if1.input1", "if1.\udce4", "is not a trace: expected text in UTF-8"),
    ("vcd", "\n#0\n", "\n#abc\n", "invalid time"), ("vcd", "\n#0\n", "\n#99999999999999999999\n", "invalid time"),
    ("vcd", "$timescale 1 ns", "$timescale 10 ps", "unsupported time scale 10 ps in .*: expected 1 ns"),
    ("vcd", "\nb0 ", "\nbx ", "invalid change")])  # fmt: skip
def test_a_damaged_trace_is_rejected(tmp_path, traces, kind, old, new, message):
    text = traces[kind].path.read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / f"a.{kind}"
    path.write_bytes(text.replace(old, new, 1).encode("utf-8", "surrogateescape"))
    with pytest.raises(TraceError, match=message):
        read(path)


def test_numbers_with_many_digits_are_the_same_in_all_kinds_of_files(tmp_path):
    found = set()
    for kind in KINDS:
        bench = Scene.load(WINDER).build()
        with tracing(bench, tmp_path / f"a.{kind}", ("traverse.motor.velocity",)):
            bench.run(3)
        found.add(tuple(read(tmp_path / f"a.{kind}").tracks["traverse.motor.velocity"].values))
    assert len(found) == 1 and any(len(repr(rate)) > 17 for rate in found.pop())


def test_a_missing_file_and_an_unknown_suffix(tmp_path):
    raises(UsageError, "cannot be read: No such file", read, tmp_path / "a.csv")
    raises(UsageError, "expected a name that ends in .csv, .vcd or .parquet", read, tmp_path / "a.txt")


def test_a_message_without_terminator_has_a_limited_length(tmp_path):
    bench = Bench()
    if1 = bench.add("if1", line="instant")
    with tracing(bench, tmp_path / "a.csv"):
        for _ in range(2000):
            if1.serial.write(b"x")
            bench.run(0.001)
    assert max(len(text) for text in read(tmp_path / "a.csv").tracks["if1.host_says"].values) <= 256
    assert (tmp_path / "a.csv").stat().st_size < 1_000_000
