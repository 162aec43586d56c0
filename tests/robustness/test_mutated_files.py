"""A small instance of `benchmarks/robustness/mutated_files.py`, and each file that once ended in a traceback."""

import json

import pytest

from axistwin import Bench, Scene, tracing
from axistwin.cli.program import execute
from axistwin.controllers.smartmotor.kernel.core import Engine
from axistwin.core.errors import ProgramError, SceneError, TraceError, UsageError
from axistwin.records.traces.reading import read
from axistwin.ui.editor.smartmotor import SourceEditing

from ..campaigns import campaign

pa = pytest.importorskip("pyarrow")
pq = pytest.importorskip("pyarrow.parquet")
pytest.importorskip("pygls")


@pytest.fixture(scope="module")
def mutated_files():
    return campaign("mutated_files")


@pytest.mark.parametrize("kind", ["toml", "talk", "if1", "181x", "sms", "parquet", "vcd", "csv", "state"])
def test_twelve_mutated_files(mutated_files, kind, monkeypatch):
    """No traceback and no hang, and one line for each refusal; `check` accepts exactly the scenes that can be built."""
    monkeypatch.setattr(Engine, "_compiled", lambda engine: None)  # a compilation takes longer than the time limit
    verdict = mutated_files.campaign((kind,), 12, seed=1811)
    assert verdict.found == [] and verdict.files[kind] == 12
    assert verdict.refused[kind] > 0


def test_the_same_seed_gives_the_same_files(mutated_files):
    import random

    data = b"; model: if1\n> X100$\\r\n+1.5\n"
    made = [mutated_files.mutated(data, "talk", random.Random("1 talk 7")) for _ in range(2)]
    assert made[0] == made[1] != data


# Parquet


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    path = tmp_path_factory.mktemp("trace") / "a.parquet"
    bench = Bench()
    bench.add("if1")
    with tracing(bench, path, ("default",)):
        bench.run(1.2)
    return pq.read_table(path)


SIGNALS = b"axistwin.signals"


@pytest.mark.parametrize(("change", "message"), [
    (lambda t: t.replace_schema_metadata(None), "expected a list of signals in the metadata"),
    (lambda t: t.replace_schema_metadata({SIGNALS: b"{"}), "expected a list of signals in the metadata"),
    (lambda t: t.replace_schema_metadata({SIGNALS: b"[" * 9999}), "expected a list of signals in the metadata"),
    (lambda t: t.replace_schema_metadata({SIGNALS: b"[]"}), "expected a list of signals in the metadata"),
    (lambda t: t.replace_schema_metadata({SIGNALS: b'{"a": 5}'}), "expected a list of signals in the metadata"),
    (lambda t: t.drop_columns(["integer"]), "exactly one column integer of type int64, found no such column"),
    (lambda t: t.drop_columns(["time_ns"]), "exactly one column time_ns of type int64, found no such column"),
    (lambda t: changed(t, "time_ns", pa.nulls(len(t), pa.int64())), "in each row of the column time_ns"),
    (lambda t: changed(t, "integer", pa.nulls(len(t), pa.int64())), "in the column integer, a value of the signal"),
    (lambda t: changed(t, "integer", pa.nulls(len(t), pa.string())), "column integer of type int64, found string"),
    (lambda t: changed(t, "signal", pa.nulls(len(t), pa.int32())), "column signal of type string, found int32"),
    (lambda t: t.append_column("time_ns", t["time_ns"]), "time_ns"),
    (lambda t: t.take(pa.array([*range(len(t))][::-1])), "expected numbers of at least 0 in ascending order")
])  # fmt: skip
def test_a_parquet_file_that_is_no_trace(tmp_path, table, change, message):
    path = tmp_path / "b.parquet"
    pq.write_table(change(table), path)
    with pytest.raises(TraceError, match=message) as told:
        read(path)
    assert "\n" not in str(told.value)


def changed(table, name, values):
    return table.set_column(table.column_names.index(name), name, values)


def test_a_parquet_file_that_is_torn(tmp_path, table):
    path = tmp_path / "b.parquet"
    pq.write_table(table, path)
    path.write_bytes(path.read_bytes()[:-50])
    with pytest.raises(TraceError, match="is damaged or is not a Parquet file"):
        read(path)


# Texts


VCD = "$scope module a $end\n$var integer 64 ! n $end\n$upscope $end\n$enddefinitions $end\n"


@pytest.mark.parametrize(("name", "text", "message"), [
    ("a.vcd", VCD + f"#0\nb{'1' * 65} !\n", "a.vcd:6: invalid change"),
    ("a.vcd", VCD + f"#0\nb{'1' * 5000} !\n", "a.vcd:6: invalid change"),
    ("a.vcd", VCD + f"#{'9' * 5000}\n", "a.vcd:5: invalid time '9+'… .5000 characters.: expected nanoseconds"),
    ("a.csv", f"# axistwin: 1\ntime_ns,signal,value\n0,a.n,1\n{'9' * 5000},a.n,2\n", "a.csv:4: invalid change"),
    ("a.csv", f"time_ns,signal,value\n0,a.n,{'9' * 200000}\n", "a.csv:2: this line is not valid CSV: field larger"),
    ("a.csv", "time_ns,signal,value\n5,a.n,1\n4,a.n,2\n", "expected numbers of at least 0 in ascending order")
])  # fmt: skip
def test_a_trace_with_numbers_that_are_none(tmp_path, name, text, message):
    (tmp_path / name).write_text(text)
    with pytest.raises(TraceError, match=message) as told:
        read(tmp_path / name)
    assert len(str(told.value)) < 400


def test_a_vcd_value_of_64_bits_is_read(tmp_path):
    (tmp_path / "a.vcd").write_text(VCD + f"#0\nb{'1' * 64} !\n")
    assert list(read(tmp_path / "a.vcd").tracks["a.n"].values) == [-1]


def test_a_signal_of_another_kind_than_its_name_says_is_drawn(tmp_path):
    """E.g. a byte stream of digits, a position that is a text, or a signal outside of any scope."""
    lines = ("0,if1.host_says,5", "0,if1.X.position,here", "0,alone,1", "9,if1.host_says,6", "9,if1.X.position,there")
    (tmp_path / "a.csv").write_text("time_ns,signal,value\n" + "\n".join((*lines, "9,alone,0")) + "\n")
    assert execute(["plot", str(tmp_path / "a.csv"), "-o", str(tmp_path / "a.svg")]) == 0


@pytest.mark.parametrize(("text", "message"), [
    ("; options: name='a\n", "a.talk:1: a quotation mark is missing in the options"),
    ("; options: line=5\n",
     "a.talk:1: invalid baud rate or character format 5: expected e.g. '9600 8N2', or 'instant'"),
    (f"; options: X={'[' * 3000}\n", "a.talk:1: invalid option value '[[[["),
    (f"; patience: {'9' * 5000}\n> a\n", "a.talk:1: invalid value '999"),
    (f"+{'9' * 5000}\n", "a.talk:1:2: invalid time '999"),
    ("+9999999999999\n", "a.talk:1:2: '9999999999999' s is too long: expected less than 9.2e9 s"),
    (f'! fault jam X when="X passes {"9" * 5000}"\n', "a.talk:1: invalid axis position in the event when='X"),
    (f"! fault jam X at={'9' * 5000}\n", "a.talk:1: invalid value at='999"),
    (f"= X.position {'9' * 5000}\n", "a.talk:1: '999"), (f"= X.position 0.{'0' * 80}\n> (\n", ""),
    ("= X.position 1e999999999\n", "a.talk:1: '1e999999999' is out of range"),
    ("! break 1e300\n", "a.talk:1: 1e+300 s is too long")])  # fmt: skip
def test_a_conversation_with_odd_options_and_numbers(tmp_path, capsys, text, message):
    (tmp_path / "a.talk").write_text(text)
    code = execute(["run", "if1", str(tmp_path / "a.talk")])
    told = capsys.readouterr().err
    assert message in told and code == (1 if "a.talk" in message else 2 if message else 0)
    assert all(len(line) < 400 for line in told.splitlines())


@pytest.mark.parametrize(("suffix", "model", "text"), [
    ("181x", "1811", f"go_relative {'9' * 5000}\n"), ("181x", "1811", f"+{'9' * 5000}\n"),
    ("if1", "if1", f"+{'9' * 5000}\n"), ("if1", "if1", f"! X.load {'9' * 5000}\n"),
    ("181x", "1811", "! joystick 1e12\n")])  # fmt: skip
def test_a_program_with_long_numbers(tmp_path, capsys, suffix, model, text):
    (tmp_path / f"a.{suffix}").write_text(text)
    assert execute(["run", model, str(tmp_path / f"a.{suffix}"), "--for", "3"]) == 1
    told = capsys.readouterr().err
    assert f"a.{suffix}:1:" in told and len(told) < 400


@pytest.mark.parametrize("number", ["9" * 20, "-" + "9" * 400])
def test_a_scene_with_numbers_beyond_64_bits(tmp_path, number):
    """TOML has whole numbers of 64 bits; larger ones are refused."""
    (tmp_path / "s.toml").write_text(f'[[controller]]\nmodel = "smartmotor"\naxes.shaft.limits = [{number}, 5]\n')
    with pytest.raises(SceneError, match=r"s\.toml:3:\d+: .*more than 64 bits"):
        Scene.load(tmp_path / "s.toml")


@pytest.mark.parametrize("text", ["GOSUB", "GOTO", "C", "a=", "BAUD", "PRINT(#"])
def test_an_editor_asks_about_a_long_number(text):
    lines = [text + "9" * 5000]
    for at in (0, 3, 5000):
        SourceEditing().hover(lines, 1, at)
        SourceEditing().complete(lines, 1, at)
    SourceEditing().symbols(lines)


def test_limits_beyond_any_axis():
    with pytest.raises(UsageError, match=r"invalid limits of axis shaft: expected positions from -9007199254740992 to"):
        Bench().add("smartmotor", shaft={"limits": (-(2**62), 5)})
    Bench().add("smartmotor", shaft={"limits": (-(2**53), 2**53)}).power(False)


@pytest.mark.parametrize("value", ["9" * 20, "[" * 3000, "9" * 5000])
def test_an_option_on_the_command_line(capsys, value):
    assert execute(["run", "examples/xy-table.toml", "--for", value]) == 2
    assert execute(["run", "if1", "none.if1", "--option", f"X.limits=[{value}, 5]"]) == 2
    assert all(len(line) < 400 for line in capsys.readouterr().err.splitlines())


@pytest.mark.parametrize(("model", "contents"), [
    ("if2", b"{"), ("if2", b"[" * 9999), ("if2", b'{"frame": ' + b"9" * 5000 + b"}"), ("smartmotor", b"\xff"),
    ("smartmotor", b'{"version": 1, "program": 5}'), ("smartmotor", b"9" * 5000)])  # fmt: skip
def test_a_memory_that_is_none(tmp_path, model, contents):
    (tmp_path / f"{model}.json").write_bytes(contents)
    with pytest.raises(UsageError, match=r"is not a memory file of .*: delete ") as told:
        Bench().add(model, state=tmp_path)
    assert len(str(told.value)) < 400


def test_a_program_error_keeps_its_place():
    error = ProgramError("x" * 5000, file="a.talk", line=3, column=2)
    assert str(error) == f"a.talk:3:2: {'x' * 60}…" and json.loads(json.dumps(error.message)) == f"{'x' * 60}…"
