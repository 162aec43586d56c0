"""State of a 4.76 motor at power-up: sections 1.2 to 1.4 and 2.0, and the power-on defaults."""

import pytest

from axistwin import Bench
from axistwin.bench import Controller

from .scripts import play, scripts
from .talking import bare, send, value

BS = 8192
ZERO = [
    "A", "V", "P", "D", "T", "F", "SLN", "SLP", "CTR", "EPTR", "KV", "KA", "KG", "a", "z", "aa", "zz", "aaa", "zzz",
    "ab[0]", "ab[203]", "aw[101]", "al[50]", "@P", "@PE", "@V",
]  # fmt: skip
OTHER = {"E": 1000, "AMPS": 1023, "MFMUL": 1, "MFDIV": 1, "KS": 1, "TH": 70, "U": 127, "ADDR": 0, "Bo": 1, "Bt": 0}
DEFAULTS = dict.fromkeys(ZERO, 0) | OTHER
REMOVED = ["ES400", "ES1000", "KGON", "KGOFF", "LIMH", "LIML", "LIMN", "MFRATIO", "RES=2000", "MD50"]
ADDED = [
    *["BRKC", "BRKG", "BRKI", "CI", "F=2", "F=16", "F=32", "F=64", "F=128", "MTB", "SLD", "SLE", "SLN=-5", "SLP=5",
      "Ze", "Zh"],
    *["RU", "RUA", "RUB", "RUC", "RUD", "RUE", "RUF", "RUG", "RUAA", "RUBA", "RUCA", "RUDA", "RUEA", "RUFA", "RUGA"],
    *["a=CX", "a=U", "PRINT(CX)"],
]  # fmt: skip


@pytest.fixture
def unwired(bench: Bench) -> Controller:
    return bare(bench)


@scripts({
    '2.0 item 1: "With nothing wired to limits, motor will boot-up in fault condition". RW is 1670: Br 2 + Bl '
    "4 + Bo 128 + Bp 512 + Bm 1024. U is 127: all seven pins are pulled up":
    "bare; RS RW RPW RU RBr RBl RBp RBm RBo RBt -> 134 1670 0,1670 127 1 1 1 1 1 0",
    '2.0 item 2: "Default Mode is Mode-Torque Brake"; 5.2: "RMODE will report "B" when MTB is active"':
    "bare; RMODE -> B",
    "2.0 item 3: the brake is engaged while Bo is 1 and released while Bo is 0, whether the motor moves or "
    "not":
    "bare; brake is high; UCI UDI ZS; 0.001 s; brake is high; G; 0.001 s; RW -> 0; 0.001 s; brake is low; OFF; "
    "0.001 s; brake is high",
    "2.0 item 5 and 3.1: in a fault such a command moves nothing, changes no flag, and is no syntax error":
    [f"bare; A=65536 V=65536 P=1000 T=1023; master 1000 in 0.01 s; {command}; 0.1 s; "
     "RW RMODE RP -> 1670 B 0; at 0; commanded 0"
     for command in (
         "G", "MT", "MF1", "MF2", "MF4", "MS", "S", "X", "MV G", "MP D=5 G", "MT T=500 G",
     )],
    '4.1: "G-synchronization function on I/O pin G is inhibited"; without a fault the same edge starts the '
    "motor":
    "bare; A=65536 V=65536 P=100; G low; 0.1 s; at 0; G released; UCI UDI ZS; 0.1 s; at 0; G low; 0.1 s; at 100",
    "2.0 item 6: LOAD is acknowledged only after the fault has been cleared":
    "bare; LOAD; UCI UDI ZS; RW -> 128; load a=7 / END; RUN; 0.01 s; Ra -> 7",
    "3.1: both inputs must be reassigned or grounded, and then the flags cleared; one of these steps is not "
    "enough":
    [f"bare; {cure}; A=65536 V=65536 P={target} G; 0.1 s; LOAD; at 0; RBo -> 1"
     for cure, target in (
         ("ZS", 1000), ("ZS", -1000), ("UCI ZS", -1000), ("UDI ZS", 1000), ("Zr Zl", 1000), ("UCI UDI", 1000),
         ("UCI UDI Zr", 9),
     )],
    "3.1 note 3: the sample code is UCI, UDI, ZS; clearing the flags one by one instead of ZS works too":
    [f"bare; {cure}; RS RW -> 128 128"
     for cure in ("UCI UDI ZS", "UDI UCI Zl Zr", "UCI UDI Zr Zl Zr Zl", "ZS UCI UDI ZS ZS")],
    '3.1 step 2: "or grounding Ports C and/or D" clears the real-time bits; the historical bits stay':
    "bare; C low; D low; 0.01 s; RW -> 134; Zr; RW -> 132; Zl; RW -> 128",
    "A motor whose limit switches are closed before power-up boots without a fault":
    "bare limits=-1000,1000; RW RMODE RU -> 128 B 115",
    "Reference 16: the value after power-up":
    [f"bare; {name} is {DEFAULTS[name]}" for name in DEFAULTS],
    "Page 1: firmware 4.76; RSP reports 24576/476":
    "bare; RSP -> 24576/476",
    "1.3: the commands that 4.76 has removed are syntax errors":
    [f"{command}; RW -> {128 + BS}" for command in REMOVED],
    "Faults can be cleared at any time, in the first sample and in the boot window too":
    [f"new; {moment} s; UCI UDI ZS; 0.5 s; RW -> 128" for moment in (0.0, 0.0001, 0.1, 0.199, 0.2, 0.3)],
    "1.2: the commands that 4.76 has added are accepted":
    [f"{command}{' => *<CR>' if command[0] == 'R' else ' -> *'}; RBs -> 0" for command in ADDED],
    "A power cut ends the move and the command; the shaft stays where it stopped, and counts begin at 0 again":
    "A=65536 V=65536 P=100000 G RP -> 0; 0.1 s; writes A=123; 0.01 s; power off; 0.01 s; at > 100; mark; RP; "
    "0.1 s; "
    f"moved 0; brake is high; power on; 0.5 s; 4 RP RA RW -> 0 0 {1670 + BS}; moved 0",
})  # fmt: skip
def test_boot_up_defaults(script):
    play(script)


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
        assert {name: value(bench, motor, name) for name in DEFAULTS} == DEFAULTS and value(bench, motor, "CLK") < 2600
