"""Faults on serial lines."""

import pytest

from axistwin import Bench
from axistwin.core.errors import UsageError

from ..told import raises


@pytest.fixture
def bench():
    """Return a bench with an IF1 that has just been initialised, at 9600 8N2."""
    bench = Bench()
    if1 = bench.add("if1", X={"encoder": {}})
    bench.run(1.5)
    if1.serial.write(b"(")
    bench.run(0.1)
    if1.serial.write(b"U61\r")
    bench.run(1.2)
    assert if1.serial.read() == b"U\r"
    return bench


def says(bench, words, seconds=0.2):
    bench["if1"].serial.write(words)
    bench.run(seconds)
    return bench["if1"].serial.read()


def test_characters_are_lost(bench):
    fault = bench.faults.add("lose", "if1.serial", count=2)
    assert says(bench, b"\r\rN\r") == b"0\r"
    assert not fault.on, "the two characters have been lost"
    fault = bench.faults.add("lose", way="from", here="if1")
    assert says(bench, b"N\r") == b"\r" and says(bench, b"N\r") == b"0\r"


def test_characters_are_doubled_or_flipped(bench):
    bench.faults.add("double", "if1", count=1, way="from")
    assert says(bench, b"N\r") == b"00\r"
    bench.faults.add("flip", "if1", count=1, mask=3, way="from")
    assert says(bench, b"N\r") == b"3\r"


def test_a_probability_with_the_same_seed_affects_the_same_characters(bench):
    def heard(seed):
        fault = bench.faults.add("flip", "if1", way="from", mask=0x10, probability=0.3, seed=seed)
        answer = says(bench, b"N\r" * 20, 2.0)
        fault.mend()
        return answer

    first, second, third = heard(1), heard(1), heard(2)
    assert first == second != third and says(bench, b"N\r") == b"0\r"


def test_a_random_fault_needs_a_seed(bench):
    raises(UsageError, "is random and needs a seed", bench.faults.add, "lose", "if1", probability=0.5)


def test_a_short_circuit_is_a_break(bench):
    bench.faults.add("break", "if1", seconds=0.05)
    bench.run(0.1)
    assert says(bench, b"F\r") == b"4\r", "framing"


def test_the_host_has_a_wrong_baud_rate_for_a_duration(bench):
    bench.faults.add("baud", "if1", baudrate=2400, duration=0.2)
    assert says(bench, b"N\r") != b"0\r"
    bench.run(0.5)
    assert bench["if1"].serial.host.baudrate == 9600


@pytest.mark.parametrize(("percent", "understood"), [(2.0, True), (-2.0, True), (12.0, False), (-12.0, False)])
def test_characters_are_received_up_to_a_clock_drift_of_a_few_percent(bench, percent, understood):
    bench.faults.add("drift", "if1", percent=percent, way="to")
    assert (says(bench, b"N\r") == b"0\r") is understood


def test_delayed_characters_keep_their_order(bench):
    port, heard = bench["if1"].serial, []
    port.subscribe_received(lambda byte, _: heard.append((chr(byte), bench.now)))
    port.write(b"N\r")
    bench.run(0.1)
    usual = heard[0][1]
    heard.clear()
    began = bench.now
    bench.faults.add("delay", "if1", seconds=0.05, way="from", duration=0.06)
    port.write(b"N\r")
    bench.run(0.2)
    assert [what for what, _ in heard] == ["0", "\r"]
    assert heard[0][1] - began == usual - (began - 100_000_000) + 50_000_000


def test_a_jitter_keeps_the_order(bench):
    bench.faults.add("delay", "if1", seconds=0.0, jitter=0.02, seed=3, way="from")
    assert says(bench, b"X12$\r", 2.0) == b"" and says(bench, b"N\r", 1.0) == b"12\r"


def test_a_cut_cable_switches_the_control_lines_off(bench):
    port = bench["if1"].serial
    assert port.dtr
    fault = bench.faults.add("cut", "if1")
    assert says(bench, b"N\r") == b"" and not port.dtr
    fault.mend()
    assert port.dtr and says(bench, b"\rN\r").endswith(b"0\r")


def test_one_direction_can_be_cut_alone(bench):
    bench.faults.add("cut", "if1", way="from", duration=0.1)
    assert says(bench, b"X50$\r", 1.0) == b"" and says(bench, b"N\r") == b"50\r"


def test_the_end_of_a_cut_does_not_end_another_cut(bench):
    first, second = (bench.faults.add("cut", "if1", way="to") for _ in range(2))
    first.mend()
    assert says(bench, b"N\r") == b""
    second.mend()
    assert says(bench, b"\rN\r").endswith(b"0\r")


def test_a_stuck_control_line_prevents_transmission(bench):
    bench.faults.add("handshake", "if1", line="cts", level=False, duration=0.5)
    assert says(bench, b"N\r", 0.4) == b"", "5-wire: it may not transmit"
    bench.run(0.2)
    assert bench["if1"].serial.read() == b"0\r"


def test_a_device_without_control_lines_refuses_the_fault():
    bench = Bench()
    bench.add("smartmotor")
    raises(UsageError, "no control lines", bench.faults.add, "handshake", "smartmotor.serial", line="dtr")


def test_an_instant_line_has_the_same_faults():
    bench = Bench()
    motor = bench.add("smartmotor", line="instant")
    bench.run(0.3)
    bench.faults.add("lose", "smartmotor", way="from")
    motor.serial.write(b"RP\r")
    bench.run(0.01)
    assert motor.serial.read() == b"\r"
    bench.faults.add("delay", "smartmotor", seconds=0.5, way="from")
    motor.serial.write(b"RP\r")
    bench.run(0.1)
    assert motor.serial.read() == b""
    bench.run(0.5)
    assert motor.serial.read() == b"0\r"


def test_faults_on_a_daisy_chain():
    bench = Bench()
    chain = bench.chain(bench.add("smartmotor", "left"))
    bench.run(0.3)
    bench.faults.add("flip", "chain", count=1, way="from")
    chain.write(b"RP\r")
    bench.run(0.1)
    assert chain.read() == b"1\r"
