"""Scenes: the contents of a file, the bench that is built from it, and the errors in a file."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from axistwin import Scene
from axistwin.bench.programs import running
from axistwin.core.errors import SceneError
from axistwin.scenes.toml_places import places

EXAMPLES = Path(__file__).parents[2] / "examples"

FULL = """
title = "a # b"  # not a scene's key, but a place
[[controller]]
model = "if2"
name = 'q'
ports = [
  "tcp://127.0.0.1:0",  # one
  "pty:/tmp/x" ]
options = { wiring = "3-wire", busy = "hold" }
[controller.axes.X]
limits = [-5, 5]
motor.torque = [[0, 1.0], [1000, 0.5]]
[[controller]]
model = \"\"\"if
1\"\"\"
[controller.axes]
"Y".limits = [1,
  2]
[[wire]]
from = "a.b"
"""


@pytest.fixture
def scene(tmp_path: Path) -> Callable[[str], Scene]:
    def load(text: str) -> Scene:
        (tmp_path / "s.toml").write_text(text)
        return Scene.load(tmp_path / "s.toml")

    return load


def controllers(*models: str, more: str = "") -> str:
    return "".join(f'[[controller]]\nmodel = "{model}"\n' for model in models) + more


def test_the_example_drills_ten_holes_and_returns():
    bench = Scene.load(EXAMPLES / "xy-table.toml").build()
    table = bench["table"]
    holes: list[tuple[int, int]] = []

    def drill_moves(pin):
        if pin.level:
            holes.append((table.axes["X"].position, table.axes["Y"].position))

    table.pins["input1"].subscribe(drill_moves)

    running.load(EXAMPLES / "drill.if1").perform(bench, None)

    forth = [(1600 * n, 0) for n in range(1, 6)]
    assert holes == forth + [(x, 1600) for x, _ in reversed(forth)]
    assert (table.axes["X"].position, table.axes["Y"].position) == (0, 0)


def test_a_limit_switch_of_the_example_opens():
    bench = Scene.load(EXAMPLES / "xy-table.toml").build()
    table = bench["table"]
    bench.run(1.5)
    table.serial.write(b"(")
    bench.run(0.1)
    table.serial.write(b"U61\r")
    bench.run(1.2)
    table.serial.write(b"X-500$\r")
    bench.run(2.0)
    assert not table.pins["limit_minus"].level and -500 < table.axes["X"].position < -160


def test_names_ports_and_options(scene, tmp_path):
    made = scene(
        controllers("IF1") + 'ports = ["tcp://127.0.0.1:0", "pty:/tmp/a"]\n'
        'line = "1200 7E1"\nhistory = 5\n'
        '[[controller]]\nmodel = "if2"\nname = "left"\nstate = "kept"\nports = ["rfc2217://127.0.0.1:0"]\n'
        'options = {wiring = "3-wire", recalculation_s = 0.5}\n'
    )
    assert made.ports == [("if1", "tcp://127.0.0.1:0"), ("if1", "pty:/tmp/a"), ("left", "rfc2217://127.0.0.1:0")]
    bench = made.build()
    assert list(bench.controllers) == ["if1", "left"] and str(bench["if1"].serial.host.format) == "1200 7E1"

    bench.run(1.5)
    left = bench["left"].serial
    for message in (b"(", b"U61\r", b"[\r"):
        left.write(message)
        bench.run(1.0)
    assert (tmp_path / "kept" / "left.json").exists(), "the directory is relative to the scene file"


def test_the_machine_of_an_axis(scene):
    axis = (
        scene(
            controllers("if1") + "[controller.axes.Z]\nencoder = {counts_per_rev = 2000}\n"
            "motor = {torque = [[0, 1.5], [5000, 0.5]], inertia = 1e-5}\nload = {torque = 0.1}\n"
        )
        .build()["if1"]
        .axes["Z"]
    )
    assert axis.encoder.count == 0


def test_a_wire_inverts_and_delays_a_level(scene):
    bench = scene(
        controllers("if1")
        + '[[wire]]\nfrom = "if1.output1"\nto = "if1.input1"\ndelay_ms = 250\n'
        + '[[wire]]\nfrom = "if1.output1"\nto = "if1.input2"\ninvert = true\n'
    ).build()
    pins = bench["if1"].pins
    assert (pins["input1"].level, pins["input2"].level) == (False, True)
    pins["output1"].drive(True)
    bench.run(0.249)
    assert (pins["input1"].level, pins["input2"].level) == (False, False)
    bench.run(0.001)
    assert pins["input1"].level


def test_each_build_returns_a_new_bench(scene):
    made = scene(controllers("if1"))
    assert made.build() is not made.build()


WRONG = [
    # models of the scene, what else stands in it, and the error
    ("", "", "1:1: 'controller' is missing: add [[controller]]"),
    ("", "[[controller]]\nmodel = if1\n", "2:9: not TOML: invalid value"),
    ("", "x", "1:2: not TOML: expected '=' after a key in a key/value pair"),
    ("", '[[controler]]\nmodel = "if1"', "1:1: unknown key 'controler': did you mean 'controller'? (and 1"),
    ("", "[[controller]]", "1:1: 'model' is missing: add model = …"),
    ("if9", "", "2:1: no model 'if9': expected one of if1, if2"),
    ("smartmotr", 'axes.shaft.motor = "frame17"',
     "2:1: no model 'smartmotr': expected one of if1, if2, 1810, 1811, smartmotor; did you mean 'smartmotor'?"),
    ("if1", "prots = []", "3:1: unknown key 'prots': did you mean 'ports'?"),
    ("if1", "zzz = 1", "3:1: unknown key 'zzz': expected one of model, name, line"),
    ("if1", "line = 'fast'",
     "3:1: invalid baud rate or character format 'fast': expected e.g. '9600 8N2', or 'instant'"),
    ("if1", "options.wirring = 1", "3:1: unknown key 'wirring' in options: did you"),
    ("if1", "options = {busy = 'hold', wiring = '4'}", "3:27: wiring='4': expected one of '5-wire'"),
    ("if1", "axes.W.limits = [1, 2]", "3:1: unknown key 'W' in axes: expected one of X, Y, Z"),
    ("if1", "axes.X.limit = [1, 2]", "3:1: unknown key 'limit': did you mean 'l"),
    ("if1", "axes.X.limits = [1]", "3:1: controller.axes.X.limits: expected two num"),
    ("if1", "axes.X.limits = [1, 'b']",
     "3:21: controller.axes.X.limits: 'b' is not a position: expected e.g. 1000, not \"b\""),
    ("if1", "axes.X.limits = [2, 1]", "3:1: controller.axes.X.limits: expected the"),
    ("if1", "axes.X.home = [0, 9]", "3:1: if1 has no home input: leave out the option `home`"),
    ("if1", "axes.X.motor = {pull = 3}", "3:1: 'torque' is missing: add torque = …"),
    ("if1", "ports = ['tcp:/x']", "3:10: invalid address 'tcp:/x': expected ADDRESS:PORT"),
    ("if1 if1", "", "4:1: two controllers have the name 'if1': expected different names"),
    ("if1", "name = 'a b'", "3:1: controller.name: expected only letters, dig"),
    ("if1", "name = 3\nline = 4", "3:1: controller.name: input should be a valid string"),
    ("if1", "[[wire]]\nfrom = 'if1.led'", "3:1: 'to' is missing: add to = …"),
    ("if1", "[[wire]]\nfrom = 'led'\nto = 'if1.input1'",
     "4:1: invalid terminal 'led': expected CONTROLLER.PIN, e.g. if1.output1"),
    ("if1", "[[wire]]\nfrom = 'if2.led'\nto = 'if1.input1'",
     "4:1: the scene has no controller 'if2': did you mean 'if1'?"),
    ("if1", "[[wire]]\nfrom = 'if1.led'\nto = 'if1.input4'", "5:1: if1 has no pin 'input4': did you mean 'input3'?"),
    ("if1", "[[wire]]\nfrom = 'if1.led'\nto = 'if1.input1'\n" * 2, "8:1: if1.input1 already has a wire from if1.led"),
    ("if1", "[[wire]]\nfrom = 'if1.input1'\nto = 'if1.input2'\n[[wire]]\nfrom = 'if1.input2'\nto = 'if1.input1'",
     "8:1: the wires form a loop through if1.input1: remove one"),
    ("if1", "[[wire]]\nfrom = 'if1.led'\nto = 'if1.input1'\ndelay_ms = inf",
     "6:1: inf s is too long: expected less than 292 years"),
    ("if1", "[[script]]\nat = 1e300\ndo = 'power off'", "4:1: 1e+300 s is too long: expected less than 292 years"),
    ("if1", f"history = {10**30}", "3:1: controller.history: input should be less than or equal to 1000000000"),
    ("if1", "history = " + 5000 * "9", "3:5011: not TOML: exceeds the limit"),
    ("if1", "options = " + 5000 * "[" + 5000 * "]", "3:10011: not TOML: "),
    ("if1", "options.a = " + 300 * "[" + 300 * "]",
     "3:613: not TOML: tables or lists are nested too deeply: expected at most 50"),
    ("if1", "axes.X.motor = {torque = [[0, nan]]}",
     "3:1: controller.axes.X.motor: invalid torque curve: expected torques of 0 N·m or more"),
    ("if1", "[[wire]]\nfrom = 'if1.led'\nto = 'if1.output1'",
     "5:1: if1.output1 is an output: expected a wire that ends at an input"),
    ("if1 smartmotor", "[[wire]]\nfrom = 'if1.led'\nto = 'smartmotor.brake'", "7:1: smartmotor.brake is an output"),
    ("if1 1811", "[[wire]]\nfrom = 'if1.led'\nto = '1811.step'", "7:1: 1811.step is an output"),
    ("1810 1811", "[[wire]]\nfrom = '1810.step'\nto = '1811.step_in'",
     "6:1: a wire cannot begin at the step output 1810.step: to send step pulses to a SmartMotor"),
    ("smartmotor", "ports = ['tcp://:0']\n[[chain]]\nmotors = ['smartmotor']",
     "3:1: the key `ports` is not permitted for motor smartmotor on the shared line 'chain': set the key `ports`"),
    ("smartmotor", "rs485_ports = ['tcp://:0']\n[[rs485]]\nmotors = ['smartmotor']",
     "3:1: the key `rs485_ports` is not permitted for motor smartmotor on the shared line 'rs485': set the key"),
    ("",
     controllers("if1", more="ports = ['tcp://:5001']\n") + controllers("1811", more="ports = [\n'bus://localhost:0',\n'bus://localhost:5001']"),
     "8:1: bus://localhost:5001 is the same port as tcp://:5001: expected a different port"),
    ("if1", "ports = ['pty:/tmp/x', 'pty:/tmp/x']",
     "3:24: pty:/tmp/x is the same port as pty:/tmp/x: expected a different port"),
    ("1811", "ports = ['tcp://:5001']",
     "3:10: tcp://:5001 is not a port for an 1810 or 1811: expected a bus, e.g. bus://127.0.0.1:1811"),
    ("smartmotor", "[[chain]]\nmotors = ['smartmotor']\nports = ['bus://:1811']",
     "5:10: bus://:1811 is a bus, not a port for a serial line: expected another kind of port, e.g. tcp://127.0.0.1"),
    ("if2", 'state = "a\\u0000b"',
     '3:1: controller.state: a file name cannot contain the character NUL, not "a\\u0000b"'),
    ("if2", 'ports = ["pty:/tmp/\\u0000b"]',
     "3:10: invalid port URL 'pty:/tmp/\\x00b': expected a URL without NUL characters"),
    ("if1", "[[wire]]\nfrom = 'if1.led'\nto = 'if1.input1'\ndelay_ms = -1",
     "6:1: wire.delay_ms: input should be greater than or equal to 0, not -1"),
]  # fmt: skip


def test_ports_without_conflict(scene):
    """Port 0 means any free port; two addresses may have the same port number."""
    made = scene(
        controllers("if1", more="ports = ['tcp://:0', 'tcp://:0', 'pty:', 'pty:', 'tcp://:5001']\n")
        + controllers("if2", more="ports = ['tcp://127.0.0.2:5001', 'serial:///dev/ttyS0']\n")
    )
    assert len(made.ports) == 7


def test_terminals_that_a_wire_can_drive(scene):
    """A wire may begin at a user pin of a motor, and at an input of another controller."""
    bench = scene(
        controllers("if1", "1811", "smartmotor")
        + "".join(
            f'[[wire]]\nfrom = "if1.output1"\nto = "{to}"\n'
            for to in ("smartmotor.G", "1811.cw_limit", "1811.step_in", "if1.estop")
        )
    ).build()
    bench["if1"].pins["output1"].drive(True)
    assert all(bench[name].pins[pin].level for name, pin in (("smartmotor", "G"), ("1811", "cw_limit")))


@pytest.mark.parametrize(("models", "more", "message"), WRONG, ids=[message[:50] for *_, message in WRONG])
def test_errors_of_a_scene_have_a_place_and_a_remedy(scene, tmp_path, models, more, message):
    with pytest.raises(SceneError) as caught:
        scene(controllers(*models.split(), more=more)).build()
    assert str(caught.value).startswith(f"{tmp_path}/s.toml:{message}") and "\n" not in str(caught.value)


def test_a_missing_scene(tmp_path):
    with pytest.raises(SceneError, match=r"nowhere\.toml: the scene file cannot be read: No such file"):
        Scene.load(tmp_path / "nowhere.toml")


def test_a_byte_order_mark_and_crlf_are_accepted(tmp_path):
    (tmp_path / "s.toml").write_bytes(b'\xef\xbb\xbf[[controller]]\r\nmodel = "if1"\r\n')
    assert list(Scene.load(tmp_path / "s.toml").build().controllers) == ["if1"]


def test_a_scene_that_is_not_a_text_file(tmp_path):
    (tmp_path / "s.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(SceneError, match="is not a text file in UTF-8"):
        Scene.load(tmp_path / "s.toml")


def test_the_schema_is_json_and_has_all_tables():
    schema = json.loads(json.dumps(Scene.schema()))
    tables = {"title", "seed", "controller", "wire", "chain", "rs485", "fault", "script", "stand-in"}
    tables |= {"panel", "operator"}
    assert set(schema["properties"]) == tables
    assert {"model", "ports", "axes"} <= set(schema["$defs"]["ControllerTable"]["properties"])
    assert "from" in schema["$defs"]["WireTable"]["properties"]


def test_the_schema_has_the_keys_of_both_kinds_of_axis():
    axes = Scene.schema()["$defs"]["ControllerTable"]["properties"]["axes"]["additionalProperties"]["anyOf"]
    assert axes[0] == {"$ref": "#/$defs/AxisTable"}
    assert set(axes[1]["properties"]) == {"limits", "motor", "load", "units"}
    values, names = axes[1]["properties"]["motor"]["anyOf"]
    assert names["enum"] == ["frame17", "frame23", "frame34"]
    assert values["properties"]["kp"] == {"type": "integer"} and not values["additionalProperties"]


def test_places_in_a_file():
    found = places(FULL)
    lines = FULL.splitlines()
    shown = {path: lines[line - 1][column - 1 :][:12] for path, (line, column) in found.items()}
    assert shown["controller", 0] == "[[controller" and shown["controller", 0, "ports", 1] == '"pty:/tmp/x"'
    assert shown["controller", 0, "options", "busy"] == 'busy = "hold'
    assert shown["controller", 0, "axes", "X"] == "[controller."
    assert shown["controller", 0, "axes", "X", "motor", "torque", 1, 0] == "1000, 0.5]]"
    assert shown["controller", 1, "model"].startswith('model = """')
    assert shown["controller", 1, "axes", "Y", "limits", 1] == "2]" and shown["wire", 0, "from"] == 'from = "a.b"'
