"""The machine of the playground, as its page uses it: JSON in, JSON out."""

import io
import json
import subprocess
import sys
import zipfile

import pytest

from axistwin.core.errors import AxistwinError, UsageError
from axistwin.ui.playground.link import LONGEST_LINK, Shared, decode, encode
from axistwin.ui.playground.playground import Playground

from ..command import run
from ..told import raises

S = 10**9


@pytest.fixture
def playground(tmp_path):
    return Playground(tmp_path)


def said(state, name="if1"):
    """Return the controller's messages in a state, with control characters by name."""
    texts = ("".join(text for text, _ in entry["parts"]) for entry in state["entries"][name] if entry["who"] == "<")
    return list(texts)


def told(playground, name="if1"):
    """Return the newest entry that has changed, and its notes, as texts."""
    entry = playground.state()["entries"][name][-1]
    notes = ["".join(text for text, _ in note) for note in entry["notes"]]
    return "".join(text for text, _ in entry["parts"]), *notes


def ready(playground):
    playground.open_model("if1")
    playground.advance(2 * S, 9)
    for n, line in enumerate(("(", "U61")):
        playground.send("if1", line)
        playground.advance((4 + 2 * n) * S, 9)


def test_a_move_and_its_status(playground):
    """The manual's X4000@1000$: 4,000 pulses, and K answers 0, at rest without a fault."""
    ready(playground)
    playground.send("if1", "X4000@1000$")
    playground.advance(12 * S, 9)
    playground.send("if1", "K")
    state = playground.advance(13 * S, 9)
    assert said(state)[-1] == "0CR"
    assert state["controllers"]["if1"]["axes"]["X"] == {"position": 4000, "velocity": 0.0, "moving": False}
    assert json.dumps(state)


@pytest.mark.parametrize("model", ["if1", "if2", "1810", "1811", "smartmotor"])
def test_every_model_is_shown(playground, model):
    shown = playground.open_model(model)["controllers"]
    assert [one["model"] for one in shown] == [model]
    state = playground.advance(S // 10, 9)["controllers"][model]
    drawn = "".join(drawing["art"] for drawing in shown[0]["drawings"])
    others = {*shown[0]["inputs"], *shown[0]["outputs"]}
    assert others < set(state["pins"])
    assert all(f'"{pin}"' in drawn or f'"lamp-{pin}"' in drawn for pin in set(state["pins"]) - others)
    items = [item for group in shown[0]["front"] for item in group["items"]]
    assert [item["kind"] == "lamp" for item in items] == [isinstance(value, bool) for value in state["front"]]


def words(state):
    return state["state"]["words"], state["state"]["next"], state["state"]["buttons"]


def test_the_state_and_its_buttons(playground):
    """The first page says what to do, and its buttons do it."""
    start = "The IF1 is on. Press Initialise, or begin with the lessons"
    initialise, lessons = ("Initialise", "initialise", True), ("Lessons", "lessons", False)
    send = "Send X1000$", "do", True
    playground.open_model("if1")
    state = playground.advance(2 * S, 9)
    assert words(state) == ("Waiting for a command", start, [initialise, lessons])
    assert words(playground.state())[0] == "Paused"
    playground.press("Initialise", True)
    assert words(playground.state(running=True)) == (
        "Waiting for a command", "Type X1000$: index X by 1000 steps", [send, lessons])  # fmt: skip
    playground.act("if1", "estop", "low")
    assert words(playground.state(running=True))[0] == "Stopped: emergency stop pressed"
    playground.press("Release estop", True)
    playground.press("Send K", True)
    assert words(playground.advance(20 * S, 9))[0] == "Waiting for a command"
    playground.press("Send K", True)  # no longer offered


ANSWERS = {
    ":why": "a move is possible: try",
    ":next": "type X1000$: index X by 1000 steps",
    ":explain estop": "estop: emergency stop, now high",
    ":task": "no lesson has begun: select one with the button Lessons",
    ":init": "the controller is ready: no initialisation is needed",
}


def test_a_line_is_explained_below_it_and_questions_are_answered(playground):
    ready(playground)
    playground.state()
    playground.send("if1", "X1000")
    assert told(playground) == ("X1000CR", "nothing moves without $ at the end: type X1000$")
    for line, answer in ANSWERS.items():
        playground.send("if1", line)
        assert told(playground)[1] == answer
    playground.ask("if1", "why")
    assert told(playground)[0] == "Why does nothing move?"
    playground.send("if1", ":drive input1 high")
    assert playground.state()["controllers"]["if1"]["pins"]["input1"]
    raises(UsageError, "unknown command :speed: expected one of", playground.send, "if1", ":speed 3")


def test_a_board_says_where_a_command_is_wrong(playground):
    playground.open_model("1811")
    playground.advance(2 * S, 9)
    raises(UsageError, "invalid text in column 1 of the line", playground.send, "1811", "goo_relative 1")
    assert told(playground, "1811")[0] == "goo_relative 1"


def test_a_lesson_is_done_in_the_playground(playground):
    playground.open_model("if1")
    assert len(playground.open_model("if1")["controllers"][0]["lessons"]) == 6
    playground.begin_lesson("if1", 2)
    found = playground.state()["controllers"]["if1"]["lesson"]
    assert (found["number"], found["title"][:29]) == (2, "Lesson 2: A move, step 1 of 3")
    playground.ask("if1", "show")
    assert told(playground)[1] == "type X1000$"
    playground.send("if1", "X1000$")
    state = playground.advance(20 * S, 9)
    assert state["controllers"]["if1"]["lesson"]["title"][:29] == "Lesson 2: A move, step 2 of 3"
    playground.end_lesson("if1")
    assert playground.state()["controllers"]["if1"]["lesson"] is None


def test_a_restart_begins_again_at_0(playground):
    ready(playground)
    assert playground.restart()["title"] == "Digiplan IF1 stepper motor interface"
    state = playground.state()
    assert (state["now_ns"], state["entries"]) == (0, {})


def test_a_switch_on_a_drawing_is_pressed_and_released(playground):
    playground.open_model("if1")
    assert ["switch-input1-word", "text", "off"] in map(list, playground.state()["drawings"]["switches if1"])
    for level, word in ((True, "pressed"), (False, "off")):
        playground.click("switches if1", "input1")
        state = playground.state()
        assert state["controllers"]["if1"]["pins"]["input1"] is level
        assert ("switch-input1-word", "text", word) in state["drawings"]["switches if1"]
    playground.click("switches if1", "no such part")
    assert playground.state()["drawings"] == {}


def test_every_example_opens(playground):
    for example in playground.choices()["examples"]:
        assert playground.open_example(example["name"])["title"] and playground.advance(S, 9)["now_ns"] == S


def test_a_link_opens_the_same_moment(playground):
    ready(playground)
    playground.send("if1", "X4000@1000$")
    moment = playground.advance(6 * S + 543_210_987, 9)
    link, table = playground.link(), playground.table()
    opened = playground.open_link(link)
    assert opened["target_ns"] == 6 * S + 543_210_987 and opened["note"] == ""
    again = playground.advance(opened["target_ns"], 9)
    assert again["controllers"] == moment["controllers"]
    assert 0 < again["controllers"]["if1"]["axes"]["X"]["position"] < 4000
    assert playground.table() == table


def test_a_saved_session_repeats_itself_with_run(playground, tmp_path):
    ready(playground)
    playground.send("if1", "X400@1000$")
    playground.act("if1", "input1", "high")
    playground.advance(9 * S, 9)
    zipfile.ZipFile(io.BytesIO(playground.saved())).extractall(tmp_path / "saved")
    assert '"position": 400' in run("run", tmp_path / "saved" / "scene.toml", "--for", "9", "--json").out


def test_a_link_of_another_version_is_opened_with_a_note(playground):
    scene = '[[controller]]\nmodel = "1811"\n'
    assert playground.open_link(encode(Shared({"scene.toml": scene}, 0, "0.1")))["note"].startswith(
        "made with axistwin 0.1"
    )


@pytest.mark.parametrize(("fragment", "message"), [
    ("!!", "the URL of the shared scene is"), ("eJw", "the URL of the shared scene is incomplete"),
    (encode(Shared({"scene.toml": "x" * 1000}, 5))[:-9], "the URL of the shared scene is"),
    ("x" * (LONGEST_LINK + 1), "the URL of the shared scene has 200001 characters"),
    (encode(Shared({}, 0)), "the URL of the shared scene is damaged"),
    (encode(Shared({"scene.toml": "x"}, -1)), "the URL of the shared scene is damaged")])  # fmt: skip
def test_a_damaged_link_is_refused(fragment, message):
    with pytest.raises(UsageError, match=message):
        decode(fragment)


def test_a_link_never_grows_beyond_its_limit():
    with pytest.raises(UsageError, match="download the scene files"):
        encode(Shared({"a.talk": "".join(chr(33 + n * n % 90) * (n % 7) for n in range(1_500_000))}, 0))


@pytest.mark.parametrize("name", ["../scene.toml", "/scene.toml", "a/../../b", ""])
def test_files_stay_in_their_folder(playground, name):
    raises(UsageError, "is not a file name", playground.open_files, {"scene.toml": "", name: ""})


def test_an_invalid_scene_leaves_the_open_one(playground):
    playground.open_model("if1")
    raises(AxistwinError, "unknown key 'what'", playground.open_files, {"scene.toml": "what = 1\n"})
    assert playground.advance(S, 9)["now_ns"] == S


def test_a_program_is_checked_and_loaded(playground):
    playground.open_model("smartmotor")
    found = playground.check("smartmotor", ".sms", "LIMH\nEND\n")
    assert [(one["line"], one["column"], one["severity"]) for one in found] == [(1, 1, "error")]
    playground.load("smartmotor", "program.sms", 'PRINT("ready",#13)\nEND\n')
    assert said(playground.advance(4 * S, 9), "smartmotor")[-1] == "readyCR"


def test_curves_have_bounded_memory_and_keep_their_first_sample(playground):
    playground.open_model("if1")
    state = playground.advance(1000 * S, 99)
    assert state["interval_ns"] == 320_000_000  # 20 ms, doubled at each 4,096 samples: 4 times within 1,000 s
    assert len(playground.table().splitlines()) == 1 + 1 + 1000 * 1000 // 320
    assert len(playground.state(points=50)["curves"]["if1.X"]["position"]) <= 100


PACKAGES = "sim plant controllers bench scenes ui.teaching"
ABSENT = "numpy numba socket subprocess termios fcntl pty multiprocessing pyarrow matplotlib"
IMPORTS = f"""
import asyncio, logging, pydantic, simpy, sys  # libraries may import what axistwin may not
class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in "{ABSENT}".split():
            raise ModuleNotFoundError(name)
for name in list(sys.modules):
    if name.partition(".")[0] in "{ABSENT}".split():
        del sys.modules[name]
sys.meta_path.insert(0, Blocked())
import importlib, pathlib, pkgutil, tempfile
for package in "{PACKAGES}".split():
    folder = importlib.import_module("axistwin." + package)
    for module in pkgutil.walk_packages(folder.__path__, "axistwin." + package + "."):
        if ".kernel." not in module.name:  # run time chooses the plain or the compiled kernel
            importlib.import_module(module.name)
from axistwin.ui.playground.playground import Playground
playground = Playground(pathlib.Path(tempfile.mkdtemp()))
for model in ("if1", "1811", "smartmotor"):
    playground.open_model(model)
    assert playground.advance(10**9, 9)["now_ns"] == 10**9
"""


def test_nothing_that_a_browser_lacks_is_imported():
    """Pyodide has no threads, sockets and processes; the page has neither NumPy nor Numba."""
    done = subprocess.run([sys.executable, "-c", IMPORTS], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]


def test_the_folder_needs_an_engine(tmp_path):
    done = run("docs", "--playground", "--engine", tmp_path, "--out", tmp_path / "site")
    assert done.code == 2 and "run `make engine`, which downloads the file" in done.err
    assert (
        run("docs", "--playground").err == "axistwin: --playground needs two folders: expected --engine DIR --out DIR\n"
    )
    assert not (tmp_path / "site").exists()
