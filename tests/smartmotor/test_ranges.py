"""The ranges of parameters, and who may send each command (base language and 4.76 manual)."""

import pytest

from axistwin.bench import product
from axistwin.controllers.smartmotor.language.forms import Accept

from .talking import send, value

LARGEST = 2**31 - 1


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        *[(name, -LARGEST - 1, LARGEST) for name in ("P", "D", "V", "CLK")],  # base 4
        ("A", 0, LARGEST),
        ("E", 0, 32000),  # base 4: following error in counts
        ("T", -1023, 1023),
        ("AMPS", 0, 1023),
        ("TH", 0, 150),  # base 4: degrees
        ("THD", 0, 65535),  # base 4: samples
        *[(name, 0, 65535) for name in ("KP", "KI", "KD", "KL", "KV", "KA", "KG")],  # base 13: "Ranges 0…65535"
        ("KS", 1, 255),  # base 13: spacing of the derivative in samples
        ("F", 0, 255),  # 7.0: the functions are the bits 1 to 128
        ("MFMUL", -32768, 32767),
        ("MFDIV", -32768, 32767),
        ("BASE", 0, LARGEST),
        ("SIZE", 0, 101),  # 8.2: aw[0] to aw[101]
    ],
)
def test_only_values_in_the_range_are_accepted(bench, motor, name, low, high):
    """Base 4 and 13: a value out of range changes nothing and sets Bs; a value beyond 32 bits sets Bd."""
    for number, beyond in ((low, low - 1), (high, high + 1)):
        send(bench, motor, f"ZS {name}={number}", 0)
        assert value(bench, motor, name) == number and send(bench, motor, "RBs RBd", 0) == b"0\r0\r"
        send(bench, motor, f"{name}={beyond}", 0)
        assert value(bench, motor, name) == number
        assert send(bench, motor, "RBs RBd", 0) == (b"1\r0\r" if abs(beyond) <= LARGEST else b"0\r1\r")


HOST_ONLY = {"LOAD", "UPLOAD", "UP"}
PROGRAM_ONLY = {"RUN?", "WAIT=", "TWAIT", "!"}
BLOCKS = {
    "Cn", "IF", "ELSEIF", "ELSE", "ENDIF", "WHILE", "LOOP", "SWITCH", "CASE", "DEFAULT", "BREAK", "ENDS",
}  # fmt: skip
REMOVED = {"ES400", "ES1000", "KGON", "KGOFF", "LIMH", "LIML", "LIMN", "MFRATIO", "RES=", "MD50"}


def test_the_sources_of_a_command():
    """Base 8: blocks, labels and waits are for programs only; base 15: downloads for hosts only; 1.3: removed."""
    special = {
        **dict.fromkeys(HOST_ONLY, Accept.HOST), **dict.fromkeys(PROGRAM_ONLY, Accept.PROGRAM),
        **dict.fromkeys(BLOCKS, Accept.BLOCK), **dict.fromkeys(REMOVED, Accept.REMOVED),
    }  # fmt: skip
    commands = {str(command.code): command.accepted for command in product("smartmotor").commands}
    assert special.keys() <= commands.keys()
    wanted = {code: special.get(code, Accept.HOST | Accept.PROGRAM) for code in commands}
    assert {code: accepted for code, accepted in commands.items() if accepted != wanted[code]} == {}


@pytest.mark.parametrize(("code", "units"), [
    ("P=", {"counts"}), ("V=", {"1/65536 count/sample"}), ("A=", {"1/65536 count/sample²"}), ("E=", {"counts"}),
    ("T=", {"1/1023"}), ("AMPS=", {"1/1023"}), ("TH=", {"°C"}), ("THD=", {"samples"}), ("CLK=", {"samples"}),
    ("BASE=", {"master counts"}), ("BAUDn", {"bit/s"})])  # fmt: skip
def test_the_units_of_parameters(code, units):
    """Base 1: velocity in 1/65536 count per sample, acceleration per sample²; 9.1: BASE in external encoder counts."""
    assert {field.unit for field in product("smartmotor").commands.get(code).parameters} == units
