"""Chapter 6, and 12 of the base language: the seven user pins."""

import pytest

from axistwin import Bench
from axistwin.bench import Controller

from .talking import ask, clear, load, ready, tell

PINS = "ABCDEFG"


@pytest.fixture
def motor(bench: Bench) -> Controller:
    return ready(bench)


@pytest.mark.parametrize(("bit", "name"), list(enumerate(PINS)))
def test_u_has_a_bit_for_each_pin(bench, motor, bit, name):
    """Table 6.1: A is bit 0, G is bit 6; an open pin is high."""
    assert tell(bench, motor, f"RU RU{name}") == b"127\r1\r"
    motor.pins[name].drive(False)
    assert tell(bench, motor, f"RU RU{name}") == f"{127 - (1 << bit)}\r0\r".encode()
    assert tell(bench, motor, f"a=U Ra b=U{name}I Rb c=U{name} Rc") == f"{127 - (1 << bit)}\r0\r0\r".encode()


@pytest.mark.parametrize(("volts", "level"), [(5.0, 1), (2.0, 1), (0.8, 0), (0.0, 0)])
def test_1_is_2_volts_or_more_and_0_is_at_most_0_8(bench, motor, volts, level):
    """6.2."""
    motor.pins["A"].drive(volts)
    assert ask(bench, motor, "RUA") == str(level)


@pytest.mark.parametrize(("volts", "value"), [(0.0, 0), (2.5, 512), (5.0, 1023), (1.0, 205)])
@pytest.mark.parametrize("name", PINS)
def test_analog_values_are_1023_for_5_volts(bench, motor, name, volts, value):
    """6.3; halves are rounded upwards: 2.5 V is 511.5."""
    motor.pins[name].drive(volts)
    assert tell(bench, motor, f"RU{name}A a=U{name}A Ra") == f"{value}\r{value}\r".encode()


@pytest.mark.parametrize("name", PINS)
def test_an_output_shows_its_latch(bench, motor, name):
    """12: UxO, Ux=."""
    pin = motor.pins[name]
    tell(bench, motor, f"U{name}O")
    assert (pin.level, pin.volts) == (False, 0.0)
    tell(bench, motor, f"U{name}=1")
    assert (pin.level, pin.volts) == (True, 5.0)
    tell(bench, motor, f"U{name}=0")
    assert pin.level is False
    tell(bench, motor, f"U{name}=-4 U{name}I")
    assert pin.level is True
    assert ask(bench, motor, "RBs") == "0"


def test_the_latch_survives_a_change_of_direction(bench, motor):
    """12: written first, it avoids a glitch."""
    levels: list[bool] = []
    motor.pins["A"].subscribe(lambda pin: levels.append(pin.level))
    tell(bench, motor, "UA=1 UAO UAI UAO RUA")
    assert levels == []
    tell(bench, motor, "UA=0 UAI UAO")
    assert levels == [False, True, False]


def test_a_latch_does_nothing_to_an_input(bench, motor):
    tell(bench, motor, "UA=0")
    assert motor.pins["A"].level is True


def test_an_output_reads_the_pin_itself(bench, motor):
    """Somebody with a test lead is stronger."""
    tell(bench, motor, "UAO UA=0")
    motor.pins["A"].drive(True)
    assert ask(bench, motor, "RUA") == "1"


def test_all_pins_are_inputs_again_after_power_up(bench, motor):
    tell(bench, motor, " ".join(f"U{name}O" for name in PINS))
    assert [motor.pins[name].level for name in PINS] == [False] * 7
    motor.power_cycle()
    assert [motor.pins[name].level for name in PINS] == [True] * 7
    clear(bench, motor)
    tell(bench, motor, "UAO")
    assert motor.pins["A"].level is False
    tell(bench, motor, "Z", 0.3)
    assert motor.pins["A"].level is True


@pytest.mark.parametrize("direction", ["I", "O"])
def test_uci_and_udi_end_the_limit_role(bench, direction):
    """3.1: "reassign the limits"; as outputs they are no limits either."""
    motor = bench.add("smartmotor", line="instant")
    bench.run(0.3)
    assert tell(bench, motor, f"UC=1 UD=1 UC{direction} UD{direction} ZS", 0.01) == b""
    assert ask(bench, motor, "RW") == "128"


def test_ucp_and_udm_begin_it_again(bench, motor):
    """3.1: pins C and D are active high."""
    tell(bench, motor, "UCP", 0.01)
    assert tell(bench, motor, "RBr RBp RBl RBm") == b"1\r1\r0\r0\r"
    motor.pins["C"].drive(False)
    tell(bench, motor, "ZS UCO UC=1", 0.01)
    assert tell(bench, motor, "RBr RBp") == b"0\r0\r"


@pytest.mark.parametrize(("command", "moves"), [("UG", True), ("UGI", False), ("UGO UG=1", False)])
def test_a_falling_edge_at_pin_g_is_a_go_while_it_has_that_role(bench, motor, command, moves):
    """12: synchronous go, the role at power-up; UGI ends it, UG begins it again."""
    tell(bench, motor, f"UGI {command} P=100 V=1000000 A=1000", 0.01)
    motor.pins["G"].drive(False)
    bench.run(0.5)
    assert ask(bench, motor, "RP") == ("100" if moves else "0")


def test_g_has_the_go_role_at_power_up(bench, motor):
    tell(bench, motor, "P=100 V=1000000 A=1000", 0.01)
    motor.pins["G"].drive(False)
    bench.run(0.5)
    assert ask(bench, motor, "RP") == "100"


def test_pins_e_and_f_are_channel_1_or_inputs_and_outputs(bench, motor):
    """12: UEO takes its wire away from channel 1."""
    port = motor.rs485
    tell(bench, motor, "UEO OCHN(RS4,1,N,9600,1,8,C)")
    assert motor.pins["E"].level is True
    assert tell(bench, port, "RP") == b"0\r"
    tell(bench, motor, "UEO")
    assert tell(bench, port, "RP") == b""


# The brake's signal (5.1)


@pytest.mark.parametrize(("brake", "name"), [("BRKC", "C"), ("BRKG", "G")])
def test_writing_to_the_brakes_pin_takes_its_function_away(bench, motor, brake, name):
    """5.1 note 2: such commands change the function of the pin "and may cause the brake to release"."""
    pin = motor.pins[name]
    tell(bench, motor, f"U{name}O {brake}")
    assert pin.level is True  # engaged: the motor is off
    tell(bench, motor, f"U{name}=0")
    assert pin.level is False
    tell(bench, motor, "BRKENG")
    assert pin.level is False
    tell(bench, motor, brake)
    assert pin.level is True


@pytest.mark.parametrize(("brake", "name"), [("BRKC", "C"), ("BRKG", "G")])
def test_as_an_input_the_pin_does_not_follow_the_brake(bench, motor, brake, name):
    """5.1 note 2: UCI, UGI; and note 1: UCO, UGO come before BRKC, BRKG."""
    pin = motor.pins[name]
    tell(bench, motor, f"U{name}O {brake} U{name}I BRKRLS")
    assert pin.level is True  # its resistor pulls it up
    tell(bench, motor, f"U{name}O {brake}")
    assert pin.level is False


def test_rs4_takes_pin_g_from_the_brake(bench, motor):
    """5.1 note 2."""
    tell(bench, motor, "UGO BRKG")
    assert motor.pins["G"].level is True
    tell(bench, motor, "RS4")
    assert motor.pins["G"].level is False


# AniLink


def test_without_devices_anilink_reads_0(bench, motor):
    """12: AINpc, DINpc, AOUTp, DOUTpc."""
    assert tell(bench, motor, "a=5 a=AINA1 Ra a=5 a=DINH63 Ra AOUTA,512 DOUTB7,1 RBs") == b"0\r0\r0\r"


@pytest.mark.parametrize(("brake", "name"), [("BRKC", "C"), ("BRKG", "G")])
@pytest.mark.parametrize("read", ["a=U{}", "a=U{}I", "ab[7]=U{}+1", "aaa=(U{}==0)"])
def test_reading_the_brakes_pin_into_a_variable_takes_its_function_away(bench, motor, brake, name, read):
    """5.1 note 2: `<variable>=UG` changes the pin's function: an input, as with UGI, also after BRKG."""
    pin = motor.pins[name]
    tell(bench, motor, f"MP P=0 A=1 V=1 G U{name}O {brake}")
    assert (pin.level, pin.is_output) == (False, True)  # released: the servo is on
    tell(bench, motor, read.format(name))
    assert (pin.level, pin.is_output) == (True, False)  # its resistor pulls it up
    tell(bench, motor, brake)
    assert pin.is_output is False
    tell(bench, motor, f"U{name}O {brake}")
    assert (pin.level, pin.is_output) == (False, True)


@pytest.mark.parametrize("name", ["C", "G"])
@pytest.mark.parametrize(
    "harmless", ["RU{}", "RU{}A", "RU", "a=U", "a=U{}A", "PRINT(U{})", "a=UA", "T=U{}", "Rab[U{}]"]
)
def test_reports_of_the_brakes_pin_leave_it_alone(bench, motor, name, harmless):
    """5.1 note 2 names `<variable>=UG`; 1.2: RU{pin} reports "input or output"."""
    tell(bench, motor, f"U{name}O BRK{name} {harmless.format(name)}")
    assert motor.pins[name].is_output


@pytest.mark.parametrize("name", ["C", "G"])
def test_a_program_takes_the_brakes_pin_at_the_sample_of_its_assignment(bench, motor, name):
    """One statement per sample: UGO, BRKG, BRKRLS, IF, a=UG; the condition reads the pin, and changes nothing."""
    load(bench, motor, f"U{name}O BRK{name} BRKRLS IF U{name} ENDIF a=U{name} b=1 END")
    seen = []
    motor.pins[name].subscribe(lambda pin: seen.append((bench.now // 245_760, pin.level, pin.is_output)))
    begin = (bench.now // 245_760) + 1
    tell(bench, motor, "RUN", 0.01)
    assert tell(bench, motor, "Ra Rb") == b"0\r1\r"
    assert [(sample - begin, *rest) for sample, *rest in seen] == [
        (0, False, True),
        (1, True, True),
        (2, False, True),
        (4, True, False),
    ]


@pytest.mark.parametrize("name", ["C", "G"])
def test_an_output_that_is_no_brakes_signal_is_read_and_stays_an_output(bench, motor, name):
    assert tell(bench, motor, f"U{name}=0 U{name}O a=U{name} Ra U{name}=1 a=U{name} Ra") == b"0\r1\r"
    assert motor.pins[name].is_output


def test_the_go_role_stays_when_brkg_has_no_output(bench, motor):
    """5.1 note 1: without UGO pin G carries no signal; reading it leaves its synchronous go."""
    tell(bench, motor, "BRKG a=UG A=65536 V=65536 P=10 MP")
    motor.pins["G"].drive(False)
    bench.run(0.01)
    assert motor.axes["shaft"].position == 10
