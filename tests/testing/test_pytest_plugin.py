"""The pytest plug-in: tests of a host run in a second pytest inside this one."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

SOURCES = Path(__file__).resolve().parents[2] / "src"
HOST_TIMEOUT_S = 300
HOST = """
import pytest, serial

def ask(host, text):
    host.write(text)
    return host.read_until(b"\\r")

@pytest.fixture
def host(axistwin_port):
    with serial.serial_for_url(axistwin_port, timeout=300) as host:
        yield host
"""
WORDS = (
    "-p", "axistwin.testing.pytest_plugin", "-p", "no:cacheprovider", "--basetemp=out", "--strict-markers",
    "--import-mode=importlib", "--capture=no", "-W", "error",
)  # fmt: skip
CELL = """
[[controller]]
model = "if1"
name = "left"
[[controller]]
model = "if2"
name = "right"
"""


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    (tmp_path / "cell.toml").write_text(CELL)

    def run(tests, *options):
        (tmp_path / "test_it.py").write_text(HOST + tests)
        code = pytest.main([*WORDS, *options, f"--rootdir={tmp_path}", str(tmp_path)])
        return code, capsys.readouterr().out

    yield run
    sys.modules.pop("test_it")


def test_a_model_with_options_a_port_and_the_clock(run, tmp_path):
    code, told = run('''
@pytest.mark.axistwin("if1", self_test_s=0.2)
def test_it(host, axistwin_clock, axistwin_twin):
    axistwin_clock.advance(0.3)
    assert axistwin_twin.call(ask, host, b"(") == b"U\\r"
    assert axistwin_clock.run_until(lambda: axistwin_clock.seconds >= 1, timeout=2)
''')  # fmt: skip
    assert code == 0, told
    assert not list((tmp_path / "out").rglob("axistwin.*"))


def test_scenes_by_path_and_as_a_dict(run):
    code, told = run('''
@pytest.mark.axistwin(scene="cell.toml")
def test_path(axistwin_twin):
    assert list(axistwin_twin.ports) == ["left", "right"]

@pytest.mark.axistwin(scene={"controller": [{"model": "1811"}]}, speed="max")
def test_dict(axistwin_port):
    assert axistwin_port.startswith("bus://")
''')  # fmt: skip
    assert code == 0, told


def test_the_recording_of_a_failed_test_is_kept(run, tmp_path):
    code, told = run('''
@pytest.mark.axistwin("if1")
def test_it(host, axistwin_twin):
    axistwin_twin.advance(1.5)
    assert axistwin_twin.call(ask, host, b"(") == b"V\\r"
''')  # fmt: skip
    talk, trace = Path("out", "test_it0", "axistwin.talk"), Path("out", "test_it0", "axistwin.csv")
    assert code == 1 and f"kept: {talk}\nkept: {trace}\n" in told
    assert "; model: if1\n! flow dtr\n+1.5\n> (\n< U\\r\n" in (tmp_path / talk).read_text()
    assert "if1.led" in (tmp_path / trace).read_text()


@pytest.mark.slow
def test_a_page_for_each_test_with_its_verdict(run, tmp_path):
    code, told = run(
        """
@pytest.mark.axistwin("if1", self_test_s=0.2)
@pytest.mark.parametrize("answer", ["U", "V<"])
def test_it(host, axistwin_clock, axistwin_twin, answer):
    axistwin_clock.advance(0.3)
    assert axistwin_twin.call(ask, host, b"(") == answer.encode() + b"\\r"
""",
        "--axistwin-report=pages",
    )
    assert code == 1, told
    good, bad = (tmp_path / "pages" / f"test-it.py-test-it-{name}.html" for name in ("U", "V"))
    assert sorted((tmp_path / "pages").iterdir()) == [good, bad]
    assert '<p class="verdict good">passed</p>' in good.read_text()
    assert '<p class="verdict bad">failed</p>' in bad.read_text() and "AssertionError" in bad.read_text()
    for part in ("<svg", "&gt; (\n&lt; U\\r", "<th>controller if1</th><td>if1 {&quot;self_test_s&quot;: 0.2}</td>"):
        assert part in bad.read_text()
    assert not list((tmp_path / "out" / "test_it_U_0").rglob("axistwin.*"))


def test_an_unused_plug_in_imports_nothing_else(tmp_path):
    (tmp_path / "test_it.py").write_text("""
def test_it():
    import sys
    loaded = {name for name in sys.modules if name.partition(".")[0] in ("axistwin", "simpy", "pydantic", "click")}
    own = {"axistwin", "axistwin.testing", "axistwin.testing.pytest_plugin"}
    own |= {"axistwin.core", "axistwin.core.lazy", "axistwin.core.version"}
    assert loaded - {"simpy"} == own
""")
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST")}
    environment |= {"PYTHONPATH": str(SOURCES), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    words = [sys.executable, "-m", "pytest", *WORDS]
    done = subprocess.run(words, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=HOST_TIMEOUT_S)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_report_names_only_existing_files(run, tmp_path):
    code, told = run('''
@pytest.fixture
def broken(axistwin_twin):
    yield
    raise RuntimeError("afterwards")

@pytest.mark.axistwin("if1", colour="red")
def test_setup(axistwin_twin):
    pass

@pytest.mark.axistwin("if1")
def test_teardown(broken):
    pass
''')  # fmt: skip
    named = [tmp_path / line.removeprefix("kept: ") for line in told.splitlines() if line.startswith("kept: ")]
    assert code == 1
    assert [path.parent.name for path in named] == ["test_teardown0", "test_teardown0"]
    assert all(path.exists() for path in named)


@pytest.mark.parametrize(("marker", "message"), [
    ("", 'expected a model or a scene, e.g. @pytest.mark.axistwin("if1")'),
    ('@pytest.mark.axistwin("if1", "if2")\n',
     "invalid marker `axistwin` of the test test_it.py::test_it: expected a model or a scene"),
    ('@pytest.mark.axistwin(scene={"controller": [{"model": "if9"}]})\n', "no model 'if9'")
], ids=["no marker", "two models", "an error in the scene"])  # fmt: skip
def test_an_invalid_marker_is_an_error(run, marker, message):
    code, told = run(f"{marker}def test_it(axistwin_port): pass")
    assert code == 1 and message in told


@pytest.mark.slow
def test_the_report_says_that_virtual_time_stood_still_and_why_nothing_moves(run):
    code, told = run("""
@pytest.mark.axistwin("if1")
def test_a_host_called_directly(axistwin_port, axistwin_twin):
    axistwin_twin.advance(1.5)
    with serial.serial_for_url(axistwin_port, timeout=0) as host:
        host.write(b"(")
        assert host.read(2) == b"U\\r"

@pytest.mark.axistwin("smartmotor")
def test_a_motor_without_switches(axistwin_port, axistwin_twin):
    axistwin_twin.advance(1)
    with serial.serial_for_url(axistwin_port, timeout=0) as host:
        axistwin_twin.call(host.write, b"A=100 V=100000 P=4000 G ")
        axistwin_twin.advance(1)
        assert axistwin_twin.bench["smartmotor"].axes["shaft"].position == 4000
""")
    assert code == 1
    assert told.count("virtual time has stood still since the host's last data") == 1
    assert "twin.call(host.read, 2)" in told
    assert "smartmotor: in a limit fault, as pins C and D are not held low" in told
