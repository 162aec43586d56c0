"""Installation: fault disable links, emergency stop and limit inputs, optional fault output."""

import pytest

from axistwin.core.units import MS

from ..scripts import scripts
from .talking import at_speed, command, edges, moving, play, positions, ready, times, write

# Emergency stop


@scripts({
    'Emergency stop: "can be used to inhibit all movement"; all inputs "must remain connected to +24v"':
    "estop low; X10$; Y-10$; ZG$; 1 s; at 0 0 0",
    'Clearing faults: "will again give "32 <CR>"" once removed, "but this time the fault bit will be cleared"':
    "estop low; 0.1 s; K: 32; K: 32; estop released; 0.1 s; X10$; 0.1 s; X at 0; K: 32; K: 0; K: 0; X10$; idle; "
    "X at 10",
    'Emergency stop: "inhibit all movement"': "XY-ZG$; 1 s; estop low; 0.1 s; still; estop released; 5 s; still",
    'Emergency stop: "would normally be a latching-type switch"; the fault is latched anyway':
    "XG$; 1 s; estop low; 0.01 s; estop released; 1 s; still; K: 32",
    'Clearing faults: "using either the Motion Status ("K") or Quick Status ("Q") commands"':
    "estop low; 0.1 s; Q: 32; estop released; 0.1 s; Q: 32; Q: 0; K: 0; led is low",
    "Emergency stop: the move that waits must not begin":
    "H1X10$; 0.1 s; estop low; 0.1 s; input1 high; 1 s; X at 0",
    'Clearing faults: "If a fault, emergency stop or limit condition arises, any axis in motion will stop"':
    "X-G$; 1 s; limit_plus low; 1 s; X runs at 0",
    "Limits: the LED goes off when status has been read *and* the input removed":
    "XG$; 0.5 s; limit_plus low; 0.1 s; limit_plus released; 0.1 s; led is high; K: 64; led is low",
    'Limits: "They must remain connected to +24v for the interface to run"':
    "limit_plus low; limit_minus low; 0.1 s; K?; X10$; 0.3 s; X-10$; 0.3 s; K?; X10$; 0.3 s; X-10$; "
    "0.3 s; X at 0",
    "Limits: they are in series for all axes: a message that asks for a blocked direction is refused":
    "limit_plus low; 0.1 s; K?; X-Y+10$; 0.5 s; Y at 0",
    'R27: "any fault, limit or emergency stop condition"; communication faults do not stop motion':
    "?; 0.1 s; K: 128; led is low",
    'Report-back: "The interface can be interrogated to establish its status at any time"':
    "estop low; 0.1 s; E: F; N: 0; K: 32; F: 0",
    'Fault disable links: "To simulate a working drive where none is fitted, fit link 3 ... and link 4"':
    "I: 200; K: 0",  # only inputs 1 to 3 are set
    'Clearing faults: "further movement is inhibited": outputs are no movement':
    "estop low; 0.1 s; S3$; 0.1 s; output3 is high",
    'Input status: "all inputs return their corresponding value when there is NO current in the diode"':
    "{estop|x_fault|y_fault|limit_plus|limit_minus} low; I: {201|202|204|216|232}",
})  # fmt: skip
def test_stop_inputs_limits_and_led(bench, if1, script):
    play(bench, if1, script)


@scripts({
    'Emergency stop: the inputs "must remain connected to +24v for the interface to run", at power-up, too':
    "estop low; 1.5 s; ( -> U<CR>; U61; 1.2 s; X10$; 0.5 s; at 0 0 0; K: 32; estop released; 0.1 s; K: 32; "
    "X10$; idle; at 10 0 0",
    'Fault disable links: "a logic low on the X and Y axis fault inputs even if no drive is connected"':
    "y_fault low; 1.5 s; ( -> U<CR>; U61; 1.2 s; K: 16; X10$; 0.5 s; K: 16; Z10$; 0.5 s; K: 16; at 0 0 0; "
    "led is high",
})  # fmt: skip
def test_inputs_that_are_open_at_power_up(bench, script):
    play(bench, bench.add("if1"), script)


@pytest.mark.parametrize("message", ["X@1000G$", "X90000@1000$"])
@pytest.mark.parametrize(("pin", "decelerating", "then"), [("estop", 41, 32), ("limit_plus", 73, 0)])
def test_a_stop_input_in_motion_decelerates(bench, if1, message, pin, decelerating, then):
    """Motion status: "41 would indicate the interface has had an emergency stop and is decelerating".

    Quick status: 73 "indicate[s] that a limit input has appeared whilst an axis is in motion and decelerating"; this
    request has cleared it.  Clearing: "any axis in motion will stop": from 1000 to 400 in levels of 10 ms, 9 + 8 + 7 +
    6 + 5 + 4 = 39 steps in 60 ms.
    """
    write(if1, message)
    assert at_speed(bench, if1) == 1000
    axis, at_ns = if1.axes["X"], bench.now
    if1.pins[pin].drive(False)
    assert bench.run_until(lambda: axis.velocity < 1000, 0.01)
    before = axis.position
    play(bench, if1, f"K: {decelerating}; 1 s; X at {before + 39}; K: {then}")
    assert 57 * MS <= times(axis)[-1] - at_ns <= 61 * MS


# Limits


@pytest.mark.parametrize(("pin", "blocked", "free"), [("limit_plus", "+", "-"), ("limit_minus", "-", "+")])
def test_an_open_limit_lets_the_interface_be_driven_the_other_way_only(bench, if1, pin, blocked, free):
    """Limits: "can only be driven in the negative direction and vice versa after a status request has been made"."""
    play(bench, if1, f"X{blocked}4000$; 1 s; {pin} low; 0.1 s; still")
    stopped = if1.axes["X"].position
    assert 0 < abs(stopped) < 4000
    # before the status request even the other way is refused; then it is free, and the limits are common to all axes
    moves = "; ".join(f"{axis}{blocked}10$; 0.5 s" for axis in "XYZ")
    play(bench, if1, f"X{free}10$; 0.5 s; X at {stopped}; K: 64; {moves}; at {stopped} 0 0; K?; X{free}10$; 0.5 s")
    assert if1.axes["X"].position == stopped + int(free + "10")


def test_driven_off_the_limit_no_further_request_is_needed(bench):
    """Clearing faults: "driven off the limit in the opposite direction and no further status request need be made"."""
    if1 = ready(bench, X={"limits": (-100, 100)})
    command(bench, if1, "X4000$", seconds=2)
    stopped = if1.axes["X"].position
    assert 100 < stopped <= 105
    play(bench, if1, f"K: 64; X-50$; X20$; 1 s; X at {stopped - 30}; K: 0")


# Drive faults


@pytest.mark.parametrize(("pin", "axis"), [("x_fault", "X"), ("y_fault", "Y")])
def test_a_drive_fault_halts_the_interface_without_deceleration(bench, if1, pin, axis):
    """Fault disable links: "will halt the interface in the event of a drive fault"; "no deceleration occurs"."""
    write(if1, f"{axis}@5000G$")
    at_speed(bench, if1, axis)
    at_ns = bench.now
    halted = f"{pin} low; 0.002 s; {axis} at rest; led is high; E: F; K: 16; Z10$; 0.5 s; Z at 0; "  # no axis may move
    play(bench, if1, halted + f"{pin} released; K: 16; K: 0; led is low; Z10$; 0.5 s; Z at 10")
    assert times(if1.axes[axis])[-1] <= at_ns + 1 * MS


def test_the_other_axes_stop_on_their_ramp(bench, if1):
    """Position report: "no deceleration occurs on that axis"; clearing faults: "any axis in motion will stop"."""
    write(if1, "XYZ@1000G$")
    at_speed(bench, if1)
    before = if1.axes["Y"].position
    if1.pins["x_fault"].drive(False)
    bench.run(0.005)
    assert not if1.axes["X"].moving and if1.axes["Y"].moving and if1.axes["Z"].moving
    bench.run(1)
    assert not moving(if1) and 39 <= if1.axes["Y"].position - before <= 42
    assert if1.axes["Y"].position == if1.axes["Z"].position > if1.axes["X"].position


def test_the_pulse_of_the_nanosecond_of_a_drive_fault_stays_made(bench, if1):
    """15 pulses in 30 ms of ramp; the 334th is due 319/700 s later, 0.71 ns after the begin of its nanosecond."""
    write(if1, "X1000@700$")
    at_speed(bench, if1)
    axis = if1.axes["X"]
    bench.clock.run_to(axis.train.move.start_ns + 485_714_285)
    assert axis.position == 334
    if1.pins["x_fault"].drive(False)
    bench.run(0.1)
    assert axis.position == 334


def test_the_other_outputs_are_not_touched_by_faults(bench, if1):
    """Optional fault output: with link 3 in position a, output 5 is an ordinary output, which faults do not change."""
    command(bench, if1, "S15$", seconds=0.1)
    seen = [edges(if1.pins[f"output{n}"]) for n in range(1, 6)]
    if1.pins["estop"].drive(False)
    bench.run(0.5)
    assert seen == [[]] * 5


def test_the_run_time_of_a_stop_is_one_scan(bench, if1):
    """Emergency stop: the motion is stopped within one scan of the inputs, 2 ms."""
    command(bench, if1, "XG$", seconds=1)
    begin = bench.now
    if1.pins["estop"].drive(False)
    assert bench.run_until(lambda: not moving(if1), 0.01) and bench.now - begin <= 2 * MS


def test_the_limit_switches_of_all_axes_are_in_series(bench):
    """Limits: "Where more than one axis is used, connect the limit switches in series": Y's switch stops X as well."""
    if1 = ready(bench, X={"limits": (-1000, 1000)}, Y={"limits": (-1000, 30)})
    command(bench, if1, "XY+500$", seconds=3)
    x, y, _ = positions(if1)
    assert x == y and 30 < y <= 35
    play(bench, if1, f"K: 64; X+10$; 0.5 s; X at {x}")  # X itself is far from its limit
