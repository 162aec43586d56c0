"""The TMCL module of `examples/devices`, driven by the maker's own package over a port.

A trapezoid of d pulses at v pulses/s with a pulses/s² takes d/v + v/a seconds, if d >= v²/a.
"""

import pytest

import axistwin
from axistwin.core.units import S
from axistwin.devices.making import product_of
from axistwin.testing import device_checks

from .made import client, example

Tmcl = example("tmcl", "Tmcl")


@pytest.fixture
def bench():
    bench = axistwin.Bench()
    bench.add(product_of(Tmcl), "module", **{"0": {"limits": (-500, 4000)}, "1": {"home": (200, 300)}})
    return bench


@pytest.fixture
def module(bench):
    return bench["module"]


@pytest.fixture
def host(bench):
    """Return a function that calls one of the client, the client's connection, and its motors."""
    connect, kind = client("pytrinamic.connections").SocketTmclInterface, client("pytrinamic.modules").TMCM3351
    with axistwin.serve(bench, speed="manual") as twin, connect(twin.ports["module"].address) as connection:
        yield twin.call, connection, kind(connection).motors


@pytest.mark.parametrize("check", device_checks(Tmcl))
def test_it_keeps_what_every_device_must(check):
    check()


def settle(motor):
    motor.linear_ramp.max_velocity = 1000
    motor.linear_ramp.max_acceleration = 2000


def move_and_wait(motor, distance):
    motor.move_by(distance)
    while not motor.get_position_reached():
        pass


def lasted_ns(axis):
    return axis.train.move.end_ns - axis.train.move.start_ns


def test_the_client_moves_an_axis_by_the_pulse_and_the_nanosecond(host, module):
    call, _, (motor, *_) = host
    call(settle, motor)
    call(move_and_wait, motor, 3000)
    axis = module.axes["0"]
    assert axis.position == 3000
    assert lasted_ns(axis) == 3 * S + S // 2  # 3000/1000 + 1000/2000 s
    assert call(lambda: motor.actual_position) == 3000
    call(move_and_wait, motor, -125)  # the peak is √(125 × 2000) = 500 pulses/s
    assert axis.position == 2875
    assert lasted_ns(axis) == S // 2  # 2 × 500/2000 s


def test_the_position_is_given_a_number_at_rest(host, module):
    call, _, (motor, *_) = host
    call(settle, motor)
    call(move_and_wait, motor, 100)
    call(motor.set_actual_position, -5)
    assert call(lambda: (motor.actual_position, motor.target_position, motor.get_position_reached())) == (-5, -5, 1)
    call(motor.set_target_position, 15)
    call(move_and_wait, motor, 0)
    assert module.axes["0"].position == 120


def test_velocities_and_stops_have_ramps(host, module, bench):
    call, _, (*_, motor) = host
    call(settle, motor)
    call(motor.rotate, -1000)
    start_ns = module.axes["2"].train.move.start_ns
    bench.run((start_ns + 2 * S - bench.now) / S)
    assert module.axes["2"].position == -1750  # 250 in the ramp of 0.5 s, then 1500
    assert call(motor.get_actual_velocity) == -1000
    assert call(motor.get_target_velocity) == -1000
    call(motor.stop)
    assert lasted_ns(module.axes["2"]) == S // 2
    bench.run(1)
    assert call(motor.get_actual_velocity) == 0


def test_coordinates_are_set_read_and_moved_to(host, module, bench):
    call, connection, (_, motor, _) = host
    call(connection.send, 30, 20, 1, -777)
    assert call(connection.send, 31, 20, 1, 0).value == 2**32 - 777
    call(connection.move, 2, 1, 20)
    bench.run(1)
    assert module.axes["1"].position == -777
    assert call(motor.get_target_position) == -777


def test_a_limit_switch_stops_at_once_and_is_reported(host, module, bench):
    call, _, (motor, *_) = host
    call(settle, motor)
    call(motor.move_to, 10_000)
    bench.run(10)
    assert module.axes["0"].position == 4001  # the pulse that opened the switch
    ends = (motor.AP.RightEndstop, motor.AP.LeftEndstop)
    assert [call(motor.get_axis_parameter, end) for end in ends] == [1, 0]
    assert call(motor.get_position_reached) == 0
    call(motor.move_to, 0)
    bench.run(10)
    assert module.axes["0"].position == 0


def search_and_wait(connection, motor):
    connection.reference_search(0, motor)
    while connection.reference_search(2, motor):
        pass


def test_a_search_for_the_left_switch_makes_its_edge_0(host, module):
    call, connection, (motor, *_) = host
    call(search_and_wait, connection, 0)
    assert module.axes["0"].position == -500  # where the switch closes again
    assert call(lambda: (motor.actual_position, motor.target_position, motor.get_position_reached())) == (0, 0, 1)


def test_a_search_for_home_makes_its_edge_0(host, module):
    call, connection, (_, motor, _) = host
    call(motor.set_axis_parameter, motor.AP.ReferenceSearchMode, 8)
    call(search_and_wait, connection, 1)
    assert module.axes["1"].position == 199  # it came from below, and left the switch there
    assert call(lambda: motor.actual_position) == 0


def test_a_search_is_stopped(host, module, bench):
    call, connection, _ = host
    call(connection.reference_search, 0, 2)  # there is no switch
    bench.run(1)
    assert call(connection.reference_search, 2, 2) == 1
    call(connection.reference_search, 1, 2)
    bench.run(1)
    assert (call(connection.reference_search, 2, 2), module.axes["2"].velocity) == (0, 0)


def test_settings_that_are_stored_survive_without_power(host, module, bench):
    call, connection, (motor, *_) = host
    assert call(lambda: motor.linear_ramp.max_velocity) == 51_200
    call(settle, motor)
    call(connection.store_axis_parameter, motor.AP.MaxVelocity, 0)
    call(motor.drive_settings.set_microstep_resolution, motor.ENUM.microstep_resolution_4_microsteps)
    module.power_cycle()
    assert call(lambda: (motor.linear_ramp.max_velocity, motor.linear_ramp.max_acceleration)) == (1000, 51_200)
    assert call(lambda: motor.drive_settings.microstep_resolution) == motor.ENUM.microstep_resolution_256_microsteps
    call(settle, motor)
    call(connection.restore_axis_parameter, motor.AP.MaxAcceleration, 0)
    assert call(lambda: motor.linear_ramp.max_acceleration) == 51_200


def test_inputs_outputs_variables_and_version(host, module, bench):
    call, connection, (motor, *_) = host
    call(connection.set_digital_output, 3)
    assert (module.pins["out3"].level, call(connection.get_digital_output, 3)) == (True, 1)
    call(connection.clear_digital_output, 3)
    module.pins["in5"].drive(True)
    assert (call(connection.get_digital_output, 3), call(connection.get_digital_input, 5)) == (0, 1)
    call(connection.set_global_parameter, 55, 2, -9)
    assert call(connection.get_global_parameter, 55, 2, None, True) == -9
    assert call(connection.get_version_string) == "3351V100"
    assert "'boost_current': 0, 'microstep_resolution': 8" in call(lambda: str(motor.drive_settings))


def test_no_datagram_is_taken_for_telnet(host, caplog):
    call, _, (motor, *_) = host
    assert call(motor.get_axis_parameter, 13) == 0  # CR, then NUL
    assert caplog.messages == []


@pytest.mark.parametrize(
    ("request_", "status"),
    [
        ((99, 0, 0, 0), "Invalid Command"),
        ((4, 3, 0, 0), "Wrong Type"),  # MVP: absolute, relative, coordinate
        ((6, 18, 0, 0), "Wrong Type"),  # no such axis parameter
        ((5, 8, 0, 1), "Wrong Type"),  # which can only be read
        ((9, 56, 2, 1), "Wrong Type"),  # user variables are 0 to 55
        ((10, 0, 3, 0), "Wrong Type"),  # no such bank
        ((1, 0, 3, 0), "Invalid Value"),  # motors are 0 to 2
        ((1, 0, 0, 7_999_775), "Invalid Value"),
        ((5, 4, 0, -1), "Invalid Value"),
        ((5, 193, 0, 3), "Invalid Value"),
        ((4, 2, 0, 21), "Invalid Value"),
        ((14, 0, 2, 2), "Invalid Value"),
    ],
)
def test_the_client_is_told_what_is_wrong(host, module, request_, status):
    call, connection, _ = host
    with pytest.raises(client("pytrinamic.tmcl").TMCLReplyStatusError) as told:
        call(connection.send, *request_)
    assert told.value.error_description == status
    assert module.axes["0"].position == 0


def exchange(bench, module, text):
    module.serial.write(bytes.fromhex(text))
    bench.run(0.05)  # 18 characters of 1.04 ms each
    return module.serial.read().hex(" ")


def test_datagrams_are_those_of_the_manual(bench, module):
    """ROR 0, 350; the answer has the host's address and the status 100, and the value that was sent."""
    assert exchange(bench, module, "01 01 00 00 00 00 01 5e 61") == "02 01 64 01 00 00 01 5e c7"


def test_a_wrong_check_sum_has_status_1_and_no_effect(bench, module):
    assert exchange(bench, module, "01 01 00 00 00 00 01 5e 60") == "02 01 01 01 00 00 01 5e 64"
    assert module.axes["0"].velocity == 0


def test_other_modules_are_addressed_otherwise(bench, module):
    assert exchange(bench, module, "02 01 00 00 00 00 01 5e 62") == ""


def test_the_rest_of_a_datagram_is_not_awaited_for_ever(bench, module):
    assert exchange(bench, module, "01 01 00") == ""
    bench.run(0.2)
    assert exchange(bench, module, "01 03 00 00 00 00 00 00 04") == "02 01 64 03 00 00 00 00 6a"
