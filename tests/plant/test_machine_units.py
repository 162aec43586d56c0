"""Units of the machine: positions in mm, degrees or revolutions are exact fractions of counts."""

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench, Scene
from axistwin.cli.program import main
from axistwin.core.errors import SceneError, UsageError
from axistwin.plant.machine_units import MachineUnits, position, rate
from axistwin.records.traces.reading import read

MM = MachineUnits.given({"per": 80, "of": "mm"})


@pytest.mark.parametrize(("per", "text", "counts"), [
    (80, "12.5 mm", 1000), (80, "-0.0125mm", -1), (6.4, "10 mm", 64), (0.1, "30 mm", 3), ("2000/360", "90 mm", 500),
    ("400/2.5", "1 mm", 160), (80, "0.00625 mm", 0), (80, "0.01875 mm", 2), (80, "17", 17), (80, 17, 17)])  # fmt: skip
def test_a_position_is_the_nearest_count(per, text, counts):
    """A half is rounded to the even count."""
    assert position(text, MachineUnits.given({"per": per, "of": "mm"})) == counts


@settings(max_examples=50)
@given(counts=st.integers(-(10**9), 10**9), per=st.integers(1, 10**6), parts=st.integers(1, 1000))
def test_a_shown_position_is_the_same_count_when_read(counts, per, parts):
    units = MachineUnits.given({"per": f"{per}/{parts}", "of": "deg"})
    assert position(f"{units.shown(counts)} deg", units) == counts and MachineUnits.written(str(units)) == units


@pytest.mark.parametrize(("text", "units", "message"), [
    ("3 cm", MM, "'cm' is not the unit of the axis: expected mm"),
    ("3 mm", None, "unknown unit 'mm': use counts, or define the unit of the axis, e.g. units = { per = 80, of = "),
    ("3.5", MM, "invalid number of counts '3.5': expected e.g. 1000 or '12.5 mm'"),
    ("3 mm/s", MM, "'3 mm/s' is not a position: expected e.g. 1000 or '12.5 mm'"),
    ("1.2.3 mm", MM, "invalid number '1.2.3': expected a decimal number below 1e30"),
    ("mm", None, "'mm' is not a position: expected e.g. 1000"),
    ("999999999999999999 mm", MM, "is out of range: expected -9007199254740992 to 9007199254740992 counts")
])  # fmt: skip
def test_a_wrong_position_is_rejected(text, units, message):
    with pytest.raises(UsageError) as error:
        position(text, units)
    assert message in str(error.value)


def test_a_velocity():
    assert rate("50 mm/s", MM) == 4000 and rate(12, MM) == 12
    with pytest.raises(
        UsageError, match=r"'50 mm' is not a velocity: expected a number of counts/s, or a text, e\.g\. '50 mm/s'"
    ):
        rate("50 mm", MM)


SCENE = """
title = "units"
[[controller]]
model = "1811"
name = "t"
axes.motor = { units = { per = 80, of = "mm" }, limits = ["-1 mm", 20_000], home = [0, "0.5 mm"] }
[[controller]]
model = "smartmotor"
name = "m"
program = "p.sms"
axes.shaft = { units = { per = "2000/360", of = "°" }, limits = ["-90 °", "180°"] }
[[fault]]
kind = "jam"
on = "t.motor"
when = "m.shaft passes 45 ° up"
"""


@pytest.fixture
def directory(tmp_path):
    (tmp_path / "s.toml").write_text(SCENE)
    (tmp_path / "p.sms").write_text("UCI UDI ZS A=100 V=400000 MP O=0 P=300 G TWAIT END\n")
    return tmp_path


def test_a_scene_with_units(directory):
    bench = Scene.load(directory / "s.toml").build()
    motor, shaft = bench["t"].axes["motor"], bench["m"].axes["shaft"]
    assert (motor.limits, motor.home, shaft.limits) == ((-80, 20_000), (0, 40), (-500, 1000))
    passed = []
    bench.when("m.shaft passes 45°", lambda: passed.append(shaft.position))
    bench.run(1)
    assert passed == [250] and motor.jammed


@pytest.mark.parametrize(("old", "new", "message"), [
    ('"-1 mm"', '"-1 cm"', ":6:59: controller.axes.motor.limits: 'cm' is not the unit of the axis: expected mm"),
    ("per = 80", "per = 0",
     'units.per: invalid number of pulses or counts per unit: expected e.g. 80, 6.4 or "6400/360"'),
    ('"mm" }', '"m m" }',
     'units.of: invalid name of a unit: expected 1 to 12 letters (not "up" or "down"), e.g. "mm", not "m m"\n'),
    ("per = 80", "pre = 80", "'per' is missing: add per = …"),
    ("45 °", "45 mm",
     "invalid axis position in the event when='m.shaft passes 45 mm up': 'mm' is not the unit of the axis"),
    ('"-90 °"', '"-90"', None),
    ('"180°"', '"x"',
     ":11:56: invalid limits=['-90 °', 'x'] of axis shaft: 'x' is not a position: expected e.g. 1000 or '12.5 °"),
    ('"2000/360"', "true", "invalid units of axis shaft: invalid number of pulses or counts per unit")])  # fmt: skip
def test_a_wrong_scene_is_rejected(directory, old, new, message):
    assert old in SCENE
    (directory / "s.toml").write_text(SCENE.replace(old, new, 1))
    if message is None:
        assert Scene.load(directory / "s.toml").build()["m"].axes["shaft"].limits == (-90, 1000)
        return
    with pytest.raises(SceneError) as error:
        Scene.load(directory / "s.toml").build()
    assert message in f"{error.value}\n"


def test_reports_and_traces_have_both(directory, capsys):
    with pytest.raises(SystemExit):
        main(["run", str(directory / "s.toml"), "--for", "1", "--trace", str(directory / "a.vcd")])
    said = capsys.readouterr().out
    assert "shaft 0 → 300 (0.0 → 54.0 °), up to " in said
    axis, *_, last = said.splitlines()[-1].split("  ")
    assert (axis, last) == ("m.shaft", "0.0 → 54.0 °")
    about = read(directory / "a.vcd").about
    assert (about["units t.motor"], about["units m.shaft"]) == ("80 per mm", "50/9 per °")
    with pytest.raises(SystemExit):
        main(["run", str(directory / "s.toml"), "--for", "1", "--json"])
    data = json.loads(capsys.readouterr().out)
    assert data["axes"][1] == {
        "controller": "m", "axis": "shaft", "position": 300, "commanded": 300, "unit": "°", "position_in_unit": 54.0,
    }  # fmt: skip
    move = data["moves"][0]
    assert (move["to"], move["to_in_unit"]) == (300, 54.0)
    assert move["top_rate_in_unit"] == pytest.approx(move["top_rate"] * 0.18)


def test_a_plot_has_two_scales(directory):
    from matplotlib.figure import Figure

    from axistwin.records.plots import picture
    from axistwin.records.plots.trace_chart import of_trace

    with pytest.raises(SystemExit):
        main(["run", str(directory / "s.toml"), "--for", "1", "--trace", str(directory / "a.csv")])
    chart = of_trace(read(directory / "a.csv"))
    labels = [(panel.label, panel.counts) for panel in chart.panels]
    assert labels == [
        ("m.shaft  velocity\n°/s", "counts/s"),
        ("m.shaft  position\n°", "counts"),
        ("m.shaft  following\nerror, °", "counts"),
    ]
    assert chart.panels[1].lines[0].curve.values[-1] == pytest.approx(54.0)
    figure = picture._Picture(chart).draw(Figure())
    figure.draw_without_rendering()
    right = figure.axes[1].child_axes[0]
    assert right.get_ylim() == pytest.approx([end * 2000 / 360 for end in figure.axes[1].get_ylim()])


def test_a_bench_with_units():
    bench = Bench()
    bench.add("if1", X={"units": {"per": 80, "of": "mm"}, "limits": ("-1 mm", "20 mm")})
    assert bench["if1"].axes["X"].limits == (-80, 1600)
    for wrong in ({"units": {"per": 80}}, {"units": 3}, {"limits": ("-1 mm", "20 mm")}):
        with pytest.raises(UsageError, match="axis X"):
            bench.add("if1", "other", X=wrong)


STAND_IN = """
[[controller]]
model = "if1"
axes.X = { units = { per = 80, of = "mm" } }
[stand-in]
[[stand-in.board]]
name = "uno"
port = "/dev/ttyUSB0"
[[stand-in.axis]]
axis = "if1.X"
step = "PD2"
direction = "PD5"
enable = "PB0"
travel = ["-1 mm", "290 mm"]
max_rate = "50 mm/s"
"""


def test_the_bounds_of_a_stand_in(tmp_path):
    from axistwin.real.standin import reading

    (tmp_path / "s.toml").write_text(STAND_IN)
    scene = Scene.load(tmp_path / "s.toml")
    ((_, wiring),) = reading.read(scene, scene.build()).boards
    assert (wiring.axes[0].travel, wiring.axes[0].max_rate) == ((-80, 23_200), 4000)
    for old, new, message in (
        ("290 mm", "290 cm", ":14:1: 'cm' is not the unit of the axis: expected mm"),
        (
            "50 mm/s",
            "50 mm",
            ":15:1: '50 mm' is not a velocity: expected a number of counts/s, or a text, e.g. '50 mm/s'",
        ),
        (
            '"50 mm/s"',
            "-3",
            (
                ":15:1: stand-in.axis.max_rate: "
                "expected a step rate or velocity above 0, e.g. 4000 (pulses/s) or '50 mm/s', not -3"
            ),
        ),
        (
            '"-1 mm"',
            "1.5",
            (
                ":14:11: stand-in.axis.travel: invalid travel limit: "
                "expected a whole number of pulses or a text with a unit, e.g. 1000 or '12.5 mm', not 1.5"
            ),
        ),
    ):
        (tmp_path / "s.toml").write_text(STAND_IN.replace(old, new))
        with pytest.raises(SceneError) as error:
            reading.read(scene := Scene.load(tmp_path / "s.toml"), scene.build())
        assert str(error.value).endswith(message)
