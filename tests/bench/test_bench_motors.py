"""The public interface of a SmartMotor: terminals, channels, external encoder, shared lines."""

import pytest

from axistwin import Bench
from axistwin.core.errors import UsageError

OPEN_1 = "OCHN(RS4,1,N,9600,1,8,C) "


@pytest.fixture
def bench():
    return Bench()


def tell(bench, port, text, seconds=0.2):
    port.write(text.encode("latin-1"))
    bench.run(seconds)
    return port.read().decode("latin-1")


def chained(bench, count=2, **options):
    """Return motors in a chain, addressed as in section 2 of the base language manual."""
    motors = [bench.add("smartmotor", f"m{number}", **options) for number in range(1, count + 1)]
    port = bench.chain(*motors)
    bench.run(0.3)
    for number in range(1, count + 1):
        tell(bench, port, f"\x80SADDR{number} {chr(0x80 + number)}ECHO {chr(0x80 + number)}SLEEP ")
    tell(bench, port, "\x80WAKE ")
    return port, motors


def test_the_names_of_a_motor(bench):
    motor = bench.add("smartmotor")
    assert list(motor.pins) == [*"ABCDEFG", "brake", "index"] and list(motor.axes) == ["shaft"]
    assert (motor.ambient, motor.master.count) == (25.0, 0) and str(motor.serial.host.format) == "9600 8N1"


def test_limit_switches_hold_c_and_d_low(bench):
    """C is the positive limit, D the negative one; a closed switch pulls its pin to ground (3.1)."""
    pins = bench.add("smartmotor", shaft={"limits": (-100, 500)}).pins
    assert [pin.level for pin in pins.values()][:4] == [True, True, False, False]
    assert (pins["C"].volts, pins["A"].volts) == (0.0, 5.0)
    bare = bench.add("smartmotor").pins
    assert (bare["C"].level, bare["D"].level) == (True, True)


def test_somebody_turns_the_shaft_into_a_limit_switch(bench):
    motor = bench.add("smartmotor", shaft={"limits": (-100, 500)})
    bench.run(0.1)
    motor.axes["shaft"].encoder.displace(501)
    assert (motor.pins["C"].level, motor.axes["shaft"].position) == (True, 501)
    assert tell(bench, motor.serial, "RBp RP ") == "1\r501\r"
    motor.axes["shaft"].encoder.displace(-1)
    assert motor.pins["C"].level is False


def test_it_is_asked_at_every_sample_while_a_servo_moves(bench):
    motor = bench.add("smartmotor", shaft={"limits": (-9999, 9999)})
    bench.run(0.3)
    tell(bench, motor.serial, "MP A=100 V=100000 P=2000 G ")
    shaft = motor.axes["shaft"]
    assert bench.run_until(lambda: shaft.position >= 1000, 5)
    assert 1000 <= shaft.position < 1003  # 100,000 / 65,536 counts per sample
    assert bench.run_until(lambda: not shaft.moving, 5) and (shaft.position, shaft.commanded) == (2000, 2000)
    assert len(shaft.pulse_times()) == 2000


def test_what_others_have_not(bench):
    if1, board, motor = bench.add("if1"), bench.add("1811"), bench.add("smartmotor")
    for broken, words in (
        (lambda: if1.rs485, "if1 has no RS-485 channel: expected a SmartMotor"),
        (lambda: board.rs485, "1811 has no RS-485 channel"),
        (lambda: if1.ambient, "if1 has no attribute `ambient`"),
        (lambda: setattr(if1, "ambient", 30), "if1 has no attribute `ambient`"),
        (lambda: board.master, "1811 has no attribute `master`: only a SmartMotor has this attribute"),
        (lambda: motor.bus, "smartmotor has no bus port"),
        (lambda: bench.chain(motor, if1), "if1 cannot be in a daisy chain: expected a SmartMotor"),
        (lambda: bench.chain(board), "1811 cannot be in a daisy chain"),
        (lambda: bench.chain(), r"chain\(\) was called without motors: expected one or more motors"),
        (lambda: bench.rs485(motor, motor), r"smartmotor is given twice to rs485\(\): expected each motor once"),
        (lambda: bench.chain(Bench().add("smartmotor", "far")), "far belongs to another Bench"),
        (lambda: bench.add("smartmotor", shaft={"home": (0, 1)}), "axis shaft has no option 'home'"),
        (lambda: bench.port("nobody"), "no controller 'nobody' on the bench: expected one of if1, 1811, smartmotor"),
    ):
        with pytest.raises(UsageError, match=words):
            broken()
    assert bench.lines == {}


def test_a_chain_of_motors(bench):
    """Each motor must echo, so that the output of each motor reaches the host."""
    port, (first, second) = chained(bench)
    assert tell(bench, port, "\x81a=11 \x82a=22 ") == "\x81a=11 \x82a=22 "
    assert tell(bench, port, "\x82Ra ") == "\x82Ra 22\r" and tell(bench, port, "\x81Ra ") == "\x81Ra 11\r"
    assert bench.lines["chain"].motors == (first, second) and bench.ports == {"chain": port}
    for motor in (first, second):
        with pytest.raises(
            UsageError, match=r"has no serial port of its own in the daisy chain 'chain': use Bench\.port\('chain'\)"
        ):
            _ = motor.serial
    with pytest.raises(UsageError, match="m2 is already connected to the serial line 'chain'"):
        bench.chain(second)


def test_a_chain_that_takes_no_time(bench):
    port, _ = chained(bench, count=3, line="instant")
    assert tell(bench, port, "\x80Ra ", 0) != "" and port.instant


def test_motors_on_an_rs485_line_hear_the_host_and_are_heard(bench):
    motors = [bench.add("smartmotor", f"m{number}") for number in (1, 2)]
    bench.run(0.3)
    for number, motor in enumerate(motors, start=1):
        tell(bench, motor.serial, f"SADDR{number} a={11 * number} {OPEN_1}")
    line = bench.rs485(*motors)
    assert tell(bench, line, "\x81Ra ") == "11\r" and tell(bench, line, "\x82Ra ") == "22\r"
    with pytest.raises(UsageError, match="m1 is connected to the shared RS-485 line 'rs485'"):
        _ = motors[0].rs485
    assert tell(bench, motors[0].serial, "\x81Ra ") == "11\r"


def test_two_motors_that_answer_at_once_garble_one_another(bench):
    """`1` is 31h and `2` is 32h: the common high bits are 30h, `0`."""
    motors = [bench.add("smartmotor", f"m{number}") for number in (1, 2)]
    bench.run(0.3)
    for number, motor in enumerate(motors, start=1):
        tell(bench, motor.serial, f"a={11 * number} {OPEN_1}")
    assert tell(bench, bench.rs485(*motors), "Ra ") == "00\r"


def test_the_second_channel_of_one_motor(bench):
    motor = bench.add("smartmotor")
    bench.run(0.3)
    assert list(bench.ports) == ["smartmotor"]
    tell(bench, motor.serial, OPEN_1)
    assert tell(bench, motor.rs485, "RSP ") == "24576/476\r" and motor.serial.read() == b""
    assert list(bench.ports) == ["smartmotor", "smartmotor.rs485"] and bench.port("smartmotor.rs485") is motor.rs485


def test_lines_have_names(bench):
    one, two, three = (bench.add("smartmotor") for _ in range(3))
    bench.chain(one)
    bench.chain(two)
    bench.chain(three, name="third")
    assert list(bench.lines) == ["chain", "chain-2", "third"]
    with pytest.raises(UsageError, match="the name 'third' is in use by a line"):
        bench.add("if1", name="third")


def test_the_external_encoder(bench):
    """MF4 counts every edge of the quadrature at A and B; 4000 in two seconds."""
    motor = bench.add("smartmotor")
    bench.run(0.3)
    tell(bench, motor.serial, "UCI UDI ZS MF0 ")
    motor.master.move(4000, 2)
    bench.run(1)
    assert motor.master.count == 2000
    bench.run(2)
    assert tell(bench, motor.serial, "RCTR ") == "4000\r"
