"""Events of a scene: faults, script, hosts, stored programs, and an encoder on another axis."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner

from axistwin import Scene
from axistwin.bench.faults.kinds import KINDS
from axistwin.cli.authoring.faults import rows
from axistwin.cli.program import axistwin
from axistwin.core.errors import AxistwinError, SceneError, UsageError

IF1 = '[[controller]]\nmodel = "if1"\n'
SHAFT = '[[controller]]\nmodel = "smartmotor"\naxes.shaft = '
MOTOR = '[[controller]]\nmodel = "smartmotor"\nname = "knife"\n'


@pytest.fixture
def scene(tmp_path: Path) -> Callable[..., Scene]:
    def load(text: str, **files: str) -> Scene:
        for name, contents in files.items():
            (tmp_path / name.replace("_", ".")).write_text(contents)
        (tmp_path / "s.toml").write_text(text)
        return Scene.load(tmp_path / "s.toml")

    return load


def test_faults_begin_and_end(scene):
    bench = scene(
        IF1 + '[[fault]]\nkind = "stuck"\non = "if1.input1"\nlevel = "high"\nat = 2.0\nduration = 1\n'
        '[[fault]]\nkind = "jam"\nname = "nut"\non = "X"\nwhen = "X passes 100"\n'
    ).build()
    levels = []
    bench["if1"].pins["input1"].subscribe(lambda pin: levels.append((bench.seconds, pin.level)))
    bench.run(5)
    assert levels == [(2.0, True), (3.0, False)]
    assert bench.faults["nut"].spot.name == "if1.X"


def test_a_fault_may_wait_for_a_later_fault_or_a_fault_in_the_script(scene):
    bench = scene(
        IF1 + '[[fault]]\nkind = "jam"\non = "X"\nwhen = "later begins"\n'
        '[[fault]]\nkind = "jam"\non = "Y"\nwhen = "stuck-2 ends"\n'
        '[[fault]]\nkind = "stuck"\non = "input1"\nlevel = "high"\nname = "later"\nat = 2\n'
        '[[fault]]\nkind = "stuck"\non = "input2"\nlevel = "high"\nwhen = "hand begins"\nduration = 1\n'
        '[[fault]]\nkind = "stuck"\non = "input3"\nlevel = "high"\nat = 1\nduration = 2\n'
        "[[script]]\nat = 4\ndo = \"fault load X 0.1 when='press begins' name=hand\"\n"
        '[[script]]\nat = 5\ndo = "fault load Y 0.1 name=press"\n'
    ).build()
    begun = {}
    bench.faults.subscribe(lambda fault, what: begun.setdefault((fault.name, what), bench.seconds))
    bench.run(10)
    assert [name for name, what in begun if what == "begins"] == [
        "stuck-2", "later", "jam", "jam-2", "press", "hand", "stuck",
    ]  # fmt: skip
    assert (begun["jam", "begins"], begun["jam-2", "begins"], begun["stuck", "begins"]) == (2, 3, 5)


def test_faults_that_wait_for_one_another_are_refused(scene):
    text = IF1 + '[[fault]]\nkind = "jam"\non = "X"\nwhen = "b begins"\nname = "a"\n'
    with pytest.raises(
        SceneError,
        match=r"s\.toml:6:1: the fault a can never begin: its trigger 'b begins' happens only after the fault a",
    ):
        scene(text + '[[fault]]\nkind = "jam"\non = "Y"\nwhen = "a ends"\nname = "b"\n').build()
    with pytest.raises(SceneError, match=r"s\.toml:6:1: unknown fault 'b': known faults are a"):
        scene(text).build()


def test_the_seeds_of_faults_are_derived_from_the_seed_of_the_scene(scene):
    text = IF1 + '[[fault]]\nkind = "lose"\non = "if1"\nprobability = 0.5\n' * 2
    with pytest.raises(AxistwinError, match="is random and needs a seed"):
        scene(text).build()
    bench = scene("seed = 7\n" + text).build()
    assert [fault.seed for fault in bench.faults] == [7000, 7001] and bench.origin["seed"] == "7"
    assert bench.origin["scene"].startswith("s.toml sha256:")


def test_a_script(scene):
    bench = scene(
        IF1 + '[[script]]\nat = 1.0\ndo = "input1 high"\n'
        '[[script]]\nat = 2\ndo = ["input1 release", "fault stuck input2 high name=s", "X.load 0.5"]\n'
        '[[script]]\nat = 3\ndo = ["mend s", "power off"]\n'
    ).build()
    pins, seen = bench["if1"].pins, []
    for name in ("input1", "input2"):
        pins[name].subscribe(lambda pin: seen.append((bench.seconds, pin.name, pin.level)))
    assert bench.agenda_ns == 3_000_000_000
    bench.run(4)
    assert seen == [(1, "input1", True), (2, "input1", False), (2, "input2", True), (3, "input2", False)]
    assert not pins["led"].level


def test_two_hosts_send_command_lines_at_the_same_time(scene):
    two = "".join(f'[[controller]]\nmodel = "if1"\nname = "{name}"\nhost = "{name}.if1"\n' for name in ("a", "b"))
    bench = scene(two, a_if1="X1000$\nN\nX-$\n", b_if1="+1\nX300$\n! input1 high\n").build()
    bench.run(12)
    a, b = bench["a"], bench["b"]
    assert a.serial.read() == b"U\r1000\r" and (a.axes["X"].position, b.axes["X"].position) == (0, 300)
    assert b.pins["input1"].level


def test_a_host_sends_commands_to_a_board(scene):
    board = '[[controller]]\nmodel = "1811"\nhost = "m.181x"\n'
    bench = scene(
        board, m_181x="default_velocity_and_acceleration 00 25000 250000\ngo_relative 2500\ngo_relative -500\n"
    ).build()
    bench.run(5)
    assert bench["1811"].axes["motor"].position == 2000


def test_a_stored_program_starts_at_power_up(scene):
    bench = scene(
        MOTOR + 'program = "p.sms"\n', p_sms="UCI UDI\nZS\nMP\nA=100\nV=100000\nD=500\nG\nTWAIT\nRP\nEND\n"
    ).build()
    bench.run(2)
    assert bench["knife"].serial.read() == b"500\r"


def test_a_master_on_another_axis(scene):
    text = IF1 + 'host = "f.if1"\n' + MOTOR + 'program = "k.sms"\nmaster = "if1.X"\nmaster_ratio = [5, 2]\n'
    bench = scene(
        text, f_if1="+1\nX1000$\n+4\nX-$\n", k_sms="UCI UDI\nZS\nMF4\nMFMUL=2\nMFDIV=1\nMFR\nG\nEND\n"
    ).build()
    positions = []
    bench["if1"].axes["X"].on_motion.subscribe(lambda: positions.append(bench["knife"].axes["shaft"].position))
    bench.run(15)
    assert bench["knife"].master.count == 0 and positions == [0, 5000]
    assert bench["knife"].axes["shaft"].position == 0


@pytest.mark.parametrize(("text", "message"), [
    ('[[fault]]\nkind = "lse"\n', "4:1: unknown kind of fault 'lse': did you mean 'lose'?"),
    ('[[fault]]\nkind = "jam"\non = "if1.Q"\n', "5:1: unknown axis 'if1.Q': did you mean 'if1.Z'?"),
    ('[[fault]]\nkind = "jam"\ncount = 3\non = "X"\n',
     "5:1: fault jam has no parameter 'count': expected no parameters"),
    ('[[fault]]\nkind = "lose"\nwhy = 3\n', "5:1: unknown key 'why'"),
    ('[[fault]]\non = "X"\n', "3:1: 'kind' is missing: add kind = …"),
    ('[[fault]]\nkind = "stuck"\non = "input1"\nlevel = "up"\n', "6:1: invalid value level='up': expected high"),
    ('[[fault]]\nkind = "jam"\non = "X"\nwhen = "X leaps"\n', "6:1: invalid event when='X leaps': expected e.g."),
    ('[[fault]]\nkind = "jam"\non = "X"\nat = -1\n', "6:1: fault.at: input should be greater than or equal to 0"),
    ('[[fault]]\nkind = "jam"\non = "X"\nwhen = "W passes 1"\n', "6:1: unknown axis 'W': expected one of if1.X"),
    ('[[fault]]\nkind = "jam"\non = "X"\nwhen = "if1 raises Q"\n', "6:1: if1 has no fault flag 'Q': expected one of"),
    ('[[fault]]\nkind = "flip"\nprobability = 0.5\n',
     "5:1: the fault flip with probability=0.5 is random and needs a seed: add e.g. seed=1"),
    ('[[fault]]\nkind = "lose"\nat = 1e300\n', "5:1: `at` is out of range: expected less than 9.2e9 s"),
    ('[[fault]]\nkind = "lose"\nduration = inf\n',
     "5:1: invalid duration=inf: expected a number of seconds, 0 or more"),
    ('[[fault]]\nkind = "push"\non = "X"\nduration = 1\ncounts = 3\n', "5:1: axis X has no encoder: add the option"),
    ('[[fault]]\nkind = "encoder_dead"\non = "X"\n', "5:1: axis X has no encoder: add the option"),
    ('[[fault]]\nkind = "overheat"\n', "4:1: if1 is not a SmartMotor: expected the name of a SmartMotor"),
    ('[[fault]]\nkind = "break"\nduration = 1\n',
     "5:1: the fault break occurs only once and cannot have a duration: leave out `duration`"),
    ('[[fault]]\nkind = "lose"\nname = "a"\n' * 2,
     "8:1: there is a fault 'a' already: end that fault, or choose another name"),
    (SHAFT + "{ limit = [0, 1] }", "5:16: axis shaft has no option 'limit': expected one of limits, motor, load"),
    (SHAFT + "{ limits = [0] }", "5:16: invalid limits=[0] of axis shaft: expected two positions"),
    (SHAFT + '{ motor = "frame99" }',
     "5:16: invalid option of axis shaft: unknown motor 'frame99': expected one of frame17"),
    (SHAFT + "{ motor = { kq = 1 } }",
     "5:26: invalid option of axis shaft: unknown parameter 'kq' of the motor: expected one of"),
    (SHAFT + "{ motor.ks = 70000 }",
     "5:16: invalid option of axis shaft: invalid motor ks=70000: expected a number from"),
    (SHAFT.replace("axes.shaft = ", "[controller.axes.shaft]\n") + "load = { inertia_kg_m2 = 'x' }",
     "6:10: invalid option of axis shaft: invalid load inertia_kg_m2='x': expected a number"),
    ('[[script]]\nat = 1\ndo = ["input9 high"]\n', "5:7: unknown name 'input9': expected one of"),
    ('[[script]]\nat = 1\ndo = "input1"\n', "5:1: the value is missing"),
    ('[[script]]\nat = 1\ndo = "mend it"\n', "5:1: unknown fault 'it': known faults are none"),
    ('[[script]]\nat = 1\non = "if2"\ndo = "input1 high"\n', "the scene has no controller 'if2': expected one of if1"),
    ('[[script]]\ndo = "input1 high"\n', "3:1: 'at' is missing: add at = …"),
    ('[[controller]]\nmodel = "if2"\nmaster = "if1.X"\n', "5:1: if2 has no attribute `master`"),
    ('[[controller]]\nmodel = "smartmotor"\nmaster = "if1.W"\n', "5:1: if1 has no axis 'W': expected one of X, Y, Z"),
    ('[[controller]]\nmodel = "smartmotor"\nmaster = "X"\n', "5:1: invalid axis 'X': expected CONTROLLER.AXIS"),
    ('[[controller]]\nmodel = "if2"\nprogram = "p.sms"\n', "5:1: if2 cannot store a program: expected a SmartMotor"),
    ('[[controller]]\nmodel = "if2"\nhost = "none.if1"\n', "none.if1 cannot be read: no such file or directory"),
    ('[[controller]]\nmodel = "if2"\nhost = "x.sms"\n', "x.sms cannot be sent by a host"),
    ('[[controller]]\nmodel = "smartmotor"\nhost = "x.if1"\n',
     "x.if1 is not a program for smartmotor: expected a program for a SmartMotor")])  # fmt: skip
def test_errors_have_their_place(scene, text, message):
    with pytest.raises(AxistwinError) as told:
        scene(IF1 + text).build()
    assert message.lower() in str(told.value).lower()


@pytest.mark.parametrize(("act", "message"), [
    ('do = "fault jam X at=1"', "s.toml:5:1: the start time at=1 is in the past: expected 2 s or later"),
    ('do = ["input1 low", "mend jam"]', "s.toml:5:21: unknown fault 'jam': known faults are none")])  # fmt: skip
def test_errors_of_script_actions_at_run_time_have_their_place(scene, act, message):
    bench = scene(f"{IF1}[[script]]\nat = 2\n{act}\n").build()
    with pytest.raises(SceneError) as raised:
        bench.run(3)
    assert str(raised.value).endswith(message)


def test_a_loop_of_external_encoders_is_refused(scene):
    text = MOTOR + 'master = "b.shaft"\n' + MOTOR.replace("knife", "b") + 'master = "knife.shaft"\n'
    with pytest.raises(SceneError, match=r"s\.toml:4:1: knife would follow its own shaft: .* other than b\.shaft"):
        scene(text)


def test_an_error_in_the_file_of_a_host_has_its_place_in_that_file(scene):
    with pytest.raises(AxistwinError, match=r"s\.toml:3:1: .*f\.if1:2"):
        scene(IF1 + 'host = "f.if1"\n', f_if1="X1$\n! input7 high\n").build()


def test_run_and_serve_accept_a_scene(scene, tmp_path):
    assert scene(IF1 + 'host = "f.if1"\n[[controller]]\nmodel = "if2"\n', f_if1="X100$\n").hosted == {"if1"}
    result = CliRunner().invoke(axistwin, ["run", str(tmp_path / "s.toml"), "--json"])
    assert result.exit_code == 0 and json.loads(result.stdout)["note"] == ""
    assert CliRunner().invoke(axistwin, ["run", "if1"]).exit_code != 0


def test_a_served_controller_has_no_simulated_host(scene):
    text = IF1 + 'host = "f.if1"\nports = ["tcp://127.0.0.1:0"]\n'
    for served, position in ((True, 0), (False, 100)):
        bench = scene(text, f_if1="X100$\n").build(served=served)
        bench.run(5)
        assert bench["if1"].axes["X"].position == position


def test_serve_refuses_a_scene_without_ports(scene, tmp_path):
    scene(IF1 + 'host = "f.if1"\n', f_if1="X100$\n")
    done = CliRunner().invoke(axistwin, ["serve", str(tmp_path / "s.toml")])
    assert isinstance(done.exception, UsageError) and "has a port for an external host" in str(done.exception)


def test_the_schema_for_editors_has_every_parameter_of_every_fault():
    keys = json.loads(CliRunner().invoke(axistwin, ["schema"]).stdout)["$defs"]["FaultTable"]["properties"]
    assert {parameter.name for kind in KINDS.values() for parameter in kind.parameters} < set(keys)


def test_the_list_of_faults():
    lines = CliRunner().invoke(axistwin, ["faults"]).stdout.splitlines()
    assert [line.split()[0] for line in lines[1:]] == list(KINDS)
    listed = json.loads(CliRunner().invoke(axistwin, ["faults", "--json"]).stdout)["faults"]
    assert {kind["name"] for kind in listed} == set(KINDS)


def test_the_page_about_faults_has_them_all():
    page = (Path(__file__).parents[2] / "docs" / "faults.md").read_text(encoding="utf-8")
    for name, thing, parameters, doc in rows():
        shown = " ".join(f"`{parameter}`" for parameter in parameters.split())
        assert f"| `{name}` | {thing} | {shown} | {doc} |".replace("|  |", "| |") in page
