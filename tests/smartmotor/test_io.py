"""Chapter 6, and 12 of the base language: the seven user pins."""

import pytest

from .talking import ask, bare, clear, load, send

PINS = "ABCDEFG"


@pytest.mark.parametrize(("volts", "value"), [(0.0, 0), (2.5, 512), (5.0, 1023), (1.0, 205)])
@pytest.mark.parametrize("name", PINS)
def test_analog_values_are_1023_for_5_volts(bench, motor, name, volts, value):
    """6.3: "1023 is 5.0 Vdc and 0 is zero volts"; halves are rounded upwards, e.g. 511.5 at 2.5 V to 512."""
    motor.pins[name].drive(volts)
    assert send(bench, motor, f"RU{name}A a=U{name}A Ra") == f"{value}\r{value}\r".encode()


def test_the_latch_survives_a_change_of_direction(bench, motor):
    """12: a latch that is written before UxO sets the level of the output without a glitch."""
    levels: list[bool] = []
    motor.pins["A"].subscribe(lambda pin: levels.append(pin.level))
    send(bench, motor, "UA=1 UAO UAI UAO RUA")
    assert levels == []
    send(bench, motor, "UA=0 UAI UAO")
    assert levels == [False, True, False]


def test_a_latch_does_nothing_to_an_input(bench, motor):
    send(bench, motor, "UA=0")
    assert motor.pins["A"].level is True


def test_an_output_reads_the_pin_itself(bench, motor):
    """A report of an output reads the pin's level, which a test lead can force against the output."""
    send(bench, motor, "UAO UA=0")
    motor.pins["A"].drive(True)
    assert ask(bench, motor, "RUA") == "1"


def test_all_pins_are_inputs_again_after_power_up(bench, motor):
    send(bench, motor, " ".join(f"U{name}O" for name in PINS))
    assert [motor.pins[name].level for name in PINS] == [False] * 7
    motor.power_cycle()
    assert [motor.pins[name].level for name in PINS] == [True] * 7
    clear(bench, motor)
    send(bench, motor, "UAO")
    assert motor.pins["A"].level is False
    send(bench, motor, "Z", 0.3)
    assert motor.pins["A"].level is True


@pytest.mark.parametrize("direction", ["I", "O"])
def test_uci_and_udi_end_the_limit_role(bench, direction):
    """3.1: "reassign the limits": after UCI and UDI, or as outputs, the pins are not limits."""
    motor = bare(bench)
    assert send(bench, motor, f"UC=1 UD=1 UC{direction} UD{direction} ZS", 0.01) == b""
    assert ask(bench, motor, "RW") == "128"


@pytest.mark.parametrize(("command", "moves"), [("UG", True), ("UGI", False), ("UGO UG=1", False)])
def test_a_falling_edge_at_pin_g_is_a_go_while_it_has_that_role(bench, motor, command, moves):
    """12: "synchronous go" is the role of pin G at power-up; UGI ends this role, and UG begins it again."""
    send(bench, motor, f"UGI {command} P=100 V=1000000 A=1000", 0.01)
    motor.pins["G"].drive(False)
    bench.run(0.5)
    assert ask(bench, motor, "RP") == ("100" if moves else "0")


def test_pins_e_and_f_are_channel_1_or_inputs_and_outputs(bench, motor):
    """12: at power-up pins E and F are channel 1; UEO makes pin E an output."""
    port = motor.rs485
    send(bench, motor, "UEO OCHN(RS4,1,N,9600,1,8,C)")
    assert motor.pins["E"].level is True
    assert send(bench, port, "RP") == b"0\r"
    send(bench, motor, "UEO")
    assert send(bench, port, "RP") == b""


# The brake's signal (5.1)


@pytest.mark.parametrize(("brake", "name"), [("BRKC", "C"), ("BRKG", "G")])
def test_writing_to_the_brakes_pin_takes_its_function_away(bench, motor, brake, name):
    """5.1 note 2: such commands change the function of the pin "and may cause the brake to release"."""
    pin = motor.pins[name]
    send(bench, motor, f"U{name}O {brake}")
    assert pin.level is True  # 5 V: the motor is off, so the brake is engaged
    send(bench, motor, f"U{name}=0")
    assert pin.level is False
    send(bench, motor, "BRKENG")
    assert pin.level is False
    send(bench, motor, brake)
    assert pin.level is True


@pytest.mark.parametrize(("brake", "name"), [("BRKC", "C"), ("BRKG", "G")])
def test_as_an_input_the_pin_does_not_follow_the_brake(bench, motor, brake, name):
    """5.1 note 2: UCI or UGI makes the pin an input, without the brake's signal; note 1: UCO or UGO come first."""
    pin = motor.pins[name]
    send(bench, motor, f"U{name}O {brake} U{name}I BRKRLS")
    assert pin.level is True  # the pull-up sets the level
    send(bench, motor, f"U{name}O {brake}")
    assert pin.level is False


# AniLink


def test_without_devices_anilink_reads_0(bench, motor):
    """12: without devices on the Anilink bus, AINpc, DINpc, AOUTp and DOUTpc read 0."""
    assert send(bench, motor, "a=5 a=AINA1 Ra a=5 a=DINH63 Ra AOUTA,512 DOUTB7,1 RBs") == b"0\r0\r0\r"


@pytest.mark.parametrize(("brake", "name"), [("BRKC", "C"), ("BRKG", "G")])
@pytest.mark.parametrize("read", ["a=U{}", "a=U{}I", "ab[7]=U{}+1", "aaa=(U{}==0)"])
def test_reading_the_brakes_pin_into_a_variable_takes_its_function_away(bench, motor, brake, name, read):
    """5.1 note 2: `<variable>=UG` makes the pin an input, as UGI does, even after BRKG."""
    pin = motor.pins[name]
    send(bench, motor, f"MP P=0 A=1 V=1 G U{name}O {brake}")
    assert (pin.level, pin.is_output) == (False, True)  # 0 V: the servo is on, so the brake is released
    send(bench, motor, read.format(name))
    assert (pin.level, pin.is_output) == (True, False)  # now an input; the pull-up sets its level
    send(bench, motor, brake)
    assert pin.is_output is False
    send(bench, motor, f"U{name}O {brake}")
    assert (pin.level, pin.is_output) == (False, True)


@pytest.mark.parametrize("name", ["C", "G"])
@pytest.mark.parametrize(
    "harmless", ["RU{}", "RU{}A", "RU", "a=U", "a=U{}A", "PRINT(U{})", "a=UA", "T=U{}", "Rab[U{}]"]
)
def test_reports_of_the_brakes_pin_leave_it_alone(bench, motor, name, harmless):
    """5.1 note 2: only `<variable>=UG` is named; RU{pin}, which reports an "input or output" (1.2), changes nothing."""
    send(bench, motor, f"U{name}O BRK{name} {harmless.format(name)}")
    assert motor.pins[name].is_output


@pytest.mark.parametrize("name", ["C", "G"])
def test_a_program_takes_the_brakes_pin_at_the_sample_of_its_assignment(bench, motor, name):
    """At one statement per sample, UGO, BRKG, BRKRLS, IF and a=UG: IF only reads the pin, a=UG changes its function."""
    load(bench, motor, f"U{name}O BRK{name} BRKRLS IF U{name} ENDIF a=U{name} b=1 END")
    seen = []
    motor.pins[name].subscribe(lambda pin: seen.append((bench.now // 245_760, pin.level, pin.is_output)))
    begin = (bench.now // 245_760) + 1
    send(bench, motor, "RUN", 0.01)
    assert send(bench, motor, "Ra Rb") == b"0\r1\r"
    assert [(sample - begin, *rest) for sample, *rest in seen] == [
        (0, False, True),
        (1, True, True),
        (2, False, True),
        (4, True, False),
    ]


@pytest.mark.parametrize("name", ["C", "G"])
def test_an_output_that_is_no_brakes_signal_is_read_and_stays_an_output(bench, motor, name):
    assert send(bench, motor, f"U{name}=0 U{name}O a=U{name} Ra U{name}=1 a=U{name} Ra") == b"0\r1\r"
    assert motor.pins[name].is_output


def test_the_go_role_stays_when_brkg_has_no_output(bench, motor):
    """5.1 note 1: BRKG without UGO sends no signal to pin G; then reading pin G leaves its synchronous go."""
    send(bench, motor, "BRKG a=UG A=65536 V=65536 P=10 MP")
    motor.pins["G"].drive(False)
    bench.run(0.01)
    assert motor.axes["shaft"].position == 10
