"""Chapter 6, and 12 of the base language: the seven user pins."""

import pytest

from .scripts import play, scripts
from .talking import load, send

PINS = "ABCDEFG"


@scripts({
    '6.3: "1023 is 5.0 Vdc and 0 is zero volts"; halves are rounded upwards, e.g. 511.5 at 2.5 V to 512':
    [f"{name} {volts} V; RU{name}A a=U{name}A Ra -> {value} {value}"
     for volts, value in ((0.0, 0), (2.5, 512), (5.0, 1023), (1.0, 205)) for name in PINS],
    "a latch does nothing to an input":
    "UA=0; A is high",
    "A report of an output reads the pin's level, which a test lead can force against the output":
    "UAO UA=0; A high; RUA -> 1",
    '3.1: "reassign the limits": after UCI and UDI, or as outputs, the pins are not limits':
    [f"bare; UC=1 UD=1 UC{direction} UD{direction} ZS; 0.01 s; RW -> 128" for direction in ("I", "O")],
    '12: "synchronous go" is the role of pin G at power-up; UGI ends this role, and UG begins it again':
    [f"UGI {command} P=100 V=1000000 A=1000; 0.01 s; G low; 0.5 s; RP -> {'100' if moves else '0'}"
     for command, moves in (("UG", True), ("UGI", False), ("UGO UG=1", False))],
    "12: at power-up pins E and F are channel 1; UEO makes pin E an output":
    "UEO OCHN(RS4,1,N,9600,1,8,C); E is high; 485: RP -> 0; UEO; 485: RP",
    # The brake's signal (5.1)
    '5.1 note 2: such commands change the function of the pin "and may cause the brake to release"':
    [f"U{name}O {brake}; {name} is high; U{name}=0; {name} is low; BRKENG; {name} is low; {brake}; "
     f"{name} is high"
     for brake, name in (("BRKC", "C"), ("BRKG", "G"))],
    "5.1 note 2: UCI or UGI makes the pin an input, without the brake's signal; note 1: UCO or UGO come first":
    [f"U{name}O {brake} U{name}I BRKRLS; {name} is high; U{name}O {brake}; {name} is low"
     for brake, name in (("BRKC", "C"), ("BRKG", "G"))],
    # AniLink
    "12: without devices on the Anilink bus, AINpc, DINpc, AOUTp and DOUTpc read 0":
    "a=5 a=AINA1 Ra a=5 a=DINH63 Ra AOUTA,512 DOUTB7,1 RBs -> 0 0 0",
    "5.1 note 1: BRKG without UGO sends no signal to pin G; then reading pin G leaves its synchronous go":
    "BRKG a=UG A=65536 V=65536 P=10 MP; G low; 0.01 s; at 10",
    "all pins are inputs again after power up":
    f"{' '.join(f'U{name}O' for name in PINS)}; A is low; B is low; C is low; D is low; E is low; F is low; "
    "G is low; power cycle; A is high; B is high; C is high; D is high; E is high; F is high; G is high; "
    "clear; UAO; A is low; Z; 0.3 s; A is high",
    '5.1 note 2: only `<variable>=UG` is named; RU{pin}, which reports an "input or output" (1.2), changes '
    "nothing":
    [f"U{name}O BRK{name} {harmless.format(name)} -> *; {name} is output"
     for name in ("C", "G")
     for harmless in (
         "RU{}", "RU{}A", "RU", "a=U", "a=U{}A", "PRINT(U{})", "a=UA", "T=U{}", "Rab[U{}]",
     )],
    "an output that is no brakes signal is read and stays an output":
    [f"U{name}=0 U{name}O a=U{name} Ra U{name}=1 a=U{name} Ra -> 0 1; {name} is output" for name in ("C", "G")],
    "12: a latch that is written before UxO sets the level of the output without a glitch":
    "watch A; UA=1 UAO UAI UAO RUA -> 1; A unchanged; UA=0 UAI UAO; A went low high low",
    "5.1 note 2: `<variable>=UG` makes the pin an input, as UGI does, even after BRKG":
    [f"MP P=0 A=1 V=1 G U{name}O BRK{name}; {name} is low; {name} is output; {read.format(name)}; {name} is high; "
     f"{name} is input; BRK{name}; {name} is input; U{name}O BRK{name}; {name} is low; {name} is output"
     for name in "CG" for read in ("a=U{}", "a=U{}I", "ab[7]=U{}+1", "aaa=(U{}==0)")],
})  # fmt: skip
def test_io(script):
    play(script)


# AniLink


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
        (0, False, True), (1, True, True), (2, False, True), (4, True, False),
    ]  # fmt: skip
