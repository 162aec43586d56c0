"""Drawings of axes: travel, limit switches, brakes and faults."""

import re
from fractions import Fraction

from axistwin import Bench
from axistwin.sim.motion.profile import Profile, Segment
from axistwin.ui.panel.drawings.picture import Picture
from axistwin.ui.panel.views.machines import machines

from .showing import shown

SLIDE = {"limits": (-100, 1000)}
slide = shown(machines, "if1", X=SLIDE)


def go(axis, pulses, rate=1000):
    axis.start(Profile([Segment(Fraction(rate), Fraction(abs(pulses), rate))]), 1 if pulses > 0 else -1)


def seen(visit, axis):
    """Return all values in the drawing of an axis, by part and property."""
    return visit.found(f"axis {axis}").drawing.shown


def written(visit, axis, *parts):
    shown = seen(visit, axis)
    return [shown[part, "text"] for part in parts]


def place(visit, axis, part):
    """Return the first number in the CSS transform of a part: pixels or degrees."""
    return float(re.search(r"-?[\d.]+", seen(visit, axis)[part, "move"])[0])


def drawn(visit):
    """Return the names of those axes of an IF1 that are on the page."""
    figures = visit.user.find(kind=Picture).elements
    return [axis for axis in "XYZ" if any(f"if1.{axis}" in figure._markers for figure in figures)]


@slide
def test_a_slide_tells_position_and_velocity_and_its_carriage_moves_along(visit):
    axis = visit.bench["if1"].axes["X"]
    assert written(visit, "if1.X", "position", "velocity") == ["0", "0"]
    left = place(visit, "if1.X", "carriage")
    go(axis, 1000)
    visit.run(0.5)
    assert written(visit, "if1.X", "position", "velocity", "behind") == ["500", "+1\u2009000", "0"]
    middle = place(visit, "if1.X", "carriage")
    visit.run(1)
    assert written(visit, "if1.X", "position", "velocity") == ["1\u2009000", "0"]
    assert place(visit, "if1.X", "carriage") - middle == middle - left > 0


@slide
def test_a_limit_switch_lights_when_it_opens(visit):
    axis = visit.bench["if1"].axes["X"]
    for pulses, lit in ((1000, None), (1, "plus"), (-1101, None), (-1, "minus")):
        go(axis, pulses)
        visit.run(2)
        assert [side for side in ("minus", "plus") if seen(visit, "if1.X")[side, ".lit"]] == ([lit] if lit else [])
        assert written(visit, "if1.X", "minus-word", "plus-word").count("open") == bool(lit)


@slide
def test_beyond_the_end_of_the_bed_the_carriage_stays_on_it(visit):
    go(visit.bench["if1"].axes["X"], 100_000, 100_000)
    visit.run(2)
    assert place(visit, "if1.X", "carriage") < 300 and written(visit, "if1.X", "position") == ["100\u2009000"]


@slide
def test_lost_pulses_leave_a_ghost_where_the_carriage_should_be(visit):
    axis = visit.bench["if1"].axes["X"]
    assert not seen(visit, "if1.X")["ghost", ".there"]
    axis.jam()
    go(axis, 400)
    visit.run(0.2)
    assert written(visit, "if1.X", "states") == ["jammed \u00b7 out of step"]
    visit.run(1)
    assert written(visit, "if1.X", "position", "behind", "states") == ["0", "+400", "jammed"]
    assert place(visit, "if1.X", "ghost") > place(visit, "if1.X", "carriage")
    assert all(seen(visit, "if1.X")[what] for what in (("ghost", ".there"), ("row-behind", ".wrong")))
    assert seen(visit, "if1.X")["machine", ".jammed"]


@shown(machines, "1811", motor={**SLIDE, "home": (-10, 10), "encoder": {"counts_per_rev": 4000, "pulses_per_rev": 400}})
def test_a_board_has_a_home_switch_and_an_encoder(visit):
    assert seen(visit, "1811.motor")["home", ".lit"]
    go(visit.bench["1811"].axes["motor"], 400)
    visit.run(1)
    assert not seen(visit, "1811.motor")["home", ".lit"] and written(visit, "1811.motor", "encoder") == ["4\u2009000"]


@slide
def test_faults_of_an_axis_and_of_its_drive_are_named(visit):
    bench = visit.bench
    bench.faults.add("drive_fault", "if1.X", name="amplifier")
    visit.run(0.1)
    assert written(visit, "if1.X", "states") == ["drive fault \u00b7 fault: amplifier"]
    bench.faults.mend("amplifier")
    visit.run(0.1)
    assert written(visit, "if1.X", "states") == [""]


@slide
def test_axes_that_nobody_uses_are_not_drawn_until_they_move(visit):
    assert drawn(visit) == ["X"]
    go(visit.bench["if1"].axes["Z"], 5)
    visit.run(1)
    assert drawn(visit) == ["X", "Z"]
    go(visit.bench["if1"].axes["Z"], -5)
    visit.run(1)
    assert drawn(visit) == ["X", "Z"]  # a switch below must not move under the pointer


@shown(machines, "if1")
def test_where_nobody_has_said_anything_all_are_drawn(visit):
    for axis in "XYZ":
        assert written(visit, f"if1.{axis}", "position") == ["0"]
    go(visit.bench["if1"].axes["X"], 5)
    visit.run(1)
    assert drawn(visit) == ["X", "Y", "Z"]


@shown(machines, "if1", X={"motor": {"torque": [[0, 1.0], [5000, 0.5]], "pulses_per_rev": 200}})
def test_a_shaft_turns_by_its_motors_pulses_a_turn(visit):
    go(visit.bench["if1"].axes["X"], 450)
    visit.run(0.225)
    assert place(visit, "if1.X", "disc") == 405.0 and written(visit, "if1.X", "turns", "rpm") == ["1 + 45.0°", "+300"]


@shown(machines, "if1")
def test_where_the_pulses_of_a_turn_are_not_known_no_turns_are_told(visit):
    assert ("turns", "text") not in seen(visit, "if1.X")
    assert "400 pulses a turn assumed" in visit.found("axis if1.X").props["art"]


SERVO = {"motor": "frame23", "load": {"inertia_kg_m2": 1e-4}}


@shown(machines, "smartmotor", shaft=SERVO, brake=True, line="instant")
def test_a_servo_shows_where_it_should_be_its_brake_and_its_temperature(visit):
    motor, name = visit.bench["smartmotor"], "smartmotor.shaft"
    visit.run(1)
    assert seen(visit, name)["brake", ".engaged"]
    assert written(visit, name, "brake-word", "temperature") == ["brake holds", "25.0"]
    motor.serial.write(b"UCI UDI ZS A=500 V=200000 P=20000 G ")
    visit.run(0.2)
    assert not seen(visit, name)["brake", ".engaged"] and written(visit, name, "brake-word") == ["brake released"]
    axis = motor.axes["shaft"]
    assert place(visit, name, "disc") == round(360 * axis.position / 2000, 1)
    assert place(visit, name, "ghost") == round(360 * axis.setpoint / 2000, 1) > place(visit, name, "disc")
    assert axis.setpoint - axis.position == int(written(visit, name, "behind")[0])


def with_a_wheel():
    bench = Bench()
    bench.add("if1", "if1", X={"motor": {"torque": [[0, 1.0], [5000, 0.5]], "pulses_per_rev": 200}})
    bench.add("smartmotor", "smartmotor")
    return bench


@shown(machines, "smartmotor", build=with_a_wheel)
def test_a_measuring_wheel_is_drawn_when_there_is_one_and_tells_on_what_it_sits(visit):
    bench, name = visit.bench, "smartmotor.shaft"
    assert not seen(visit, name)["wheel", ".there"]
    bench["smartmotor"].master.follow(bench["if1"].axes["X"], 5)
    go(bench["if1"].axes["X"], 100)
    visit.run(1)
    assert seen(visit, name)["wheel", ".there"] and written(visit, name, "edges", "sits-on") == ["500", "on if1.X"]
    assert place(visit, name, "tyre") == 180.0


@shown(machines, "smartmotor", shaft={**SERVO, "limits": (-100, 9000)}, line="instant")
def test_a_servo_with_travel_is_a_slide_with_a_brake(visit):
    motor, name = visit.bench["smartmotor"], "smartmotor.shaft"
    visit.run(1)
    assert written(visit, name, "brake", "temperature") == ["holds", "25.0"]
    assert seen(visit, name)["row-edges", ".unused"]
    motor.serial.write(b"A=500 V=400000 P=5000 G ")
    visit.run(0.2)
    assert written(visit, name, "brake") == ["released"]
    assert place(visit, name, "ghost") > place(visit, name, "carriage")
    motor.master.move(300, 0)
    visit.run(0.1)
    assert (written(visit, name, "edges"), seen(visit, name)["row-edges", ".unused"]) == (["300"], False)


@shown(machines, "if1", X={**SLIDE, "units": {"per": 80, "of": "mm"}})
def test_an_axis_with_a_unit_shows_it_and_the_pulses_last(visit):
    go(visit.bench["if1"].axes["X"], -30)
    visit.run(0.02)
    assert written(visit, "if1.X", "place", "speed") == ["\u22120.25", "\u221212.50"]
    assert written(visit, "if1.X", "position", "target") == ["\u221220", "\u22120.38"]
