"""One device of somebody else in all that axistwin does; where something cannot work, one line says so."""

import asyncio
import io
import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path
from shutil import copyfile

import pytest
import serial

import axistwin
from axistwin import Bench, Scene, Session
from axistwin.bench.models import product
from axistwin.controllers import registry
from axistwin.devices import load
from axistwin.drivers import RefusedError, connect
from axistwin.scenes.sessions.condition import condition_of
from axistwin.sim.pins import connect as connect_pins
from axistwin.ui.editor.scene import Scenes
from axistwin.ui.editor.talk import Conversations
from axistwin.ui.panel.views.front import front
from axistwin.ui.playground.playground import Playground

from ..benches import bench_of
from ..command import Finished, ended, listening, refused, run, running
from ..editor.lsp_client import Client
from ..integrations.test_motor_record import run as run_record
from ..panel.showing import driver_of, show_to, stage
from ..sessions.driving import drive
from .conftest import names
from .stages import said

__all__ = ["names"]
HERE = Path(__file__).parent
TALK = """; model: stage
> 1PA500\\r
+1
> 1TP\\r
< 500\\r
= 1.position 500
> WAIT\\r
< OK\\r
"""
SCENE = """title = "A stage"

[[controller]]
model = "stage"
name = "table"
options = { delay = 0.1 }
axes.1.limits = [-1000, 1000]
axes.1.units = { per = 100, of = "mm" }
axes.2.encoder = { counts_per_rev = 4000, pulses_per_rev = 400 }
host = "move.talk"

[[wire]]
from = "table.lamp"
to = "table.start"
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, names, monkeypatch):
    """Be in a folder with the file of a device, a conversation and a scene."""
    monkeypatch.chdir(tmp_path)
    copyfile(HERE / "stages.py", "stage.py")
    Path("move.talk").write_text(TALK, encoding="utf-8")
    Path("scene.toml").write_text(SCENE, encoding="utf-8")
    return tmp_path


def axistwin_(*arguments: object, typed: str = "", code: int = 0) -> Finished:
    done = run("--device", "stage.py", *arguments, typed=typed)
    assert done.code == code, done
    return done


# Programs and scenes


def test_run_check_and_commands():
    assert "1        0  500     500" in axistwin_("run", "stage", "move.talk").out
    moves = json.loads(axistwin_("run", "scene.toml", "--json").out)["moves"]
    assert [(move["axis"], move["from"], move["to"]) for move in moves] == [("1", 0, 500)]
    assert axistwin_("check", "stage", "move.talk").err == "axistwin: move.talk: nothing wrong\n"
    listed = json.loads(axistwin_("commands", "stage", "--json").out)["commands"]
    assert [(each["syntax"], each["chapter"]) for each in listed][:2] == [
        ("<axis>PA<position>", "Absolute move"), ("<axis>ST", "Stop"),
    ]  # fmt: skip


def test_check_names_line_column_and_section():
    Path("wrong.talk").write_text("; model: stage\n> 1PA500\\r\n> 1PA900000\\r\n> 1TQ\\r\n", encoding="utf-8")
    assert axistwin_("check", "wrong.talk", code=1).out.splitlines() == [
        (
            "wrong.talk:3:6: error: position 900000: expected position -100000…100000 steps "
            "(manual: Absolute move) [DV102]"
        ),
        "wrong.talk:4:3: error: unknown command '1TQ': did you mean '1TP'? (manual: Commands) [DV101]",
    ]
    Path("scene.toml").write_text(SCENE.replace("move.talk", "wrong.talk"), encoding="utf-8")
    assert "scene.toml → wrong.talk:3:6: error: position 900000" in axistwin_("check", "scene.toml", code=1).out


def test_a_difference_is_reported_with_its_line():
    Path("move.talk").write_text(TALK.replace("< 500", "< 501"), encoding="utf-8")
    done = axistwin_("run", "stage", "move.talk", code=1)
    assert "move.talk:5: at 1.0" in done.err and "the reply is different" in done.err


def test_options_out_of_range_name_what_was_expected():
    done = axistwin_("run", "stage", "move.talk", "--option", "delay=9", code=2)
    assert done.err == "axistwin: delay=9: expected a number from 0 to 5\n"


def test_traces_plots_reports_and_diff():
    axistwin_("run", "scene.toml", "--trace", "old.csv", "--plot", "old.png", "--report", "old.html")
    assert Path("old.png").stat().st_size > 1000 and "A stage" in Path("old.html").read_text(encoding="utf-8")
    assert "# signal: table.1.pulses integer\n" in Path("old.csv").read_text(encoding="utf-8")
    axistwin_("plot", "old.csv", "--out", "again.png")
    Path("move.talk").write_text(TALK.replace("500", "480"), encoding="utf-8")
    axistwin_("run", "scene.toml", "--trace", "new.csv")
    assert "no difference" in axistwin_("diff", "old.csv", "old.csv").out
    assert "table.host_says" in axistwin_("diff", "old.csv", "new.csv", code=1).out


def test_all_kinds_of_traces_hold_the_same():
    pytest.importorskip("pyarrow", reason="the extra [traces] is not installed")
    axistwin_("run", "scene.toml", "--trace", "one.vcd")
    axistwin_("run", "scene.toml", "--trace", "two.parquet")
    assert axistwin_("diff", "one.vcd", "two.parquet").out.startswith("no difference in 13 signals")


def test_devices_of_others_and_ours_are_on_one_bench():
    """The lamp of the stage, which is on for 0.2 s, starts an IF1 whose move waits for input 1."""
    load("stage.py")
    bench = Bench()
    stage, if1, module = bench.add("stage", line="instant"), bench.add("if1", line="instant"), bench.add("module")
    connect_pins(stage.pins["lamp"], if1.pins["input1"])
    bench.run(1.5)
    for text in (b"(", b"U61\r", b"H1X40$\r"):
        if1.serial.write(text)
        bench.run(1.5)
    assert if1.axes["X"].position == 0
    stage.serial.write(b"WAIT\r")
    module.serial.write(said(4, 0, "2", -7))
    bench.run(1.0)
    assert (if1.axes["X"].position, module.axes["2"].position) == (40, -7)


def test_registers_are_traced():
    """The move of 500 steps begins after eight characters at 9600 baud, and takes 500/2000 + 2000/20,000 s."""
    axistwin_("run", "stage", "move.talk", "--trace", "moves.csv", "--signals", "default,stage.status")
    rows = [row.split(",") for row in Path("moves.csv").read_text(encoding="utf-8").splitlines()]
    found = [(int(row[0]), row[2]) for row in rows if row[1:2] == ["stage.status"]]
    begin_ns = found[1][0]
    assert found == [(0, "0"), (begin_ns, "1"), (begin_ns + 350_000_000, "0")]


# Many runs


@pytest.mark.slow
def test_sweep_and_tune():
    pytest.importorskip("pyarrow", reason="the extra [traces] is not installed")
    from pyarrow.parquet import read_table

    axistwin_("sweep", "scene.toml", "--vary", "table.1.limits.1=[300,1000]", "--vary", "table.delay=[0.1,0.3]",
              "--measure", "end:final table.1.position", "--measure", "lamp:from table.lamp rises to table.lamp falls",
              "--for", 3, "--workers", 2, "--out", "runs.parquet")  # fmt: skip
    rows = read_table("runs.parquet").to_pylist()
    found = {(row["table.1.limits.1"], row["table.delay"]): (row["end"], row["lamp"]) for row in rows}
    assert {key: end for key, (end, _) in found.items()} == {
        (300, 0.1): 301, (300, 0.3): 301, (1000, 0.1): 500, (1000, 0.3): 500,
    }  # fmt: skip
    assert found[1000, 0.3][1] == 0.3
    pytest.importorskip("optuna", reason="the extra [tune] is not installed")
    tune = ("tune", "scene.toml", "--change", "table.1.limits.1=100..600", "--minimise", "final table.1.position")
    assert "best" in axistwin_(*tune, "--trials", 3, "--for", 3, "--out", "found.db").out


def test_an_fmu_has_the_device_inside():
    pytest.importorskip("pythonfmu3", reason="the extra [fmu] is not installed")
    axistwin_("fmu", "scene.toml", "--out", "scene.fmu")
    import zipfile

    with zipfile.ZipFile("scene.fmu") as archive:
        text = archive.read("modelDescription.xml").decode()
        assert """name="table.'1'.position\"""" in text
        assert "class Stage(Device)" in archive.read("resources/axistwin.json").decode()


# Ports and hosts


def test_serve_term_record_and_replay():
    with running("--device", "stage.py", "serve", "stage", "--speed", "max") as program:
        name, url = listening(program)
        assert name == "stage" and "< 0<CR>" in axistwin_("term", f"tcp://{url.address}", typed="1TP\n").out
    done = axistwin_("term", "stage", "--speed", "max", typed="1PA300\n:axes\n1TP\n:next\n")
    assert "1  300  at rest" in done.out and "< 300<CR>" in done.out and "type  <axis>TP" in done.out
    assert "3 acts of the controller, none different in bytes" in axistwin_("replay", "move.talk").out


@pytest.mark.slow
def test_what_is_recorded_is_replayed():
    with running("--device", "stage.py", "serve", "stage") as program:
        _, url = listening(program)
        words = ("record", "--serial", f"socket://{url.address}", "--model", "stage", "-o", "real.talk")
        with running("--device", "stage.py", *words) as recorder:
            _, relay = listening(recorder)
            with serial.serial_for_url(f"socket://{relay.address}", timeout=30) as host:
                host.write(b"1PA50\r2TP\r")
                assert host.read_until(b"\r") == b"0\r"
            assert ended(recorder)[0] == 0
    assert "; model: stage" in Path("real.talk").read_text(encoding="utf-8")
    assert "1 act of the controller" in axistwin_("replay", "real.talk", "--patience", 60).out


def test_typed_lines_end_as_the_model_wants_them_and_datagrams_are_typed_in_hex():
    mdrive = HERE.parents[1] / "examples" / "devices" / "mdrive.py"
    assert "< XPR P<CR><LF>" in run("--device", mdrive, "term", "mdrive", "--speed", "max", typed="XPR P\n").out
    asked = "".join(f"\\x{byte:02X}" for byte in said(6, 8, "1"))
    done = axistwin_("term", "module", "--speed", "max", typed=f"{asked}\n")
    assert done.out == f"> {asked}\n< <02><01>d<06><NUL><NUL><NUL><01>n\n"  # status 100, command 6, value 1
    with running("--device", "stage.py", "serve", "module", "--show-hosts", "--tcp", "127.0.0.1:0") as program:
        listening(program)
        shown = [program.stdout.readline() for _ in range(5)]
    assert any("read_termination=None, write_termination=None" in line for line in shown)
    assert any('asynOctetSetOutputEos("module", 0, "")' in line for line in shown)


def test_serve_for_tests_and_a_driver():
    (stage, _) = load("stage.py")
    for what in ("stage", stage, product("stage")):
        with axistwin.serve(what, speed="manual", record="said.talk") as twin:

            def host(twin=twin) -> float:
                with connect(twin.ports["stage"], stage, timeout=5.0) as controller:
                    controller.axes["2"].move_to(-40)
                    return controller.axes["2"].wait(20).position

            assert twin.call(host) == -40 == twin.bench["stage"].axes["2"].position
        assert "; model: stage" in Path("said.talk").read_text(encoding="utf-8")


def test_epics_and_opcua():
    """Both read the axes by the driver, which needs no more than the device's texts."""
    from axistwin.real.integrations import of_scene

    load("stage.py")

    async def positions() -> list[float]:
        async with await of_scene(Scene.load("scene.toml").build(served=True), {}, speed=None) as machine:
            (station,) = machine.stations
            await station.poll()
            return [axis.status.position for axis in station.axes.values() if axis.status is not None]

    assert asyncio.run(positions())[1] == 0
    written = (HERE / "stages.py").read_text(encoding="utf-8")
    Path("none.py").write_text(written.replace("driver = Text", "other = Text").replace('"stage", "Ex', '"bare", "Ex')
                               .replace('"module", ', '"bare2", '), encoding="utf-8")  # fmt: skip
    Path("bare.toml").write_text('[[controller]]\nmodel = "bare"\n', encoding="utf-8")
    for library, command in (
        ("caproto", ("ioc", "bare.toml", "--prefix", "LAB:")),
        ("asyncua", ("opcua", "bare.toml")),
    ):
        pytest.importorskip(library, reason="the extras [epics] and [opcua] are not installed")
        code, words = refused("--device", "none.py", *command)
        assert (code, words.count("\n")) == (2, 1)
        assert "bare does not say how a host moves it: expected a driver in its class, e.g. driver = Text" in words


def test_a_motor_record_moves_the_axis_and_says_what_its_driver_lacks():
    load("stage.py")

    async def session(lab) -> None:
        motor = lab.records["1"]
        await motor.put("VAL", 3.25)
        assert (motor.values["RBV"], motor.values["DMOV"]) == (3.25, 1)
        assert lab.bench["stage"].axes["1"].position == 325
        with pytest.raises(RefusedError, match="has no `run`: expected it in TextDriver"):
            await motor.axis.move_at(100.0)
        await motor.put("VAL", -1)
        assert lab.bench["stage"].axes["1"].position == -100

    run_record(session, "stage", **{"1": {"units": {"per": 100, "of": "mm"}}})


def test_a_scan_with_ophyd():
    ophyd = pytest.importorskip("axistwin.ophyd", reason="the extra [ophyd] is not installed")
    from bluesky import RunEngine
    from bluesky.plans import scan

    load("stage.py")
    bench, engine, found = Bench(), RunEngine(), []
    engine.subscribe(lambda name, document: found.append(document["data"]["m"]) if name == "event" else None)
    bench.add("stage")
    motor = ophyd.Controller.inside(bench, "stage").motor("1", name="m", counts_per_unit=100, unit="mm")
    asyncio.run_coroutine_threadsafe(motor.connect(), engine.loop).result(10)
    engine(scan([], motor, 0, 2, 3))
    assert found == [0, 1, 2] and bench["stage"].axes["1"].position == 200
    assert list(ophyd.Controller("socket://127.0.0.1:1", "stage").driver.axes) == ["1", "2"]


@pytest.mark.slow
def test_the_pytest_plug_in(tmp_path):
    Path("test_host.py").write_text(
        "import pytest, serial\n"
        "from axistwin.devices import load\n\n"
        "load('stage.py')\n\n"
        "@pytest.mark.axistwin('stage', delay=0.1)\n"
        "def test_host(axistwin_port, axistwin_clock):\n"
        "    with serial.serial_for_url(axistwin_port, timeout=5) as host:\n"
        "        host.write(b'1PA5\\r')\n"
        "        axistwin_clock.advance(1)\n"
        "        host.write(b'1TP\\r')\n"
        "        axistwin_clock.advance(1)\n"
        "        assert host.read(2) == b'5\\r'\n",
        encoding="utf-8",
    )
    words = [sys.executable, "-m", "pytest", "-q", "-p", "axistwin.testing.pytest_plugin", "-p", "no:cacheprovider"]
    done = subprocess.run(
        [*words, "test_host.py"], capture_output=True, text=True, check=False, cwd=tmp_path,
        env={**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"},
    )  # fmt: skip
    assert "1 passed" in done.stdout, done.stdout + done.stderr


# Faults, sessions, the panel, the playground, editors


def test_faults_on_lines_pins_and_axes():
    load("stage.py")
    bench = Bench()
    stage = bench.add("stage", **{"1": {"limits": (-1000, 1000)}})
    bench.faults.add("lose", "stage.serial", count=1, at=0.0)
    stage.serial.write(b"1PA50\r2PA50\r")  # the first character is lost, and "PA50" is no command
    bench.run(1)
    assert (stage.axes["1"].position, stage.axes["2"].position) == (0, 50)
    bench.faults.add("stuck", "stage.1+", level="low", at=bench.seconds)
    stage.serial.write(b"1PA50\r1MD\r")
    bench.run(1)
    assert (stage.axes["1"].position, stage.serial.read(), stage.hint) == (
        0, b"1\r", "axis 1 stands at its plus limit: move it in the minus direction",
    )  # fmt: skip
    bench.faults.add("jam", "stage.2", at=bench.seconds)
    stage.serial.write(b"2PA90\r")
    bench.run(1)
    assert (stage.axes["2"].position, stage.axes["2"].pulses) == (50, 90)


def test_a_session_goes_back_and_is_saved():
    load("stage.py")
    scene = Scene.load("scene.toml")
    session = Session(scene.build, scene=scene)
    session.bench.run(0.2)
    then = session.bench["table"].axes["1"].position
    session.bench.run(1.0)
    drive(session.go_to(0.2))
    assert session.bench["table"].axes["1"].position == then == 285
    drive(session.go_to(1.2))
    session.do("table", "power", "off")
    saved = session.save()
    assert 'model = "stage"' in saved["scene.toml"] and not any("class Stage" in text for text in saved.values())


def test_the_state_in_words():
    load("stage.py")
    Path("scene.toml").write_text(SCENE.replace("1000]", "300]"), encoding="utf-8")
    session = Session(Scene.load("scene.toml").build, None)
    session.bench.run(1.0)
    told = condition_of(session, "table")
    assert (told.words, told.next) == ("Stopped: axis 1 at the plus limit", "Move it in the minus direction")


def test_the_front_panel_the_pins_and_the_drawings_on_the_page():
    (kind, _) = load("stage.py")

    def begin(visit) -> None:
        visit.bench["stage"].serial.write(b"1PA500\rWAIT\r")
        visit.run(0.1)
        assert visit.lit("stage-0-status") and not visit.lit("stage-1-status")
        assert visit.lit("stage-lamp-Terminals") and not visit.lit("stage-start-Terminals")
        visit.run(1.0)
        assert not visit.lit("stage-0-status")

    pytest.importorskip("nicegui", reason="the extra [panel] is not installed")
    show_to(driver_of(bench_of("stage")), lambda context: front(context, "stage"), begin)
    stage.close()
    drawn = Playground(Path("drawn"))
    (parts,) = drawn.open_model(kind.model)["controllers"]
    assert parts["drawings"] and [axis["name"] for axis in parts["axes"]] == ["stage.1", "stage.2"]
    assert [(group["title"], len(group["items"])) for group in parts["front"]] == [("status", 2), ("Terminals", 4)]


def test_the_playground_asks_before_it_runs_the_code_of_a_link():
    (kind, _) = load("stage.py")
    made = Playground(Path("made"))
    made.open_model("stage")
    made.send("stage", "1PA40")
    made.advance(10**9, 60)
    link = made.link()
    assert zipfile.ZipFile(io.BytesIO(made.saved())).namelist() == ["scene.toml", "stage.talk", "stage.py"]
    registry.LOADED.clear()
    registry.FILES.clear()
    fresh = Playground(Path("fresh"))
    assert fresh.open_link(link) == {"asks": ["stage.py"]} and registry.LOADED == {}
    opened = fresh.open_link(link, True)
    assert opened["target_ns"] == 10**9 and opened["controllers"][0]["model"] == "stage"
    fresh.advance(10**9, 60)
    assert fresh.state()["controllers"]["stage"]["axes"]["1"]["position"] == 40
    assert fresh.check("stage", ".talk", "> 1TQ\\r")[0]["message"].startswith("unknown command '1TQ'")
    assert kind.model in registry.LOADED


def test_an_editor_knows_the_commands_and_the_model():
    load("stage.py")
    talk = Conversations()
    assert "stage" in [item.label for item in talk.complete(["; model: "], 1, 9)]
    lines = ["; model: stage", "> "]
    assert [item.label for item in talk.complete(lines, 2, 2)][:2] == ["<axis>PA<position>", "<axis>ST"]
    hover = talk.hover(["; model: stage", "> 1PA500\\r"], 2, 4)
    assert hover.text.startswith("**<axis>PA<position>** move absolute") and "Absolute move" in hover.text
    assert "stage" in [item.label for item in Scenes().complete(["[[controller]]", 'model = "'], 2, 9)]


@pytest.mark.slow
def test_the_language_server_checks_programs_and_scenes():
    pytest.importorskip("pygls", reason="the extra [lsp] is not installed")
    with Client("--device", str(Path("stage.py").absolute())) as client:
        (found,) = client.open("file:///bench/move.talk", TALK.replace("1PA500", "1PA900000"))
        assert (found["code"], found["range"]["start"]) == ("DV102", {"line": 1, "character": 5})
        scene = Path("scene.toml").absolute().as_uri()
        assert client.open(scene, SCENE) == []
        (found,) = client.open("file:///bench/other.toml", '[[controller]]\nmodel = "other"\n')
        assert found["code"] == "SC110"


# What cannot work says so in one line


OURS = "expected one of if1, if2, 1810, 1811, smartmotor"
STAND_IN = """
[[controller]]
model = "stage"

[stand-in]
horizon_ms = 1000

[[stand-in.board]]
name = "small"
port = "/dev/null"

[[stand-in.axis]]
axis = "stage.1"
step = "P2"
direction = "P3"
enable = "!P4"
travel = [-10, 10]
"""


def test_the_stand_in_moves_its_axes():
    Path("metal.toml").write_text(STAND_IN, encoding="utf-8")
    assert "  P2       stage.1 step\n" in axistwin_("stand-in", "metal.toml", "--dry-run").out


@pytest.mark.parametrize(("command", "words"), [
    (("learn", "stage"), f"no lessons for 'stage': {OURS}"),
    (("probe", "tcp://127.0.0.1:1", "--model", "stage"),
     f"there are no cases for stage: {OURS}; compare it by `axistwin record` and `axistwin replay`"),
    (("rescue", "tcp://127.0.0.1:1", "--model", "stage", "--out", "out"), f"stage cannot be rescued: {OURS}"),
    (("run", "stage", "moves.if1"), "for several controllers, use a .talk file"),
    (("run", "stage", "prog.sms"), "an .sms file needs exactly one: use a .talk file"),
    (("run", "stage"), "expected a file for a stage, e.g. axistwin run stage moves.talk"),
    (("run", "stage", "moves.txt"), "moves.txt: unknown kind of program: expected a conversation for stage"),
    (("check", "stage", "moves.txt"), "moves.txt: unknown kind of program: expected a conversation for stage"),
    (("check", "stage", "moves.if1"), "is a program for if1 or if2, not for stage: choose another program"),
    (("ioc", "free.toml", "--prefix", "LAB:", "--registers", "stage.status"),
     "unknown register 'status': expected none, because its driver knows axes only"),
    (("sweep", "scene.toml", "--vary", "table.3.limits.1=[1,2]", "--out", "x.parquet"), "expected one of table, 1, 2"),
    (("serve", "stage", "--bus", "127.0.0.1:0"), "controller stage has no bus port"),
    (("serve", "stage", "--rs485", "127.0.0.1:0"), "stage has no RS-485 channel: expected a SmartMotor"),
])  # fmt: skip
def test_one_line(command, words):
    Path("moves.if1").write_text("X100$\n", encoding="utf-8")
    Path("moves.txt").write_text("1PA500\n", encoding="utf-8")
    Path("free.toml").write_text('[[controller]]\nmodel = "stage"\n', encoding="utf-8")
    Path("prog.sms").write_text("END\n", encoding="utf-8")
    if command[0] == "ioc":
        pytest.importorskip("caproto", reason="the extra [epics] is not installed")
    done = run("--device", "stage.py", *command)
    assert done.code in (1, 2) and done.err.count("\n") == 1 and words in done.err, done
