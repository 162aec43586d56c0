"""On a full disk each command that writes a file ends with exit code 1 and one line; old contents are kept."""

import io
import os
import signal
import sys
from contextlib import contextmanager, redirect_stderr
from pathlib import Path
from types import SimpleNamespace

import pytest

from axistwin import Bench
from axistwin.cli.serving import learn, probe
from axistwin.core.errors import AxistwinError
from axistwin.real.hosts.virtual_time import VirtualEnd
from axistwin.real.probing.rescue.finding import Found
from axistwin.real.probing.rescue.saving import rescue

from ..command import ended, run, running, serving
from ..integrations.conftest import free_port
from ..sweeps.scenes import motor, stepper

resource = pytest.importorskip("resource", reason="this system has no limit of the size of a file")


@contextmanager
def full_after(size):
    """Let each file become no larger than this, as on a disk that is full: writing fails, opening does not."""
    before, bytecode = resource.getrlimit(resource.RLIMIT_FSIZE), sys.dont_write_bytecode
    sys.dont_write_bytecode = True  # it would be incomplete
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        sys.dont_write_bytecode = bytecode


@pytest.fixture
def files(tmp_path, monkeypatch):
    """Make the files that the commands read, and change to their folder."""
    monkeypatch.chdir(tmp_path)
    Path("a.if1").write_text("X100@1000$\n")
    Path("wrong.if1").write_text("x100@1000$\n")
    stepper(tmp_path)
    run("run", "if1", "a.if1", "--trace", "a.csv")
    Path("b.csv").write_text(Path("a.csv").read_text().replace(",1", ",0"))
    return tmp_path


SWEEP = ("sweep", "scene.toml", "--vary", "seed=1..2", "--for", "0.01", "--workers", "0")
TUNE = ("tune", "scene.toml", "--change", "table.X.limits.1=5000..6000", "--minimise", "final table.X.position",
        "--trials", "1", "--for", "0.01", "--workers", "0")  # fmt: skip


@pytest.mark.parametrize("words", [
    *(("run", "if1", "a.if1", "--trace", f"out.{kind}") for kind in ("csv", "vcd", "sigrok.vcd", "parquet")),
    ("run", "if1", "a.if1", "--plot", "out.svg"),
    ("run", "if1", "a.if1", "--plot", "out.png"),
    ("run", "if1", "a.if1", "--report", "out.html"),
    ("run", "if2", "a.if1", "--state", "out"),
    ("plot", "a.csv", "-o", "out.svg"),
    ("diff", "a.csv", "b.csv", "--plot", "out.png"),
    (*SWEEP, "--out", "out.parquet"),
    (*TUNE, "--out", "out.db"),
    ("fmu", "scene.toml", "-o", "out.fmu"),
    ("new", "out", "--yes"),
    ("examples", "drill", "out"),
    ("docs", "--out", "out"),
    ("check", "wrong.if1", "--fix")], ids=lambda words: " ".join(words[:1] + words[-1:]))  # fmt: skip
def test_a_full_disk(files, words):
    for extra in {"fmu": ["pythonfmu3"], "tune": ["optuna"]}.get(words[0], []):
        pytest.importorskip(extra)
    with full_after(0):
        done = run(*words)
    assert (done.code, len(done.err.splitlines())) == (1, 1)
    assert "file too large" in done.err.lower() or "disk I/O error" in done.err
    left = [path for path in files.rglob("*") if ".new" in path.name or path.name.startswith(".")]
    assert [path.name for path in left if not path.name.startswith(".axistwin.")] == []


def test_a_controllers_memory(files, caplog):
    """The first note of the state directory is shorter than the memory."""
    Path("a.if1").write_text("[\n")  # the battery keeps the format and the sequence
    with full_after(100):
        done = run("run", "if2", "a.if1", "--state", "out")
    assert (done.code, caplog.messages[-1]) == (1, "out/if2.json: 1 of 1 writes failed: there is no file")
    assert run("run", "if2", "a.if1", "--state", "out").code == 0


@pytest.mark.parametrize(("option", "name"), [("--plot", "out.svg"), ("--report", "out.html")])
def test_an_old_file_is_kept(files, option, name):
    Path(name).write_text("old")
    with full_after(1000):
        assert run("run", "if1", "a.if1", option, name).code == 1
    assert Path(name).read_text() == "old"
    Path("link").mkdir()
    Path("link", name).symlink_to(files / name)
    assert run("run", "if1", "a.if1", option, f"link/{name}").code == 0 and Path("link", name).is_symlink()
    assert len(Path(name).read_text()) > 1000


def test_a_limit_of_the_trace_is_no_error(files):
    done = run("run", "if1", "a.if1", "--trace", "out.csv", "--trace-limit", "600")
    assert (done.code, "has reached the size limit of 600 bytes" in done.err) == (0, True)


def test_the_report_of_a_probe(files, monkeypatch):
    found = SimpleNamespace(as_dict=dict)
    monkeypatch.setattr(probe, "open_end", lambda *_: SimpleNamespace(close=lambda: None))
    monkeypatch.setattr(probe, "compare", lambda *_: found)
    with full_after(0):
        done = run("probe", "tcp://127.0.0.1:9", "--model", "if1", "--report", "out.json")
    assert (done.code, done.err) == (1, "axistwin: out.json cannot be written: file too large\n")


@pytest.mark.parametrize(("size", "what"), [
    (20, ("if2", "--trace", "out.csv")), (0, ("if2", "--record", "out.talk")), (100, ("motor.toml",))])  # fmt: skip
def test_a_server(files, size, what):
    """A server goes on without its file, and tells the end in its exit code."""
    motor(files)
    Path("motor.toml").write_text(Path("motor.toml").read_text() + 'state = "out"\n')
    with full_after(size), serving(
        *what, "--tcp", "127.0.0.1:0", env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
    ) as (program, _):  # fmt: skip
        code, messages = ended(program, signal.SIGTERM)
    assert (code, "file too large" in messages.lower(), "Traceback" in messages) == (1, True, False)


@pytest.mark.slow
@pytest.mark.parametrize(("command", "extra"), [("ioc", "caproto"), ("opcua", "asyncua")])
def test_a_server_of_axes(files, command, extra):
    pytest.importorskip(extra, reason=f"{extra} is not installed")
    motor(files)
    Path("motor.toml").write_text(Path("motor.toml").read_text() + 'state = "out"\n')
    words = ("--port", free_port(), "--json", *(("--prefix", "LAB:") if command == "ioc" else ()))
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
    with full_after(100), running(command, "motor.toml", *words, env=environment) as program:
        ready = program.stdout.readline()
        code, messages = ended(program, signal.SIGTERM)
    assert ready and (code, len(messages.splitlines())) == (1, 2)
    assert all(line.startswith("axistwin: out/knife.json") for line in messages.splitlines())


def test_a_rescue(files):
    bench = Bench()
    end = VirtualEnd(bench, bench.add("1811"))
    bench.run(1.5)
    message = r"^cannot write to out \(file too large\): choose another directory$"
    with full_after(0), pytest.raises(AxistwinError, match=message) as told:
        rescue(end, Found("1811", None), Path("out"))
    assert type(told.value) is AxistwinError
    assert ([path.name for path in files.glob(".*")], Path("out").exists()) == ([], False)


def test_the_progress_of_a_learner(files):
    """The old progress is kept."""
    progress, told = Path("lessons.json"), io.StringIO()
    assert learn._save(progress, {"if1": 1}) == 0
    with full_after(0), redirect_stderr(told):
        assert learn._save(progress, {"if1": 2}) == 1
    assert told.getvalue() == "axistwin: cannot save your progress in lessons.json: file too large\n"
    assert learn._load(progress) == {"if1": 1}
