"""State of a 4.76 motor at power-up: sections 1.2 to 1.4 and 2.0, and the power-on defaults."""

import pytest

from axistwin import Bench
from axistwin.bench import Controller

from .talking import ask, bare, load, send, value

BS, LIMITS = 8192, 1024 + 512 + 4 + 2
ZERO = [
    "A", "V", "P", "D", "T", "F", "SLN", "SLP", "CTR", "EPTR", "KV", "KA", "KG", "a", "z", "aa", "zz", "aaa", "zzz",
    "ab[0]", "ab[203]", "aw[101]", "al[50]", "@P", "@PE", "@V",
]  # fmt: skip
OTHER = {"E": 1000, "AMPS": 1023, "MFMUL": 1, "MFDIV": 1, "KS": 1, "TH": 70, "U": 127, "ADDR": 0, "Bo": 1, "Bt": 0}
DEFAULTS = dict.fromkeys(ZERO, 0) | OTHER
REMOVED = ["ES400", "ES1000", "KGON", "KGOFF", "LIMH", "LIML", "LIMN", "MFRATIO", "RES=2000", "MD50"]
ADDED = [
    *[
        "BRKC", "BRKG", "BRKI", "CI", "F=2", "F=16", "F=32", "F=64", "F=128", "MTB", "SLD", "SLE", "SLN=-5", "SLP=5",
        "Ze", "Zh",
    ],
    *["RU", "RUA", "RUB", "RUC", "RUD", "RUE", "RUF", "RUG", "RUAA", "RUBA", "RUCA", "RUDA", "RUEA", "RUFA", "RUGA"],
    *["a=CX", "a=U", "PRINT(CX)"],
]  # fmt: skip


@pytest.fixture
def unwired(bench: Bench) -> Controller:
    return bare(bench)


def test_with_nothing_wired_it_boots_in_fault(bench, unwired):
    """2.0 item 1: "With nothing wired to limits, motor will boot-up in fault condition".

    RW is 1670: Br 2 + Bl 4 + Bo 128 + Bp 512 + Bm 1024.  U is 127: all seven pins are pulled up.
    """
    assert send(bench, unwired, "RS RW RPW RU RBr RBl RBp RBm RBo RBt") == b"134\r1670\r0,1670\r127\r1\r1\r1\r1\r1\r0\r"


def test_the_default_mode_is_mode_torque_brake(bench, unwired):
    """2.0 item 2: "Default Mode is Mode-Torque Brake"; 5.2: "RMODE will report "B" when MTB is active"."""
    assert ask(bench, unwired, "RMODE") == "B"


def test_the_default_brake_control_is_brksrv(bench, unwired):
    """2.0 item 3: the brake is engaged while Bo is 1 and released while Bo is 0, whether the motor moves or not."""
    assert unwired.pins["brake"].level
    send(bench, unwired, "UCI UDI ZS")
    assert unwired.pins["brake"].level
    send(bench, unwired, "G")
    assert ask(bench, unwired, "RW") == "0"
    assert not unwired.pins["brake"].level
    send(bench, unwired, "OFF")
    assert unwired.pins["brake"].level


@pytest.mark.parametrize("command", ["G", "MT", "MF1", "MF2", "MF4", "MS", "S", "X", "MV G", "MP D=5 G", "MT T=500 G"])
def test_no_movement_can_be_commanded_until_the_faults_are_cleared(bench, unwired, command):
    """2.0 item 5 and 3.1: in a fault such a command moves nothing, changes no flag, and is no syntax error."""
    send(bench, unwired, "A=65536 V=65536 P=1000 T=1023")
    unwired.master.move(1000, 0.01)
    send(bench, unwired, command, 0.1)
    assert send(bench, unwired, "RW RMODE RP") == b"1670\rB\r0\r"
    assert unwired.axes["shaft"].position == 0
    assert unwired.axes["shaft"].commanded == 0


def test_a_go_on_pin_g_is_inhibited_too(bench, unwired):
    """4.1: "G-synchronization function on I/O pin G is inhibited"; without a fault the same edge starts the motor."""
    send(bench, unwired, "A=65536 V=65536 P=100")
    unwired.pins["G"].drive(False)
    bench.run(0.1)
    assert unwired.axes["shaft"].position == 0
    unwired.pins["G"].release()
    send(bench, unwired, "UCI UDI ZS", 0.1)
    assert unwired.axes["shaft"].position == 0
    unwired.pins["G"].drive(False)
    bench.run(0.1)
    assert unwired.axes["shaft"].position == 100


def test_a_program_cannot_be_downloaded_in_a_fault(bench, unwired):
    """2.0 item 6: LOAD is acknowledged only after the fault has been cleared."""
    assert send(bench, unwired, b"LOAD ") == b""
    send(bench, unwired, "UCI UDI ZS")
    assert ask(bench, unwired, "RW") == "128"
    load(bench, unwired, "a=7\nEND\n")
    send(bench, unwired, "RUN", 0.01)
    assert ask(bench, unwired, "Ra") == "7"


@pytest.mark.parametrize(
    ("cure", "target"),
    [
        ("ZS", 1000), ("ZS", -1000), ("UCI ZS", -1000), ("UDI ZS", 1000), ("Zr Zl", 1000), ("UCI UDI", 1000),
        ("UCI UDI Zr", 9),
    ],
)  # fmt: skip
def test_half_a_remedy_leaves_the_fault(bench, unwired, cure, target):
    """3.1: both inputs must be reassigned or grounded, and then the flags cleared; one of these steps is not enough."""
    send(bench, unwired, cure)
    send(bench, unwired, f"A=65536 V=65536 P={target} G", 0.1)
    assert send(bench, unwired, b"LOAD ") == b""
    assert unwired.axes["shaft"].position == 0
    assert ask(bench, unwired, "RBo") == "1"


@pytest.mark.parametrize("cure", ["UCI UDI ZS", "UDI UCI Zl Zr", "UCI UDI Zr Zl Zr Zl", "ZS UCI UDI ZS ZS"])
def test_the_sample_code_of_section_3_1_clears_it(bench, unwired, cure):
    """3.1 note 3: the sample code is UCI, UDI, ZS; clearing the flags one by one instead of ZS works too."""
    assert send(bench, unwired, cure) == b""
    assert send(bench, unwired, "RS RW") == b"128\r128\r"


def test_grounding_the_pins_clears_it_as_well(bench, unwired):
    """3.1 step 2: "or grounding Ports C and/or D" clears the real-time bits; the historical bits stay."""
    unwired.pins["C"].drive(0.0)
    unwired.pins["D"].drive(False)
    bench.run(0.01)
    assert ask(bench, unwired, "RW") == "134"
    send(bench, unwired, "Zr")
    assert ask(bench, unwired, "RW") == "132"
    send(bench, unwired, "Zl")
    assert ask(bench, unwired, "RW") == "128"


def test_limits_are_wired_from_the_first_moment(bench):
    """A motor whose limit switches are closed before power-up boots without a fault."""
    motor = bare(bench, shaft={"limits": (-1000, 1000)})
    assert send(bench, motor, "RW RMODE RU") == b"128\rB\r115\r"


@pytest.mark.parametrize("name", DEFAULTS)
def test_a_power_on_default(bench, unwired, name):
    """Reference 16: the value after power-up."""
    assert value(bench, unwired, name) == DEFAULTS[name]


def test_a_power_cycle_and_z_restore_every_default(bench, motor):
    """A power cycle and Z restore every default; CLK counts samples from 0 again."""
    for restart in (motor.power_cycle, lambda: send(bench, motor, "Z")):
        send(
            bench,
            motor,
            "UCI UDI ZS A=5 V=5 P=5 D=5 E=5 AMPS=5 F=5 SLN=5 SLP=6 SLE KS=5 MFMUL=5 TH=50 a=5 zzz=5 al[50]=-1",
        )
        send(bench, motor, "BRKTRJ O=5 MV aw[0]=1 EPTR=5 UAO UA=0 CLK=1000000 MF0")
        restart()
        bench.run(0.5)
        motor.serial.read()
        assert send(bench, motor, "RW RMODE") == b"1670\rB\r"
        assert {name: value(bench, motor, name) for name in DEFAULTS} == DEFAULTS
        assert value(bench, motor, "CLK") < 2600


def test_the_firmware_is_4_76(bench, unwired):
    """Page 1: firmware 4.76; RSP reports 24576/476."""
    assert ask(bench, unwired, "RSP") == "24576/476"


@pytest.mark.parametrize("command", ADDED)
def test_a_command_added_is_known(bench, motor, command):
    """1.2: the commands that 4.76 has added are accepted."""
    answer = send(bench, motor, command)
    assert (b"\r" in answer) == command.startswith("R")
    assert ask(bench, motor, "RBs") == "0"


@pytest.mark.parametrize("command", REMOVED)
def test_a_command_removed_is_a_syntax_error(bench, motor, command):
    """1.3: the commands that 4.76 has removed are syntax errors."""
    assert send(bench, motor, command) == b""
    assert ask(bench, motor, "RW") == str(128 + BS)


@pytest.mark.parametrize("moment", [0.0, 0.0001, 0.1, 0.199, 0.2, 0.3])
def test_cleared_at_any_moment_it_stays_cleared(bench, moment):
    """Faults can be cleared at any time, in the first sample and in the boot window too."""
    motor = bench.add("smartmotor", line="instant")
    bench.run(moment)
    send(bench, motor, "UCI UDI ZS", 0.5)
    assert ask(bench, motor, "RW") == "128"


def test_power_cut_in_the_middle_of_a_move_and_of_a_command(bench, motor):
    """A power cut ends the move and the command; the shaft stays where it stopped, and counts begin at 0 again."""
    send(bench, motor, "A=65536 V=65536 P=100000 G RP", 0.1)
    motor.serial.write(b"A=123")
    bench.run(0.01)
    motor.power(False)
    bench.run(0.01)
    stood = motor.axes["shaft"].position
    assert stood > 100
    assert send(bench, motor, "RP", 0.1) == b""
    assert motor.axes["shaft"].position == stood
    assert motor.pins["brake"].level
    motor.power(True)
    bench.run(0.5)
    assert send(bench, motor, "4 RP RA RW") == f"0\r0\r{1670 + BS}\r".encode()
    assert motor.axes["shaft"].position == stood
