"""The stepper axis: ideal, or with a torque curve beyond which it loses whole rotor teeth."""

from fractions import Fraction

import pytest

from axistwin.core.errors import UsageError
from axistwin.plant.axes import stepper_axis
from axistwin.plant.encoder import EncoderData
from axistwin.plant.stepper import StepperAxis
from axistwin.plant.torque import Load, StepperMotor
from axistwin.sim.clock import Clock
from axistwin.sim.motion.profile import Profile, Segment

S = 10**9

MOTOR = StepperMotor(torque=((0, 1.0), (1000, 1.0), (2000, 0.2)), pull_in=500, pulses_per_rev=400, rotor_teeth=50)
"""1 N·m up to 1000 pulses/s, then falling; 8 pulses are one rotor tooth."""


def rates(*segments):
    """Return a profile of segments, each given as (pulses/s, pulses)."""
    return Profile([Segment(Fraction(rate), Fraction(pulses, rate)) for rate, pulses in segments])


@pytest.fixture
def clock():
    return Clock()


def axis_with(clock, **options):
    return StepperAxis(clock, "X", **options)


def test_without_a_motor_it_is_ideal(clock):
    axis = axis_with(clock)
    axis.start(rates((100, 50)), -1)
    clock.run_to(S)
    assert (axis.position, axis.pulses, axis.velocity, axis.moving) == (-50, -50, 0.0, False)
    assert len(axis.pulse_times()) == 50


def test_velocity_has_the_sign_of_the_direction(clock):
    axis = axis_with(clock)
    axis.start(rates((100, 50)), -1)
    clock.run_to(S // 10)
    assert axis.velocity == -100.0


def test_within_its_curve_it_follows(clock):
    axis = axis_with(clock, motor=MOTOR, load=Load(torque=0.9))
    axis.start(rates((400, 40), (1000, 100), (400, 40)), +1)
    clock.run_to(S)
    assert axis.position == axis.pulses == 180


def test_beyond_the_curve_it_stands_and_loses_whole_teeth(clock):
    """At 1750 pulses/s the curve gives 0.4 N·m, and the load needs 0.5: the rotor stops for 101 pulses.

    It falls into step again at 400 pulses/s.  101 pulses are 12.6 teeth of 8, so thirteen teeth, 104 pulses, are lost.
    """
    axis = axis_with(clock, motor=MOTOR, load=Load(torque=0.5), encoder=EncoderData(4000, 400))
    axis.start(rates((400, 40), (1750, 101), (400, 40)), +1)
    clock.run_to(S // 10 + S * 50 // 1750)
    assert axis.position == 40
    clock.run_to(S)
    assert axis.pulses == 181 and axis.position == 181 - 104
    assert axis.encoder.count == 10 * (181 - 104)


def test_a_start_above_the_pull_in_rate_fails(clock):
    axis = axis_with(clock, motor=MOTOR)
    axis.start(rates((800, 80)), +1)
    clock.run_to(S)
    assert axis.pulses == 80 and axis.position == 0


def test_a_start_failed_by_an_odd_number_of_pulses_settles_at_a_tooth(clock):
    """83 pulses are 10.4 teeth: ten teeth are lost, and the rotor settles three pulses further."""
    axis = axis_with(clock, motor=MOTOR)
    axis.start(rates((800, 83)), +1)
    clock.run_to(S)
    assert axis.position == 3


def test_inertia_asks_for_torque_while_accelerating(clock):
    """400 to 900 pulses/s in 0.1 s are 78.54 rad/s²; 0.001 kg·m² then need 0.0785 N·m.

    With 0.95 N·m of friction this is more than the motor's 1 N·m.
    """
    profile = rates((400, 40), (900, 90), (400, 40))
    heavy = axis_with(clock, motor=MOTOR, load=Load(torque=0.95, inertia=1e-3))
    light = axis_with(clock, motor=MOTOR, load=Load(torque=0.95, inertia=1e-4))
    for axis in (heavy, light):
        axis.start(profile, +1)
    clock.run_to(S)
    assert light.position == 170
    assert heavy.position == 170 - 88  # 90 pulses are 11.25 teeth


def test_a_load_step_in_the_middle_of_a_move(clock):
    """A torque holds the motor from 0.1 s (40 pulses) to 0.2 s (80 pulses): 40 pulses, five teeth, are lost."""
    axis = axis_with(clock, motor=MOTOR)
    axis.start(rates((400, 200)), +1)
    clock.run_to(S // 10)
    axis.load(-3.0)
    clock.run_to(S // 5)
    assert axis.position == 40
    axis.load(0.0)
    clock.run_to(S)
    assert (axis.pulses, axis.position) == (200, 160)


def test_a_jammed_shaft_stands_while_pulses_go_on_also_without_motor_data(clock):
    axis = axis_with(clock)
    axis.start(rates((100, 50)), +1)
    clock.run_to(S // 10)
    axis.jam(True)
    clock.run_to(S // 5)
    axis.jam(False)
    clock.run_to(S)
    assert (axis.pulses, axis.position) == (50, 40)


def test_a_jammed_shaft_with_motor_data_turns_only_when_it_is_free(clock):
    """83 pulses are 10.4 teeth: the rotor does not move; when released, it settles three pulses away."""
    axis = axis_with(clock, motor=MOTOR)
    axis.jam(True)
    axis.start(rates((400, 83)), +1)
    clock.run_to(S)
    assert (axis.position, axis.lost) == (0, 83)
    axis.jam(False)
    assert (axis.position, axis.lost) == (3, 80)
    axis.jam(True)
    assert (axis.position, axis.lost) == (3, 80)


@pytest.mark.parametrize("direction", [+1, -1])
def test_single_pulses_do_not_turn_a_jammed_shaft_either(clock, direction):
    """13 single pulses, as from a joystick, are 1.6 teeth; the jammed shaft does not turn."""
    axis = axis_with(clock, motor=MOTOR)
    axis.jam(True)
    for n in range(1, 14):
        axis.start(rates((1000, 1)), direction)
        clock.run_to(n * S // 100)
        assert axis.position == 0
    axis.jam(False)
    assert axis.position == -3 * direction


def test_what_has_settled_stays_there_when_it_is_jammed_later(clock):
    axis = axis_with(clock, motor=MOTOR)
    axis.start(rates((800, 83)), +1)
    clock.run_to(S)
    axis.jam(True)
    assert axis.position == 3


def test_what_was_lost_stays_lost_in_later_moves(clock):
    axis = axis_with(clock, motor=MOTOR)
    axis.start(rates((800, 80)), +1)
    clock.run_to(S)
    axis.start(rates((400, 80)), -1)
    clock.run_to(2 * S)
    assert (axis.pulses, axis.position) == (0, -80)


@pytest.mark.parametrize("with_numpy", [True, False])
def test_positions_in_a_move_can_be_predicted(clock, with_numpy, monkeypatch):
    """At 400 pulses/s, pulse n is issued after n times 2.5 ms; a browser has no NumPy."""
    monkeypatch.setattr("axistwin.plant.stepper.installed", lambda _: with_numpy)
    axis = axis_with(clock, motor=MOTOR)
    axis.start(rates((800, 80)), +1)  # the motor loses all these pulses
    clock.run_to(S)
    axis.start(rates((400, 80)), -1)
    times_ns = [S, S + 2_499_999, S + 2_500_000, S + 100 * 10**6, 2 * S]
    assert axis.positions_at(times_ns) == [0, 0, -1, -40, -80]


def test_halting_ends_the_pulses_at_once(clock):
    axis = axis_with(clock)
    axis.start(rates((100, 50)), +1)
    clock.run_to(S // 10 + 1)
    axis.halt()
    clock.run_to(S)
    assert axis.position == 10


def test_an_encoder_behind_backlash_lags_after_a_reversal(clock):
    """At one count per pulse and a backlash of 5, the load lags by 5 forwards, and rests for 5 counts backwards."""
    axis = axis_with(clock, encoder=EncoderData(400, 400, backlash=5))
    counts = []
    for direction, pulses in ((+1, 20), (-1, 3), (-1, 7), (+1, 4)):
        axis.start(rates((100, pulses)), direction)
        clock.run_to(clock.now + S)
        counts.append(axis.encoder.count)
    assert counts == [15, 15, 10, 10]


def test_a_pushed_load_is_seen_by_the_encoder_only(clock):
    axis = axis_with(clock, encoder=EncoderData())
    axis.encoder.displace(-7)
    assert (axis.encoder.count, axis.position) == (-7, 0)


def test_asking_for_an_encoder_that_is_not_there_says_how_to_add_one(clock):
    with pytest.raises(UsageError, match="axis X has no encoder: add the option `encoder` to the axis"):
        _ = axis_with(clock).encoder


def test_what_the_motor_has_lost_and_whether_it_is_out_of_step(clock):
    """At 1750 pulses/s the rotor stops for 101 pulses; thirteen teeth of 8 are lost, 104 pulses."""
    axis = axis_with(clock, motor=MOTOR, load=Load(torque=0.5))
    axis.start(rates((400, 40), (1750, 100), (400, 40)), +1)
    clock.run_to(S // 20)
    assert (axis.lost, axis.stalled) == (0, False)
    clock.run_to(S // 8)
    assert axis.stalled and axis.lost == axis.pulses - axis.position > 0
    clock.run_to(S)
    assert (axis.lost, axis.stalled) == (104, False)


def test_a_jammed_shaft_is_out_of_step_while_pulses_go_out(clock):
    axis = axis_with(clock)
    axis.jam()
    assert not axis.stalled
    axis.start(rates((100, 50)), -1)
    clock.run_to(S // 10)
    assert (axis.stalled, axis.lost) == (True, -10)
    clock.run_to(S)
    assert (axis.stalled, axis.lost) == (False, -50)


@pytest.mark.parametrize(("options", "per_rev"), [
    ({}, None), ({"motor": MOTOR}, 400), ({"encoder": EncoderData(counts_per_rev=4000, pulses_per_rev=25_000)}, 25_000),
    ({"motor": MOTOR, "encoder": EncoderData(pulses_per_rev=25_000)}, 400)])  # fmt: skip
def test_how_many_pulses_are_a_turn(clock, options, per_rev):
    """The pulses of a revolution are those of the motor's or the encoder's data sheet; otherwise unknown."""
    assert axis_with(clock, **options).per_rev == per_rev


def test_its_travel_and_its_encoder_are_told(clock):
    axis = stepper_axis(clock, "X", {"limits": [-100, 5000], "home": [0, 20], "encoder": {"backlash": 3}}, 10)
    assert (axis.limits, axis.home, axis.encoder.data) == ((-100, 5000), (0, 20), EncoderData(backlash=3))
    bare = stepper_axis(clock, "X", {}, 10)
    assert (bare.limits, bare.home) == (None, None)
