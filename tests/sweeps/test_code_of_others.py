"""Checks, editors, uploads and links read files of others, and run no code of others."""

import sys

import pytest

from axistwin import Bench
from axistwin.core.errors import AxistwinError, UsageError
from axistwin.scenes.diagnostics.scenes import diagnose_scene
from axistwin.scenes.sessions.session import Session
from axistwin.sweeps import Sweep
from axistwin.ui.playground.link import Shared, encode
from axistwin.ui.playground.playground import Playground

from ..command import run
from .scenes import stepper

STUDY = """
scene = "scene.toml"
host = "code_of_others:host"
[vary]
"table.X.load.torque" = [0.1, 0.9]
[measure]
lost = "final table.X.lost"
"""


@pytest.fixture
def study(tmp_path, monkeypatch):
    """Return a sweep file whose host is a module that would leave a file behind."""
    (tmp_path / "code_of_others.py").write_text(
        f"import pathlib\npathlib.Path({str(tmp_path / 'was-here')!r}).touch()\ndef host(bench):\n    pass\n"
    )
    stepper(tmp_path)
    (tmp_path / "study.toml").write_text(STUDY)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)
    yield tmp_path / "study.toml"
    sys.modules.pop("code_of_others", None)


def was_here(study):
    return (study.parent / "was-here").exists() or "code_of_others" in sys.modules


def test_a_check_imports_no_host(study):
    done = run("check", study)
    assert (done.code, done.err) == (0, "axistwin: study.toml: nothing wrong\n".replace("study.toml", str(study)))
    Sweep(study.parent / "scene.toml", host="code_of_others:host").vary("seed", "1").check()
    assert not was_here(study)


def test_a_sweep_imports_its_host(study):
    pytest.importorskip("pyarrow", reason="the extra [traces] is not installed")
    assert run("sweep", study, "--workers", 0, "--out", study.with_name("a.parquet")).code == 0 and was_here(study)


def test_a_host_may_have_the_name_of_a_package_of_ours(study):
    pytest.importorskip("pyarrow", reason="the extra [traces] is not installed")
    study.with_name("code_of_others.py").rename(study.with_name("plant.py"))
    study.write_text(STUDY.replace("code_of_others", "plant"))
    done = run("sweep", study, "--workers", 1, "--out", study.with_name("a.parquet"))
    assert (done.code, was_here(study)) == (0, True), done


def test_a_check_still_finds_a_host_that_is_no_name_of_a_function(study):
    study.write_text(STUDY.replace("code_of_others:host", "os.system('true')"))
    done = run("check", study)
    assert (done.code, "study.toml:3:1: error: invalid key host:" in done.out) == (1, True)
    assert not was_here(study)


def test_a_language_server_imports_no_host(study):
    diagnose_scene(study, STUDY)
    diagnose_scene(study, f'{STUDY}[[controller]]\nmodel = "if1"\n')
    checks = pytest.importorskip("axistwin.ui.editor.checks", reason="the extra [lsp] is not installed")
    document = pytest.importorskip("pygls.workspace").TextDocument(study.as_uri(), STUDY)
    assert checks.diagnose(checks.Text(document)) == [] and not was_here(study)


def test_an_upload_imports_no_host(study):
    bench = Bench()
    bench.add("if1")
    session = Session(lambda: bench)
    for name in ("study.toml", "code_of_others.py"):
        with pytest.raises(AxistwinError, match=r"expected SmartMotor source \(.sms\)"):
            session.load("if1", name, study.with_name(name).read_text())
    assert not was_here(study)


def test_a_link_of_the_playground_imports_no_host(study, tmp_path):
    playground = Playground(tmp_path / "playground")
    files = {path.name: path.read_text() for path in tmp_path.iterdir() if path.is_file()}
    assert playground.open_link(encode(Shared(files, 10**9)))["asks"] == ["code_of_others.py"]
    del files["code_of_others.py"]
    playground.open_link(encode(Shared(files, 10**9)))
    playground.advance(10**9, 9)
    with pytest.raises(AxistwinError):
        playground.open_link(encode(Shared({**files, "scene.toml": STUDY}, 0)))
    assert not was_here(study)


@pytest.mark.parametrize(("source", "reason"), [
    ("def other(): pass", "has no attribute"), ("host = 5", "not a function"), ("def host(", "SyntaxError"),
    ("raise KeyError('x')", "KeyError: 'x'")])  # fmt: skip
def test_a_host_that_cannot_be_imported_is_one_line_before_the_first_run(study, source, reason):
    pytest.importorskip("pyarrow", reason="the extra [traces] is not installed")
    (study.parent / "code_of_others.py").write_text(source)
    with pytest.raises(UsageError, match=r"cannot import the Python function 'code_of_others:host' \(") as told:
        Sweep(study.parent / "scene.toml", host="code_of_others:host").vary("seed", "1").run(workers=0)
    assert reason in str(told.value)
