"""A small instance of `benchmarks/robustness/options.py`, and files that once ended in a traceback or never ended."""

import os
from pathlib import Path

import pytest

from axistwin import Bench, Scene, tracing
from axistwin.controllers.smartmotor.kernel.core import Engine
from axistwin.core.errors import TraceError
from axistwin.records.traces.reading import read

from ..campaigns import campaign
from ..command import refused, run


@pytest.mark.parametrize("what", ["options", "scenes"])
def test_three_hundred_cases(tmp_path, monkeypatch, what):
    monkeypatch.setattr(Engine, "_compiled", lambda engine: None)  # a compilation takes longer than the time limit
    monkeypatch.chdir(tmp_path)
    cases = campaign("options").Campaign(1811, tmp_path)
    cases.run(300, what)
    assert cases.found == [] and cases.ends[f"{what} used"] > 15
    assert cases.ends[f"{what} refused"] > 100


CHAIN = """
[[controller]]
model = "if1"
host = "go.if1"
[[chain]]
motors = ["nobody"]
"""


@pytest.mark.parametrize("command", ["check", "run"])
def test_a_chain_of_an_unknown_motor_beside_a_host(tmp_path, command):
    (tmp_path / "go.if1").write_text("X10$\n")
    (tmp_path / "scene.toml").write_text(CHAIN)
    done = run(command, tmp_path / "scene.toml")
    assert (done.code, "scene.toml:6:" in done.out + done.err) == (1, True)
    assert "the scene has no controller 'nobody': expected one of if1" in done.out + done.err
    assert Scene.load(tmp_path / "scene.toml").models.keys() == {"if1", "if1.rs485"}


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no pipes with names")
@pytest.mark.parametrize("words", [
    ("run", "smartmotor", "pipe.sms"), ("run", "if1", "pipe.if1"), ("run", "pipe.toml"), ("run", "scene.toml"),
    ("check", "pipe.sms"), ("plot", "pipe.csv"), ("diff", "pipe.vcd", "pipe.parquet"), ("sweep", "pipe.parquet"),
    ("sweep", "study.toml", "--out", "a.parquet")], ids=" ".join)  # fmt: skip
def test_a_pipe_in_place_of_a_file_is_not_read(tmp_path, monkeypatch, words):
    """Reading would never end."""
    monkeypatch.chdir(tmp_path)
    for kind in ("sms", "if1", "toml", "csv", "vcd", "parquet"):
        os.mkfifo(f"pipe.{kind}")
    Path("scene.toml").write_text('[[controller]]\nmodel = "smartmotor"\nprogram = "pipe.sms"\n')
    Path("study.toml").write_text('scene = "pipe.toml"\n[vary]\nseed = "1..2"\n')
    code, told = refused(*words)
    assert (code in (1, 2), len(told.splitlines()), "pipe." in told) == (True, 1, True)


@pytest.mark.parametrize("words", [
    ("run", "if1", "a.if1", "--trace", "{}.csv"), ("plot", "{}.csv"), ("diff", "{}.csv", "{}.csv"),
    ("sweep", "{}.parquet"), ("check", "scene.toml"), ("new", "{}", "--yes"), ("examples", "drill", "{}"),
    ("rescue", "tcp://127.0.0.1:1", "--model", "if1", "--out", "{}")], ids=lambda words: words[0])  # fmt: skip
def test_a_name_that_is_too_long(tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    Path("a.if1").write_text("X10$\n")
    Path("scene.toml").write_text(f'[[controller]]\nmodel = "smartmotor"\nprogram = "{"x" * 300}.sms"\n')
    done = run(*(word.format("x" * 300) for word in words))
    assert (done.code in (1, 2), "file name too long" in (done.out + done.err).lower()) == (True, True)


def test_a_column_of_lists_in_a_parquet_file(tmp_path):
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    path = tmp_path / "a.parquet"
    bench = Bench()
    bench.add("if1")
    with tracing(bench, path, ("default",)):
        bench.run(1.2)
    table = pq.read_table(path)
    for name, kind in (
        ("time_ns", pa.int64()),
        ("signal", pa.string()),
        ("integer", pa.int64()),
        ("text", pa.string()),
    ):
        for of in (pa.list_(kind), pa.list_(kind, 1), pa.large_list(kind)):
            column = pa.array([[value] for value in table[name].cast(kind).to_pylist()], of)
            pq.write_table(table.set_column(table.column_names.index(name), name, column), tmp_path / "b.parquet")
            with pytest.raises(TraceError, match=f"expected exactly one column {name} of type .*, found .*list"):
                read(tmp_path / "b.parquet")
