"""What a device of a few lines can rely on: its address, the end of a procedure, the number of a position."""

import pytest
import serial

import axistwin
from axistwin import Bench
from axistwin.devices import Datagrams, Device, Option, Positioner, add8, command
from axistwin.devices.making import product_of


class Pusher(Device):
    model = "pusher"
    framing = Datagrams(">Bb address value", ">B value", add8, address="{address:c}")
    options = {"address": Option(7, 1, 255)}
    axes = {"x": Positioner(velocity=1000, acceleration=1_000_000)}

    def refused(self, reason, data):
        return {"value": 255}

    @command("value=1")
    def push(self):
        self.pushes = self.begin(self.push_often())

    @command("value=2")
    def give_up(self):
        self.end(self.pushes)

    @command("value=3")
    def number(self):
        self.axes["x"].define(50)

    def push_often(self):
        while True:
            self.axes["x"].move_by(10)
            yield self.after(1)


def built():
    bench = Bench()
    pusher = bench.add(product_of(Pusher))
    return bench, pusher, pusher._device.device.axes["x"]


def send(bench, pusher, *numbers):
    pusher.serial.write(bytes(numbers))
    bench.run(0.01)
    return pusher.serial.read()


def test_what_is_for_another_address_is_not_answered_even_if_its_check_sum_is_wrong():
    bench, pusher, _ = built()
    assert send(bench, pusher, 8, 1, 0) == b""
    assert send(bench, pusher, 7, 1, 0) == b"\xff\xff"


def test_a_server_says_what_is_refused_and_goes_on(caplog):
    bench, *_ = built()
    with axistwin.serve(bench, speed="manual") as twin, serial.serial_for_url(twin.ports["pusher"]) as host:
        host.write(bytes([7, 9, 16]))
        assert twin.call(host.read, 2) == b"\xff\xff"
    assert caplog.messages == [
        r"pusher: refused \x07\x09\x10: unknown command 07 09 10: `axistwin commands pusher` lists all"
    ]


def test_a_procedure_ends_when_its_device_ends_it():
    bench, pusher, axis = built()
    send(bench, pusher, 7, 1, 8)
    bench.run(2.5)  # moves at 0, 1 and 2 s
    assert axis.position == 30
    send(bench, pusher, 7, 2, 9)
    bench.run(5)
    assert axis.position == 30


def test_a_position_at_rest_is_the_target_whatever_its_number():
    bench, pusher, axis = built()
    send(bench, pusher, 7, 1, 8)
    send(bench, pusher, 7, 2, 9)
    axis.run(100)
    bench.run(1)
    axis.abort()
    send(bench, pusher, 7, 3, 10)
    assert (axis.position, axis.target) == (50, 50)


@pytest.mark.parametrize(
    "act",
    [lambda axis: axis.abort(), lambda axis: axis.stop(), lambda axis: axis.move_to(6), lambda axis: axis.run(-700)],
    ids=["abort", "stop", "move_to", "run"],
)
def test_the_pulse_of_the_nanosecond_of_a_change_stays_made(act):
    """Pulses at 700/s come every 1 428 571.43 ns; the sixth belongs to 8 571 428 ns, and is due 0.57 ns later."""
    bench, _, axis = built()
    axis.velocity = axis.start_velocity = 700
    axis.run(700)
    bench.clock.run_to(8_571_428)
    assert axis.position == 6
    act(axis)
    bench.run(0.001)
    assert axis.position == 6
