"""The example scenes are whole machines: their final results."""

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from axistwin import Scene
from axistwin.cli.program import axistwin

EXAMPLES = Path(__file__).parents[2] / "examples"
SCENES = "drill", "winder", "cut-to-length", "gains"


def build(name):
    return Scene.load(EXAMPLES / name / "scene.toml").build()


@pytest.mark.parametrize("name", SCENES)
def test_each_has_a_page_with_a_picture(name):
    page = (EXAMPLES / name / "README.md").read_text(encoding="utf-8")
    assert "picture.png" in page
    assert (EXAMPLES / name / "picture.png").read_bytes().startswith(b"\x89PNG")
    for file in (EXAMPLES / name).iterdir():
        assert file.name in page or file.name == "README.md"


@pytest.mark.parametrize("name", SCENES)
def test_each_runs_by_itself_and_ends(name):
    result = CliRunner().invoke(axistwin, ["run", str(EXAMPLES / name / "scene.toml"), "--json"])
    assert result.exit_code == 0 and json.loads(result.stdout)["note"] == ""


# The X-Y table


def test_the_table_drills_ten_holes_in_the_morning_without_a_host():
    bench = build("drill")
    table, holes = bench["table"], []
    table.pins["input1"].subscribe(lambda pin: holes.append(position(table)) if pin.level else None)
    bench.run(8)
    assert holes == []
    bench.run(30)
    forth = [(1600 * n, 0) for n in range(1, 6)]
    assert holes == forth + [(x, 1600) for x, _ in reversed(forth)]
    assert position(table) == (0, 0)


def position(table):
    return table.axes["X"].position, table.axes["Y"].position


def test_a_power_cut_between_two_holes_begins_the_sequence_again():
    bench = build("drill")
    table = bench["table"]
    bench.faults.add("power_cut", "table", when="X passes 4000", here="table", duration=5)
    bench.run(38)
    assert table.axes["X"].position == 4000, "on the very pulse; then it waits for the button"
    table.pins["input2"].drive(True)
    bench.run(1)
    assert table.axes["X"].position == 4000 + 1600


# The winder


def test_the_winder_lays_three_layers_and_keeps_its_place():
    bench = build("winder")
    motor, turned = bench["traverse"].axes["motor"], []
    motor.on_motion.subscribe(lambda: turned.append(motor.position))
    bench.run(13)
    assert motor.position == 0
    assert max(turned) == 12_506, "the sum of the velocities, 20/3 pulses/s for 50 ms each"
    assert len(motor.pulse_times()) == 6 * 12_506
    bench.run(1.5)
    assert motor.position > 0, "somebody has knocked against it"
    bench.run(5)
    assert abs(motor.encoder.count) <= 1 and motor.position == pytest.approx(120 * 6.25, abs=6.25 * 3)


def test_a_winder_that_jams_loses_pulses_and_the_encoder_knows():
    bench = build("winder")
    motor = bench["traverse"].axes["motor"]
    bench.faults.add("jam", "traverse.motor", when="motor passes 5000", here="traverse", duration=0.2)
    bench.run(11)
    assert motor.pulses == 0
    assert motor.position == -3500, "seven rotor teeth"
    assert motor.encoder.count == pytest.approx(motor.position / 6.25, abs=3)
    bench.run(8.5)
    assert motor.encoder.count == pytest.approx(-560, abs=1), "it keeps the place at which it was told to"


# The cut-to-length line


def test_the_knife_turns_once_for_each_length():
    bench = build("cut-to-length")
    feeder, knife = bench["feeder"].axes["X"], bench["knife"].axes["shaft"]
    cuts = []
    knife.subscribe_edges([1000 + 2000 * n for n in range(12)], lambda: cuts.append(feeder.position))
    bench.run(14)
    assert (feeder.position, knife.position) == (12 * 800, 12 * 2000)
    assert cuts == pytest.approx([350 + 800 * n for n in range(12)], abs=5), "half a turn by the cam"
    assert bench["knife"].serial.read() == b"turned 24000\r" and bench["feeder"].serial.read() == b"U\r0\r800\r"


def test_a_jammed_knife_stops_the_feeder():
    bench = build("cut-to-length")
    feeder, knife = bench["feeder"], bench["knife"]
    fault = bench.faults.add("jam", "knife.shaft", when="knife.shaft passes 9500")
    bench.run(14)
    assert knife.serial.read() == b"fault at %d\r" % knife.axes["shaft"].position
    assert feeder.serial.read().startswith(b"U\r32\r"), "emergency stop"
    assert not feeder.pins["estop"].level
    assert feeder.axes["X"].position < 4 * 800 + 800, "within the length at which it happened"
    assert fault.on


def test_a_feeder_without_a_ready_knife_waits():
    bench = build("cut-to-length")
    bench.faults.add("stuck", "knife.G", level="high")
    bench.run(14)
    assert bench["feeder"].axes["X"].position == 0


def test_what_the_page_shows_is_printed(monkeypatch, capsys):
    monkeypatch.chdir(EXAMPLES / "cut-to-length")
    page = (EXAMPLES / "cut-to-length" / "README.md").read_text(encoding="utf-8")
    program, shown = re.findall(r"```(?:python)?\n(.*?)```", page, re.DOTALL)[1:]
    exec(compile(program, "README.md", "exec"), {})
    assert capsys.readouterr().out == shown


@pytest.mark.parametrize("name", SCENES)
def test_in_pieces_it_is_the_same(name):
    def course(steps):
        bench, seen = build(name), []
        for step in steps:
            bench.run(step)
        for controller in bench.controllers.values():
            seen += [(axis.position, axis.pulse_times().tolist()) for axis in controller.axes.values()]
        return seen

    assert course([9.0]) == course([0.1] * 90)
