"""Every lamp on the front of an IF1, lit in the situation that the manual states, and dark otherwise."""

from itertools import pairwise

import pytest

from axistwin import Bench

from ..fronts import lamps, shown
from .talking import ask, command, detect, initialise, ready, write

K, F = "Motion status K", "Communication status F"
STOPS, LINES, OUTPUTS, INPUTS = "Stops and limits", "Lines", "Outputs", "Inputs"


def open_circuit(pin):
    return lambda bench, if1: if1.pins[pin].drive(False)


def message(text, seconds=0.2):
    def send(bench, if1):
        command(bench, if1, text, seconds=seconds)

    return send


def decelerating(bench, if1):
    """Start a deceleration of 0.96 s, from 10,000 steps/s at 10,000 steps/s²."""
    message("X@10000G$", 3)(bench, if1)
    message("#", 0.3)(bench, if1)


def transmitting(bench, if1):
    write(if1, "K")
    assert bench.run_until(lambda: if1.terminals["rts"].level, 1)


def host_line(name):
    return lambda bench, if1: setattr(if1.serial.host, name, False)


def wrong_parity(bench, if1):
    initialise_with_parity(bench, if1)
    if1.serial.host.parity = "O"
    message("K")(bench, if1)


def initialise_with_parity(bench, if1):
    """Initialise with 8 data bits and even parity."""
    if1.power_cycle()
    if1.serial.host.parity = "N"
    initialise(bench, if1, "U64")


def break_on_the_line(bench, if1):
    if1.serial.send_break(0.1)
    bench.run(0.2)


def overrun(bench, if1):
    """Send a character every 1.15 ms to a buffer that is strobed every 2 ms, which loses some of them."""
    message("X100X100")(bench, if1)


SITUATIONS = {
    ("Interface", "LED"): open_circuit("estop"),
    **{(OUTPUTS, f"{n}"): message(f"S{n}$") for n in range(1, 6)},
    (LINES, "RTS"): transmitting,
    (STOPS, "STOP"): open_circuit("estop"),
    (STOPS, "+"): open_circuit("limit_plus"),
    (STOPS, "−"): open_circuit("limit_minus"),
    (STOPS, "X"): open_circuit("x_fault"),
    (STOPS, "Y"): open_circuit("y_fault"),
    **{(INPUTS, f"{n}"): (lambda bench, if1, n=n: if1.pins[f"input{n}"].drive(True)) for n in range(1, 4)},
    (K, "1"): message("X1000@100$"),
    (K, "2"): message("X1000@100$"),
    (K, "4"): message("X@10000G$", 0.3),
    (K, "8"): decelerating,
    (K, "16"): open_circuit("y_fault"),
    (K, "32"): open_circuit("estop"),
    (K, "64"): open_circuit("limit_minus"),
    (K, "128"): message("?"),
    (F, "1"): wrong_parity,
    (F, "2"): overrun,
    (F, "4"): break_on_the_line,
    (F, "8"): message("?"),
    (F, "16"): message("@30000"),
    (F, "32"): message("["),
}  # fmt: skip
"""What lights a lamp that is dark on an interface that is ready and has nothing to do."""
LIT_WHEN_READY = {
    (LINES, "DTR"): lambda bench, if1: if1.power(False),
    (LINES, "DSR"): host_line("dtr"),
    (LINES, "CTS"): host_line("rts"),
    (OUTPUTS, "24 V"): open_circuit("supply"),
    **{("Directions", axis): message(f"{axis}-10$") for axis in "XYZ"},
}
"""What puts out a lamp that is lit there."""


@pytest.fixture
def idle(bench):
    return ready(bench)


@pytest.mark.parametrize("lamp", SITUATIONS, ids=" ".join)
def test_a_lamp_is_lit_when_the_manual_says_so(bench, lamp):
    if1 = ready(bench, strobe_ms=2 if SITUATIONS[lamp] is overrun else 1)
    assert shown(if1, *lamp) is False
    SITUATIONS[lamp](bench, if1)
    assert shown(if1, *lamp) is True


@pytest.mark.parametrize("lamp", LIT_WHEN_READY, ids=" ".join)
def test_a_lamp_that_is_lit_when_it_is_ready_goes_out(bench, idle, lamp):
    assert shown(idle, *lamp) is True
    LIT_WHEN_READY[lamp](bench, idle)
    assert shown(idle, *lamp) is False


@pytest.mark.parametrize("model", ["if1", "if2"])
def test_there_is_no_lamp_without_a_situation(model):
    assert lamps(Bench().add(model)) == SITUATIONS.keys() | LIT_WHEN_READY.keys()


def test_the_led_from_power_up_to_ready(bench):
    """Configuring the interface: on for about 1 s, flashing "twice per second" from `(` to the data format."""
    if1 = bench.add("if1")
    lamp = "Interface", "LED"
    assert shown(if1, *lamp) is True
    bench.run(1.2)
    assert shown(if1, *lamp) is False
    if1.serial.write(b"(")
    bench.run(0.1)
    seen = []
    for _ in range(16):
        bench.run(0.125)
        seen.append(shown(if1, *lamp))
    edges = sum(a is not b for a, b in pairwise(seen))
    assert edges in (7, 8), "two flashes per second for two seconds"


def test_the_led_goes_out_when_the_status_has_been_read_and_the_cause_is_gone(bench, idle):
    """Clearing fault conditions: the LED goes out when the status has been read and the fault is gone."""
    lamp = "Interface", "LED"
    idle.pins["estop"].drive(False)
    ask(bench, idle, "K")
    assert shown(idle, *lamp) is True
    idle.pins["estop"].drive(True)
    assert shown(idle, *lamp) is True
    assert ask(bench, idle, "K") == b"32\r"
    assert shown(idle, *lamp) is False


def test_output_5_follows_the_led_with_link_3_in_position_b(bench):
    if1 = ready(bench, fault_output=True)
    if1.pins["estop"].drive(False)
    assert shown(if1, OUTPUTS, "5") is True


@pytest.mark.parametrize(("wiring", "dsr"), [("3-wire", False), ("3-wire DSR-DTR", True)])
def test_dsr_is_what_the_interface_finds(bench, wiring, dsr):
    """DSR linked to RTS reads off until a transmission; DSR linked to DTR reads on."""
    if1 = bench.add("if1", wiring=wiring)
    bench.run(1.5)
    assert [shown(if1, LINES, line) for line in ("DSR", "CTS")] == [dsr, False]


def test_the_state_in_words(bench):
    if1 = bench.add("if1")
    states = [shown(if1, "Interface", "state")]
    bench.run(1.5)
    states.append(shown(if1, "Interface", "state"))
    if1.power_cycle()
    detect(bench, if1)
    states.append(shown(if1, "Interface", "state"))
    if1.power(False)
    states.append(shown(if1, "Interface", "state"))
    assert states == ["self-test", "waiting for (", "waiting for the data format", "no power"]


@pytest.mark.parametrize(
    ("act", "word"),
    [
        (message(""), "clear for new commands"),
        (message("X1000@100$"), "busy"),
        (open_circuit("estop"), "fault"),
        (message("["), "locked"),
    ],
)
def test_the_busy_status_in_words(bench, idle, act, word):
    act(bench, idle)
    assert shown(idle, "Interface", "E") == word


def test_there_is_no_busy_status_until_the_data_format_has_come(bench):
    """Initialisation: until then it is not "ready to receive move instructions", and E is not answered."""
    if1 = bench.add("if1")
    words = []
    for seconds, characters in ((0, b""), (1.5, b""), (0.1, b"("), (0.1, b"U61\r")):
        if1.serial.write(characters)
        bench.run(seconds)
        words.append(shown(if1, "Interface", "E"))
    assert words == ["no answer yet"] * 3 + ["clear for new commands"]


def test_a_limit_that_was_read_is_no_fault_any_more_while_the_lamp_stays_lit(bench, idle):
    """Clearing fault conditions: a request resets the bit; Installation: the LED is on until the input closes."""
    idle.pins["limit_plus"].drive(False)
    assert ask(bench, idle, "K") == b"64\r"
    assert [shown(idle, K, "64"), shown(idle, "Interface", "LED"), shown(idle, STOPS, "+")] == [False, True, True]
    idle.pins["limit_plus"].drive(True)
    assert [shown(idle, "Interface", "LED"), shown(idle, STOPS, "+")] == [False, False]


def test_the_step_of_a_sequence_and_the_steps_of_a_move(bench, idle):
    """X and Y move 100 steps each at 100 steps/s: after 1.5 s, half of step 2 is done."""
    message(":X100@100:Y100:$", 1.5)(bench, idle)
    assert shown(idle, "Interface", "O") == "2"
    assert 40 <= int(shown(idle, "Interface", "N")) <= 60
    assert ask(bench, idle, "N", 2.0) != b""
    assert shown(idle, "Interface", "N") == "100"


@pytest.mark.parametrize("seconds", [0.1, 0.5, 1.0, 2.5])
def test_q_and_n_are_what_the_commands_report(bench, idle, seconds):
    """The registers for Q and N equal the answers at the same instant, also in the middle of a ramp."""
    message("X12000@9000$", seconds)(bench, idle)
    for register, request in (("Q", b"K\r"), ("N", b"N\r")):
        idle.serial.read()
        idle.serial.write(request)
        assert bench.run_until(lambda: idle.terminals["rts"].level, 1)
        expected = idle.registers[register].read()
        bench.run(0.1)
        assert int(idle.serial.read()) == expected
