"""Moves of at most 400 counts, outputs and limits; and cases for a motor without a machine, whose shaft is free."""

from collections.abc import Mapping
from functools import partial

from axistwin.controllers.smartmotor.language.forms import Instruction
from axistwin.real.probing.cases import Case
from axistwin.real.probing.smartmotor.memory import loaded
from axistwin.real.probing.smartmotor.still import case

PINS = "ABCDEFG"
WORD = "PRINT(W&65271,#13)"  # The status word without Bi and Bx, which depend on the place of the index mark.
ASKS = ("RBt", "RMODE", "RBe", WORD)
MOVE_S = 0.3
CYCLE = "UA=0 UB=0 UA=1 UB=1"  # One period of an encoder on pins A and B, forwards, made by the motor's own outputs.
BACK = "UB=0 UA=0 UB=1 UA=1"
ENCODER = "UA=1 UB=1 UAO UBO"
STEPS = "UA=0 UA=1 UA=0 UA=1"
CALM = "UCI UDI ZS MP A=1000 V=100000"
INTERRUPTS = """\
PRINT("boot",#13)
RUN?
PRINT("run",#13)
END
C1
q=q+1
RETURNF
C2
r=r+1
RETURNI
C40
D=50
G
TWAIT
o=Bt
RETURN
C41
UG=1
WAIT=20
UG=0
WAIT=3
UG=1
RETURN
C42
P=200
G
WAIT=10
S
o=Bt
RETURN
"""


def moves(commands: Mapping[str, Instruction]) -> list[Case]:
    return [*_small(commands), *_limits(commands), *_pins(commands), *_bare(commands), *_at_the_end(commands)]


def _small(commands: Mapping[str, Instruction]) -> list[Case]:
    def move(name: str, code: str, *lines: str, wait_s: float = MOVE_S) -> Case:
        return case(name, commands[code].chapter, *lines, *ASKS, moves=True, wait_s=wait_s)

    return [
        case("limits as inputs", commands["UCI"].chapter, CALM, *ASKS, bare=True),
        move("settings for the moves", "G", "ZS", "OFF MP", "A=1000", "V=100000", "O=0", "RP", wait_s=0),
        move("an absolute move", "P=", "P=200", "G", "RP", "RPW", "P=0", "G", "RP"),
        move("a relative move", "D=", "D=100", "G", "RP", "RD", "D=-100", "G", "RP"),
        case("the index", commands["RI"].chapter, "Zs RI RBi", "V=400000 P=4100 G", "RBi", "P=0 G", "RI RBi",
             "V=100000", *ASKS, bare=True, wait_s=1.2),
        move("a jog and its end", "MV", "MV", "V=20000", "G", "RV", "X", "MP"),
        move("a slow stop and a fast one", "S", "A=10 MV V=20000", "G", "X RBt", "V=-20000 MV G", "S RBt RV", "A=1000"),
        move("G after a stop", "S", "MV V=20000 G", "S D=0 G", "RMODE", "MV G", "X", "G", "RMODE", "S MP V=100000"),
        move("a stop", "S", "MV", "V=-20000", "G", "S", "MP", "V=100000"),
        move("a new origin", "O=", "O=1000", "RP", "O=0", "RP"),
        move("mode position after mode velocity", "MP", "MV", "MP P=0 G", "RMODE", "RP"),
        move("gains in use", "F", "zzz=KP", "KP=50", "F", "RKP", "KP=60", "F", "RKP", "KP=zzz", "F"),
        move("mode torque without torque", "MT", "T=0", "MT", "RT", "OFF MP"),
        move("the following error that is allowed", "E=", "zzz=E", "E=300 RE", "Zs E=32001 RBs RE Zs", "E=zzz"),
        move("the PWM limit", "AMPS=", "zzz=AMPS", "AMPS=500 RAMPS", "Zs AMPS=1024 RBs RAMPS Zs", "AMPS=zzz"),
        move("temperature limit and time", "TH=", "zzz=TH zz=THD", "TH=100 THD=20000 PRINT(TH,#32,THD,#13)",
             "Zs TH=151 RBs Zs THD=65536 RBs Zs", "TH=zzz THD=zz"),
        move("outputs", "RU", "RUA", "UAO", "UA=1", "RUA", "UA=0", "RUA", "UAI"),
        move("the functions", "F=", "F=16 PRINT(F,#13)", "F=128 PRINT(F,#13)", "F=0 PRINT(F,#13)"),
        move("soft limits", "SLE", "SLN=-50", "SLP=50", "SLE", "SLD"),
        move("the filter's rate", "PIDn", "PID2", "RSP", "PID1", "RSP", "Zs PID3 RBs Zs"),
        move("a host's wrap of the position", "Zw", "O=2147483640", "D=100 G", "RBw", "Zw RBw", "O=0 D=-0 P=0 G"),
        move("LIMD", "LIMD", "Zs LIMD RBs"),
        move("switched off", "OFF", "P=0 G", "OFF", "RMODE"),
    ]  # fmt: skip


def _limits(commands: Mapping[str, Instruction]) -> list[Case]:
    def move(name: str, code: str, *lines: str) -> Case:
        return case(name, commands[code].chapter, *lines, *ASKS, moves=True, wait_s=MOVE_S)

    return [
        move("a positive soft limit", "SLP=", "ZS O=0 SLN=-40 SLP=40 SLE", "P=100 G", "RBr RBp", "SLP=50 RBs",
             "SLD Zr Zs", "RBr", "P=0 G", "RP"),
        move("a negative soft limit", "SLN=", "ZS O=0 SLN=-40 SLP=40 SLE", "P=-100 G", "RBl RBm", "SLN=50 RBs",
             "SLD Zl Zs", "RBl", "P=0 G", "RP"),
        move("a fault and all flags", "ZS", "ZS O=0 SLP=30 SLE P=100 G", "RBr", "G RBt", "SLD ZS", "RBr", "P=0 G",
             "SLP=0"),
        move("deceleration after a fault", "F=", "ZS O=0 SLP=30 SLN=-90 SLE F=1 A=100 P=400 G", "RMODE",
             "F=0 SLD ZS A=1000", "P=0 G", "RP", "Zs F=256 RBs Zs"),
        move("the shaft's direction", "F=", "OFF O=0 F=2", "P=50 G", "RP", "OFF F=0 RP", "O=0 P=-50 G", "RP",
             "OFF O=0"),
    ]  # fmt: skip


def _pins(commands: Mapping[str, Instruction]) -> list[Case]:
    found = []
    for pin in PINS:
        says = (f"RU{pin}", f"U{pin}=0", f"RU{pin}", f"U{pin}O", f"RU{pin} RU{pin}A", f"U{pin}=1 RU{pin} RU{pin}A",
                f"U{pin}=0 RU{pin}", f"U{pin}I", f"RU{pin} RU{pin}A", f"U{pin}=1")  # fmt: skip
        found.append(
            case(f"pin {pin} as output and input", commands[f"U{pin}O"].chapter, *says, moves=True, bare=pin in "CD")
        )
    return [
        *found,
        case("the limits' pins", commands["UCP"].chapter, "UCP", f"RBp RBr {WORD}", "UDM", f"RBm RBl {WORD}",
             "UCI Zr", "RBp RBr", "UDI Zl", f"RBm RBl {WORD}", bare=True),
        case("a limit's pin is an input", commands["UCP"].chapter, "UC=0 UCO RUC", "UCP RUC", "UCI UC=1 ZS",
             "UD=0 UDO RUD", "UDM RUD", "UDI UD=1 ZS", bare=True),
        case("the pin for G is an input", commands["UG"].chapter, "UG=0 UGO RUG", "UG RUG", "UG=1", moves=True),
        case("RS-485 and RS-232", commands["RS4"].chapter, "UGI", "RS4", "RUG", "RS2", "RUG", "UG", bare=True),
    ]  # fmt: skip


def _bare(commands: Mapping[str, Instruction]) -> list[Case]:
    def free(name: str, code: str, *lines: str | bytes, wait_s: float = MOVE_S) -> Case:
        return case(name, commands[code].chapter, *lines, *ASKS, bare=True, wait_s=wait_s)

    two = f"{CYCLE} {CYCLE}"
    table = b"aw[0] 0 40 80 40 0.\r"
    cam = partial(_cam, commands, two, table)
    return [
        free("an encoder's counts", "MF0", f"OFF O=0 {ENCODER}", two, "MF0 RCTR", two, "RCTR", BACK, "RCTR"),
        *(free(f"mode follow, {code}", code, "OFF O=0", f"{code} RMODE", two, "RCTR RP", BACK, "RCTR RP", "OFF", "MP")
          for code in ("MF1", "MF2", "MF4")),
        free("mode follow with ratio", "MFR", "OFF O=0 MF0 MFMUL=3 MFDIV=2", "MFR G", two, "RMODE RP", "OFF MP"),
        free("a ratio divided by zero", "MFDIV=", "MFDIV=0 Zs MFR RBs Zs MSR RBs Zs", "MFMUL=1 MFDIV=1 MP"),
        free("steps counted", "MS0", "OFF O=0 MS0", STEPS, "RCTR", "UB=0", STEPS, "RCTR", "UB=1"),
        free("mode step", "MS", "OFF O=0 MS RMODE", STEPS, "RCTR RP", "OFF MP"),
        free("mode step with ratio", "MSR", "OFF O=0 MS0 MFMUL=5 MFDIV=1 MSR G", STEPS, "RMODE RP", "OFF MP",
             "MFMUL=1"),
        *map(cam, ("MC", "MC2", "MC4", "MC8")),
        free("a new cam", "CI", table, "OFF O=0 MF0 BASE=16 SIZE=4 MC G", two, "BASE=8 SIZE=2 MC CI", two,
             "PRINT(CX,#13) RP", two, "PRINT(CX,#13) RP", CYCLE, "PRINT(CX,#13) RP", "OFF MP"),
        free("a cam without room", "BASE=", "BASE=3 SIZE=4 Zs MC RBs Zs", "BASE=0 SIZE=0 MP"),
        free("the servo's encoder", "ENC1", "Zs ENC1 RBs Zs", "ENC0 RBs"),
        free("host mode", "MD", "OFF O=0 MP P=0 G", "MD", "RMODE Q", _point(0, 0), _point(40, 256), _point(80, 512),
             "Q", b"\xfb\x00\x00\x02\x00\r", "G RMODE", "a=0", "RP", "RMODE Q", "OFF MP"),
        free("direct binary commands", "A=", b"\xfc\x00\x00\x03\xe8", b"\xfd\x00\x01\x86\xa0", b"\xfe\x00\x00\x00\x1e",
             "RA PRINT(V,#32,P,#13)", "O=0 G", "RP", "P=0 G"),
        free("torque", "T=", "O=0 OFF T=30 MT RT", "RMODE", "T=-30", "OFF T=0", "O=0", wait_s=0.05),
        free("too hot", "TH=", "zzz=TH zz=THD", "TH=0 THD=2400", "RBh", "a=0", f"RBh RMODE {WORD}",
             "TH=zzz THD=zz Zh RBh", "ZS RBh"),
        free("the brake's signal on pin C", "BRKC", "UCO BRKC OFF RUC", "O=0 P=0 G RUC", "BRKENG RUC", "BRKRLS RUC",
             "OFF RMODE", "P=0 G BRKSRV RUC", "OFF RUC RMODE", "MTB RMODE", "P=0 G BRKTRJ RUC RMODE",
             "BRKSRV P=0 G RUC", "BRKI OFF RUC", "UC=1 RUC", "UCI ZS"),
        free("the brake's signal on pin G", "BRKG", "UGO BRKG OFF RUG", "O=0 P=0 G RUG", "a=UG RUG", "BRKI OFF UG ZS"),
        free("mode torque brake", "MTB", "P=0 G RMODE", "MTB RMODE", "BRKRLS OFF RMODE", "MTB RMODE BRKSRV"),
        free("the end of the encoder's outputs", "UAI", "OFF UAI UBI RUA RUB MP O=0"),
    ]  # fmt: skip


def _cam(commands: Mapping[str, Instruction], two: str, table: bytes, code: str) -> Case:
    lines = (
        table, f"OFF O=0 MF0 BASE=32 SIZE=4 {code} G", "RMODE", two, "PRINT(CX,#13) RP RCTR", two, "PRINT(CX,#13) RP",
    )  # fmt: skip
    return case(f"mode cam, {code}", commands[code].chapter, *lines, "OFF MP", *ASKS, bare=True, wait_s=MOVE_S)


def _point(position: int, clock: int) -> bytes:
    """Encode one trajectory point of host mode as two binary records: position and time (manual section 10.1)."""
    return b"\xfa" + position.to_bytes(4, "big") + b"\r\xfb" + clock.to_bytes(4, "big") + b"\r"


def _at_the_end(commands: Mapping[str, Instruction]) -> list[Case]:
    def stored(name: str, code: str, *lines: str, bare: bool = False) -> Case:
        return case(name, commands[code].chapter, *lines, moves=True, bare=bare, stores=True, wait_s=MOVE_S)

    return [
        loaded("load a program with interrupts", commands["RETURNF"].chapter, INTERRUPTS),
        stored("TWAIT with motion", "TWAIT", "ZS O=0 P=0 G", "o=9 GOSUB40", "Ro RP", "P=0 G", "RP"),
        stored("S of a program", "S", "o=9 GOSUB42", "Ro", "P=0 G"),
        stored("C1 after a fault", "RETURNF", "q=0 O=0 SLP=30 SLN=-90 F=32 SLE P=100 G", "Rq RBr", "SLD ZS P=0 G",
               "SLE P=100 G", "Rq", "F=0 SLD ZS", "P=0 G", "SLP=0 SLN=0 OFF"),
        stored("C2 after an edge on pin G", "RETURNI", "r=0 UG=1 UGO F=64", "UG=0", "Rr", "UG=1", "UG=0", "Rr",
               "Zs RETURNI RBs Zs", "F=0 UG=1 UG"),
        stored("a short pulse on pin G", "RETURNI", "r=0 UG=1 UGO F=64", "GOSUB41", "Rr", "F=0 UG"),
        stored("output of a program to channel 1", "F=", "F=4 RUN", "F=0 RUN", "END"),
        stored("RETURNF of a host", "RETURNF", "Zs RETURNF RBs Zs"),
        stored("Z, the total reset", "Z", "zz=7 A=5 F=16", "Z", f"Rzz RA {WORD}", "UCI UDI ZS", bare=True),
    ]  # fmt: skip
