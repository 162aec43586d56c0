"""Chapter 5: the static brake, its signals on pins C and G, and the mode torque brake."""

from axistwin import Bench
from axistwin.bench import Controller

from .scripts import play, scripts
from .talking import send

MOVE = "A=65536 V=100*65536 P=20 G"  # a move of 1+2+3+4+4+3+2+1 = 20 counts in eight samples
FOR_EVER = "A=65536 V=65536*4 MV G"


def state(bench: Bench, motor: Controller) -> tuple[str, str, str, bool]:
    """Return mode, Bo, Bt, and the internal brake's signal."""
    mode, off, busy = send(bench, motor, "RMODE RBo RBt").decode().split()
    return mode, off, busy, motor.pins["brake"].level


def changes(bench: Bench, motor: Controller, name: str) -> list[tuple[int, bool]]:
    """Return a list that records every change of a pin, with the time in ns from now."""
    found: list[tuple[int, bool]] = []
    start = bench.now
    motor.pins[name].subscribe(lambda pin: found.append((bench.now - start, pin.level)))
    return found


# The signals on pins C and G


def test_brki_is_the_default_and_leaves_c_and_g_alone(bench, motor):
    """5.1: the signal is on the internal brake pin only."""
    send(bench, motor, "UCO UGO UC=1 UG=1")
    found = changes(bench, motor, "C"), changes(bench, motor, "G")
    send(bench, motor, MOVE, 0.1)
    assert motor.pins["brake"].level is False and found == ([], [])
    assert motor.pins["C"].level is motor.pins["G"].level is True


def test_brki_brkc_and_brkg_are_mutually_exclusive(bench, motor):
    """1.2, note: BRKI, BRKC and BRKG exclude each other; the last of them is in force."""
    send(bench, motor, "UCO UGO UC=0 UG=0 BRKC")
    assert motor.pins["C"].level is True
    send(bench, motor, "BRKG")
    assert motor.pins["G"].level is True
    before, found = motor.pins["C"].level, changes(bench, motor, "C")
    send(bench, motor, MOVE, 0.1)
    assert motor.pins["G"].level is False
    send(bench, motor, "OFF")
    assert motor.pins["G"].level is True and (motor.pins["C"].level, found) == (before, [])
    send(bench, motor, "BRKI")
    found = changes(bench, motor, "G")
    send(bench, motor, "G", 0.1)
    assert motor.pins["brake"].level is False and found == []


# The pins of the signal when they change their function (5.1, 1.2)


PINS = [("BRKC", "C"), ("BRKG", "G")]


HOLD = "MP D=0 G"


@scripts({
    # The static brake: BRKSRV, BRKTRJ, BRKRLS, BRKENG
    '5.2: "4.76 defaults to BRKSRV being the active state, as a result, MTB is active on power-up"':
    "RMODE RBo RBt -> B 1 0; brake is high",
    "2.0 item 2, 5.1: the fail-safe brake is engaged at power-up, before any command":
    "new; brake is high; RMODE -> B",
    '5.2, BRKSRV: "When Status bit Bo (motor-off) is 0, MTB will be disabled. When Bo is 1, MTB will be '
    'active"':
    f"{MOVE}; 0.1 s; RMODE RBo RBt -> P 0 0; brake is low; OFF; RMODE RBo RBt -> B 1 0; brake is high",
    "5.2: BRKTRJ engages the brake at once while the motor holds, because Bt is 0":
    f"{MOVE}; 0.1 s; brake is low; BRKTRJ; brake is high; RMODE -> B",
    '5.2 note 1: G "will turn off MTB and switch to the associated mode", each time':
    f"BRKTRJ {MOVE}; 0.1 s; brake is high; P=0 G; RMODE RBt -> P 1; brake is low; 20 samples; at 0; "
    "brake is high",
    "5.2: the brake engages whenever Bt becomes 0, whatever ended the trajectory":
    [f"BRKTRJ {FOR_EVER}; 0.1 s; brake is low; {ending}; 0.1 s; RBt -> 0; brake is high"
     for ending in ("S", "X", "OFF", "MTB")],
    "Base 14: BRKRLS releases and BRKENG engages; the servo and trajectories have no effect on the brake":
    f"BRKRLS; brake is low; {MOVE}; 0.1 s; brake is low; OFF; 0.1 s; brake is low; BRKENG; brake is high; "
    "BRKRLS BRKRLS BRKENG BRKENG; brake is high; RBs -> 0",
    # The signals on pins C and G
    '5.1: "The signal is 0 Vdc when brake is released ... 5 Vdc when brake engaged", besides the internal '
    "brake":
    [f"U{name}O {command}; {name} is high; {name} is 5.0 V; brake is high; {MOVE}; 0.1 s; {name} is low; "
     f"{name} is 0.0 V; brake is low; OFF; {name} is high; {name} is 5.0 V; brake is high"
     for command, name in (("BRKG", "G"), ("BRKC", "C"))],
    '5.1 notes 3, BRKSRV: "Driven low when not faulted"; the fault in this test is a position error':
    [f"U{name}O {command} E=50 {FOR_EVER}; 0.01 s; {name} is low; jam; 0.1 s; RBe -> 1; {name} is high"
     for command, name in (("BRKG", "G"), ("BRKC", "C"))],
    '5.1 notes 1: UGO (UCO) "must be issued to assign Port G as an Output before the BRKG command is issued"':
    [f"U{name}I {command} {MOVE}; 0.1 s; brake is low; {name} is high"
     for command, name in (("BRKG", "G"), ("BRKC", "C"))],
    '5.1: BRKC and BRKG send the signal to a pin "in addition to controlling the internal brake"':
    [f"UCO UGO {command} {MOVE}; 0.1 s; brake is low; BRKENG; brake is high"
     for command in ("BRKI", "BRKC", "BRKG")],
    "5.1: BRKC makes pin C an output with 5 V while engaged; this level is not taken for a limit":
    "wired; C released; UCO BRKC ZS; 0.01 s; C is high; RBr RBp -> 0 0",
    "5.1, 5.2: after a power cycle the defaults BRKI and BRKSRV are in force again":
    "UGO BRKG BRKTRJ BRKRLS OFF; power off; 0.1 s; power on; clear; RMODE RBo RBt -> B 1 0; brake is high; "
    f"UGO UG=1 {MOVE}; 0.1 s; RMODE RBo RBt -> P 0 0; brake is low; G is high",
    "5.0: the fail-safe brake is engaged while the motor has no power":
    "BRKRLS OFF; power off; brake is high",
    # MTB
    '1.2, MTB: "Immediately set mode torque brake"':
    f"{FOR_EVER}; 0.1 s; MTB; RMODE RBo RBt RV -> B 1 0 0; mark; 40 samples; moved 0",
    '5.2: "To turn off the dynamic brake (MTB) function issue BRKRLS and then OFF"':
    "BRKRLS; RMODE -> B; OFF; RMODE -> O",
    '3.2: "by issuing commands BRKRLS and OFF in this sequence"':
    "OFF BRKRLS; RMODE -> B",
    '5.2, BRKRLS: "stay inactive until the command MTB is issued. Issuing BRKENG will not activate MTB"':
    [f"BRKRLS OFF {between}; RMODE -> O; {MOVE}; 0.1 s; OFF; RMODE -> O; MTB; RMODE -> B; BRKSRV G OFF; "
     "RMODE -> B"
     for between in ("BRKENG", "BRKSRV", "BRKTRJ")],
    "5.2 note 1C: a position error applies MTB":
    f"E=50 {FOR_EVER}; 0.05 s; jam; 0.05 s; RBe RMODE RBo -> 1 B 1",
    "5.2 note 1B: overheat applies MTB":
    f"THD=100 {FOR_EVER}; 0.05 s; air 90; TH=30; 0.1 s; RBh RMODE RBo -> 1 B 1",
    # The pins of the signal when they change their function (5.1, 1.2)
    '5.1: "These commands will change the function of the I/O pin C": UCP and UCI; UCO makes an ordinary '
    "output":
    "UC=0 UCO BRKC; C is 5.0 V; UCP; 0.01 s; RBp -> 1; UCO ZS; 0.01 s; C is 0.0 V; BRKC; C is 5.0 V",
    # The static brake: BRKSRV, BRKTRJ, BRKRLS, BRKENG
    "5.2: the brake changes at the same time as Bo":
    f"watch brake; {MOVE}; 20 samples; OFF; 20 samples; brake went low @0 high @20",
    '5.2, BRKTRJ: "When Bt is 1, MTB will be disabled. When Bt is 0, MTB will be active"; a move of 8 samples':
    f"BRKTRJ; watch brake; {MOVE}; RMODE RBt -> P 1; 20 samples; brake went low @0 high @8; RMODE -> B; at 20",
    "5.2: while the servo holds and no trajectory is in progress, BRKSRV releases and BRKTRJ engages at once":
    [f"{MOVE}; 0.1 s; {'BRKENG' if not engaged else 'BRKRLS'}; brake is {'low' if engaged else 'high'}; "
     f"{command}; brake is {'high' if engaged else 'low'}"
     for command, engaged in (("BRKSRV", False), ("BRKTRJ", True))],
    # The signals on pins C and G
    '5.1 notes 4, BRKTRJ: "Driven low while trajectory bit is 1"':
    [f"U{name}O {command} BRKTRJ; watch {name}; {MOVE}; 20 samples; {name} went low @0 high @8"
     for command, name in (("BRKG", "G"), ("BRKC", "C"))],
    # MTB
    '5.2 note 1: they "will turn off MTB and switch to the associated mode"; with BRKSRV the brake follows Bo':
    [f"MTB {command}; RMODE RBo -> {letter} 0; brake is low"
     for command, letter in (("G", "P"), ("MT", "T"), ("MF1", "F"), ("MF2", "F"), ("MF4", "F"), ("MS", "S"))],
    "5.2 note 1 does not name these commands, so MTB stays; a buffered mode begins with G":
    [f"BASE=1000 SIZE=10 MTB {command}; RMODE RBo RBt -> B 1 0"
     for command in (
         "MP", "MV", "MFR", "MC", "MD", "BRKSRV", "BRKTRJ", "BRKENG", "P=100", "A=1", "OFF", "S", "X",
     )],
    '3.2 note 3.1, 5.2: BRKRLS OFF "also prevents MTB from automatically being issued upon any shaft fault"':
    [f"wired; {disable} {FOR_EVER}; 0.05 s; C high; 0.01 s; RMODE RBo RBt -> {letter} 1 0; "
     f"brake is {'high' if letter == 'B' else 'low'}"
     for disable, letter in (("", "B"), ("BRKRLS OFF", "O"))],
    # The pins of the signal when they change their function (5.1, 1.2)
    '1.2: "BRKG, BRKC, and BRKI are mutually exclusive"; the pin that loses the signal keeps its level':
    [f"U{name}={0 if engaged else 1} U{name}O {brake}{'' if engaged else f' {HOLD}'}; watch {name}; "
     f"BRKI BRKENG BRKRLS BRKSRV; {name} is {'high' if engaged else 'low'}; {name} unchanged; U{name}O; "
     f"{name} is {'low' if engaged else 'high'}"
     for brake, name in PINS for engaged in (True, False)],
    # the changes are those of HOLD, UG=1, BRKG, OFF and HOLD
    '5.1: "The I/O pin is set to 5 Vdc when brake engaged": no pulse of 0 V when UGO (UCO) is repeated':
    [f"U{name}=0 {brake} U{name}O; {name} is 5.0 V; watch {name}; U{name}O; {name} unchanged; {HOLD}; "
     f"U{name}=1 {brake} OFF U{name}O {HOLD}; {name} went low high low high low"
     for brake, name in PINS],
})  # fmt: skip
def test_brakes(script):
    play(script)
