"""Installation: fault disable links, emergency stop and limit inputs, optional fault output."""

import pytest

from axistwin.units import MS

from .talking import ask, at_speed, command, edges, moving, play, ready, scripts, write


def motion_status(bench, if1) -> int:
    return int(ask(bench, if1, "K", 0.02))


# Emergency stop


@scripts(
    {
        'Emergency stop: "can be used to inhibit all movement"; all inputs "must remain connected to +24v"':
        "estop low; X10$; Y-10$; ZG$; 1 s; at 0 0 0",
        'Emergency stop: "a Motion Status request must be made before the system can be restarted"':
        "estop low; 0.1 s; estop released; X10$; 1 s; X at 0; K: 32; X10$; 1 s; X at 10",
        'Clearing faults: 32, then "a further status request will again give "32 <CR>"", then 0':
        "estop low; 0.1 s; K: 32; K: 32; estop released; 0.1 s; X10$; 0.1 s; X at 0; K: 32; K: 0; K: 0",
        'Emergency stop: "inhibit all movement"': "XY-ZG$; 1 s; estop low; 0.1 s; still; estop released; 5 s; still",
        'Emergency stop: "would normally be a latching-type switch"; the fault is latched anyway':
        "XG$; 1 s; estop low; 0.01 s; estop released; 1 s; still; K: 32",
        'Clearing faults: "using either the Motion Status ("K") or Quick Status ("Q") commands"':
        "estop low; 0.1 s; estop released; 0.1 s; Q: 32; Q: 0; led is low",
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
        'Clearing faults: "further movement is inhibited": outputs are no movement':
        "estop low; 0.1 s; S3$; 0.1 s; output3 is high",
    }
)  # fmt: skip
def test_stop_inputs_limits_and_led(bench, if1, script):
    play(bench, if1, script)


def test_an_emergency_stop_in_motion_decelerates(bench, if1):
    """Motion status: "41 would indicate the interface has had an emergency stop and is decelerating"."""
    write(if1, "X@1000G$")
    assert at_speed(bench, if1) == 1000
    axis = if1.axes["X"]
    if1.pins["estop"].drive(False)
    assert bench.run_until(lambda: axis.velocity < 1000, 0.01)
    before = axis.position
    assert motion_status(bench, if1) == 41
    bench.run(1)
    assert axis.position == before + 39  # the ramp of 60 ms
    assert motion_status(bench, if1) == 32


def test_the_led_lights_from_the_emergency_stop_until_it_is_read_and_removed(bench, if1):
    """Emergency stop: the LED "will turn off after Motion Status has been read and the input removed"."""
    led = if1.pins["led"]
    assert not led.level
    if1.pins["estop"].drive(False)
    bench.run(0.01)
    assert led.level and not led.flashing
    motion_status(bench, if1)
    assert led.level  # the status was read, but the input is still open
    if1.pins["estop"].release()
    bench.run(0.1)
    assert led.level  # the input was removed, but the status not read again
    motion_status(bench, if1)
    assert not led.level


def test_an_emergency_stop_button_in_at_power_on(bench):
    """Emergency stop: the input must be connected to +24 V for the interface to run."""
    if1 = bench.add("if1")
    if1.pins["estop"].drive(False)
    bench.run(1.5)
    assert ask(bench, if1, "(", end="") == b"U\r"
    command(bench, if1, "U61", seconds=1.2)
    command(bench, if1, "X10$", seconds=0.5)
    assert (if1.axes["X"].position, motion_status(bench, if1)) == (0, 32)
    if1.pins["estop"].release()
    assert motion_status(bench, if1) == 32
    command(bench, if1, "X10$", seconds=0.5)
    assert if1.axes["X"].position == 10


# Limits


@pytest.mark.parametrize(("pin", "blocked", "free"), [("limit_plus", "+", "-"), ("limit_minus", "-", "+")])
def test_an_open_limit_lets_the_interface_be_driven_the_other_way_only(bench, if1, pin, blocked, free):
    """Limits: "can only be driven in the negative direction and vice versa after a status request has been made"."""
    command(bench, if1, f"X{blocked}4000$", seconds=1)
    if1.pins[pin].drive(False)
    bench.run(0.1)
    stopped = if1.axes["X"].position
    assert not moving(if1) and 0 < abs(stopped) < 4000
    write(if1, f"X{free}10$")  # before the status request, this is refused
    bench.run(0.5)
    assert if1.axes["X"].position == stopped
    assert motion_status(bench, if1) == 64
    for axis in "XYZ":  # the limits are common to all axes
        before = if1.axes[axis].position
        command(bench, if1, f"{axis}{blocked}10$", seconds=0.5)
        assert if1.axes[axis].position == before
    motion_status(bench, if1)
    command(bench, if1, f"X{free}10$", seconds=0.5)
    assert if1.axes["X"].position == stopped + int(free + "10")


def test_driven_off_the_limit_no_further_request_is_needed(bench):
    """Clearing faults: "driven off the limit in the opposite direction and no further status request need be made"."""
    if1 = ready(bench, X={"limits": (-100, 100)})
    command(bench, if1, "X4000$", seconds=2)
    stopped = if1.axes["X"].position
    assert 100 < stopped <= 105
    assert motion_status(bench, if1) == 64
    command(bench, if1, "X-50$", "X20$", seconds=1)
    assert if1.axes["X"].position == stopped - 30
    assert motion_status(bench, if1) == 0


def test_a_limit_in_motion_decelerates(bench, if1):
    """Quick status: 73 "indicate[s] that a limit input has appeared whilst an axis is in motion and decelerating"."""
    write(if1, "X@1000G$")
    at_speed(bench, if1)
    axis = if1.axes["X"]
    if1.pins["limit_plus"].drive(False)
    assert bench.run_until(lambda: axis.velocity < 1000, 0.01)
    before = axis.position
    assert motion_status(bench, if1) == 73
    bench.run(1)
    assert axis.position == before + 39
    assert motion_status(bench, if1) == 0  # the first request has cleared it


def test_a_limit_behind_a_motion_does_not_stop_it_where_that_is_asked_for(bench):
    """Clearing faults: all is inhibited "apart from motion away from a limit switch"; option: it is not stopped."""
    if1 = ready(bench, limits="motion ahead")
    command(bench, if1, "X-G$", seconds=1)
    if1.pins["limit_plus"].drive(False)
    bench.run(1)
    assert if1.axes["X"].velocity == -400


@pytest.mark.parametrize("pin", ["limit_plus", "limit_minus"])
def test_limit_inputs_light_the_led(bench, if1, pin):
    """Limits: "Emergency stop or limit inputs will light the LED"; off after status is read and the input removed."""
    led = if1.pins["led"]
    command(bench, if1, "XG$" if pin == "limit_plus" else "X-G$", seconds=0.5)
    if1.pins[pin].drive(False)
    bench.run(0.1)
    assert led.level
    motion_status(bench, if1)
    assert led.level
    if1.pins[pin].release()
    bench.run(0.01)
    assert not led.level


@pytest.mark.parametrize("pin", ["limit_plus", "limit_minus"])
def test_a_limit_input_lights_the_led_at_rest_too(bench, if1, pin):
    """Limits: "Emergency stop or limit inputs will light the LED (red) on the interface", at rest too."""
    if1.pins[pin].drive(False)
    bench.run(0.1)
    assert if1.pins["led"].level


# Drive faults


@pytest.mark.parametrize(("pin", "axis"), [("x_fault", "X"), ("y_fault", "Y")])
def test_a_drive_fault_halts_the_interface_without_deceleration(bench, if1, pin, axis):
    """Fault disable links: "will halt the interface in the event of a drive fault"; "no deceleration occurs"."""
    write(if1, f"{axis}@1000G$")
    at_speed(bench, if1, axis)
    if1.pins[pin].drive(False)
    bench.run(0.002)
    assert not if1.axes[axis].moving
    assert if1.pins["led"].level
    assert motion_status(bench, if1) == 16
    write(if1, "Z10$")  # all moves are inhibited
    bench.run(0.5)
    assert if1.axes["Z"].position == 0
    if1.pins[pin].release()
    assert [motion_status(bench, if1) for _ in range(2)] == [16, 0]
    assert not if1.pins["led"].level
    command(bench, if1, "Z10$", seconds=0.5)
    assert if1.axes["Z"].position == 10


def test_the_other_axes_stop_on_their_ramp(bench, if1):
    """Position report: "no deceleration occurs on that axis"; clearing faults: "any axis in motion will stop"."""
    write(if1, "XYZ@1000G$")
    at_speed(bench, if1)
    before = if1.axes["Y"].position
    if1.pins["x_fault"].drive(False)
    bench.run(0.005)
    assert not if1.axes["X"].moving and if1.axes["Y"].moving and if1.axes["Z"].moving
    bench.run(1)
    assert not moving(if1)
    assert 39 <= if1.axes["Y"].position - before <= 42
    assert if1.axes["Y"].position == if1.axes["Z"].position > if1.axes["X"].position


def test_a_fault_input_with_no_drive_and_no_link_is_a_fault_for_ever(bench):
    """Fault disable links: "a logic low on the X and Y axis fault inputs even if no drive is connected"."""
    if1 = bench.add("if1")
    if1.pins["y_fault"].drive(False)
    bench.run(1.5)
    ask(bench, if1, "(", end="")
    command(bench, if1, "U61", seconds=1.2)
    for _ in range(3):
        assert motion_status(bench, if1) == 16
        command(bench, if1, "X10$", seconds=0.5)
        assert if1.axes["X"].position == 0 and if1.pins["led"].level


def test_fault_links_are_fitted_on_a_bare_interface(bench, if1):
    """Fault disable links: "To simulate a working drive where none is fitted, fit link 3 ... and link 4"."""
    assert ask(bench, if1, "I") == b"200\r"  # only inputs 1 to 3 are set
    assert motion_status(bench, if1) == 0


@pytest.mark.parametrize(
    ("pin", "value"), [("estop", 1), ("x_fault", 2), ("y_fault", 4), ("limit_plus", 16), ("limit_minus", 32)]
)
def test_each_input_returns_its_value_when_there_is_no_current(bench, if1, pin, value):
    """Input status: "all inputs return their corresponding value when there is NO current in the diode"."""
    if1.pins[pin].drive(False)
    assert ask(bench, if1, "I") == b"%d\r" % (200 + value)


# LED and output 5


@pytest.mark.parametrize("pin", ["estop", "x_fault", "limit_plus"])
def test_output_5_can_duplicate_the_function_of_the_led(bench, pin):
    """Optional fault output: "Output 5 may be reconfigured to duplicate the function of the LED"."""
    if1 = ready(bench, fault_output=True)
    led, output = edges(if1.pins["led"]), edges(if1.pins["output5"])
    command(bench, if1, "XG$", seconds=0.5)
    if1.pins[pin].drive(False)
    bench.run(0.5)
    assert if1.pins["output5"].level
    motion_status(bench, if1)
    if1.pins[pin].release()
    bench.run(0.1)
    motion_status(bench, if1)
    assert led == output and [level for _, level in led] == [True, False]


def test_output_5_follows_the_led_through_power_up_as_well(bench):
    """Optional fault output: on for the first second, flashing from the bracket to the data format message."""
    if1 = bench.add("if1", fault_output=True)
    for _ in range(60):
        bench.run(0.05)
        assert if1.pins["output5"].level == if1.pins["led"].level
        if bench.seconds == pytest.approx(1.5):
            if1.serial.write(b"(")


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
    assert bench.run_until(lambda: not moving(if1), 0.01)
    assert bench.now - begin <= 2 * MS


def test_the_limit_switches_of_all_axes_are_in_series(bench):
    """Limits: "Where more than one axis is used, connect the limit switches in series": Y's switch stops X as well."""
    if1 = ready(bench, X={"limits": (-1000, 1000)}, Y={"limits": (-1000, 30)})
    command(bench, if1, "XY+500$", seconds=3)
    x, y = if1.axes["X"].position, if1.axes["Y"].position
    assert x == y and 30 < y <= 35
    assert motion_status(bench, if1) == 64
    write(if1, "X+10$")  # X itself is far from its limit
    bench.run(0.5)
    assert if1.axes["X"].position == x
