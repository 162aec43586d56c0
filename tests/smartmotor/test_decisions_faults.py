"""Decisions of docs/fidelity.md on limits, faults, functions, the brake's pin, cam and host mode."""

from .bits import BE, BL, BM, BO, BP, BR
from .scenarios import points, position
from .scripts import play, scripts

CRUISE = "A=65536 V=65536*10 MV G"  # one count per sample², ten counts per sample
COUNTING = "WHILE 1 a=a+1 LOOP "


@scripts({
    # F=2 and the limit switches
    '7.1: the shaft spins "in the opposite direction for any given mode"; 3.1: pin C is the positive limit. '
    "The pins belong to commanded directions: with F=2 a positive move reaches the switch on D, and does not "
    "stop there":
    [f"bare limits=-500,500; ZS F=2 MP A=65536 V=65536*10 P={target} G; 1.0 s; at {-target}; W {flags}"
     for target, flags in ((2000, BL + BM), (-2000, BR + BP))],
    # F=1 and a position error
    '4.1, item 1: "Turn off servo amplifier, if F=1 is not issued"':
    f"{CRUISE}; 0.01 s; jam; 110 samples; free; W eo",
    # Zl and Zr
    '3.1: "left limit (Port C)", "right limit (Port D)"; but its first line and table 4.1 exchange C and D':
    [f"C low; D low; UCP UDM ZS; 0.01 s; {pin} released; 2 samples; W {flags + BO}; {pin} low; 2 samples; "
     f"{leaves}; W {(flags & BR + BL) + BO}; {clears}; W o"
     for pin, flags, clears, leaves in (("C", BR + BP, "Zr", "Zl"), ("D", BL + BM, "Zl", "Zr"))],
    # What a fault inhibits
    '3.2, 4.1: G, MT, MF1, MF4, MS, S and X are inhibited; 5.2 adds MF2; 2.0, item 5: "No further shaft '
    'movement"':
    [f"bare; A=65536 V=65536 {command}; master 1000 in 0.01 s; 0.05 s; at 0; RMODE -> B"
     for command in ("MF2", "MFR G", "MSR G", "MV G", "BASE=8 SIZE=4 MC G")],
    '4.1: "during a motor protection fault the "RUN" command is inhibited"; GOSUB is not named, so it works':
    [f"load a=1 END C5 a=5 RETURN ; {CRUISE}; 0.01 s; jam; 110 samples; free; {command}; 0.01 s; "
     f"Ra -> {value}"
     for command, value in (("GOSUB5", "5"), ("GOTO5", "5"), ("RUN", "0"))],
    # The brake's pin
    '5.1, note 2: such commands "will change the function of the I/O pin G": pin G becomes the direction line':
    [f"UGO BRKG; G is high; {command}; 0.1 s; G is low; BRKRLS BRKENG; G is low"
     for command in ("RS4", "OCHN(RS4,0,N,9600,1,8,C)")],
    # Mode cam and host mode
    '6.1: PRINT(U) "to communication channel 0", PRINT1(U) to channel 1, RU "to current communication '
    'channel"':
    "OCHN(RS4,1,N,9600,1,8,C); 485 writes PRINT(U,UA,#13) PRINT1(1,#13) RU<SP>; 0.1 s; receives 1271<CR>; "
    "485 receives 1<CR>127<CR>",
    # F=32 without C1
    '7.1, F=4: "user program prints and report command"; 6.1: "To current communication channel" for a host':
    'OCHN(RS4,1,N,9600,1,8,C) F=4 UG; RP PRINT("x",#13) RUA -> 0 x 1; 0.1 s; 485 receives nothing; '
    "485 writes RUA<SP>; 0.1 s; 485 receives 1<CR>; receives nothing",
    "7.1, 3.1: pin C stops commanded positive moves with F=2 too, so a motor with exchanged switches is protected":
    [f"C low; D low; UCP UDM ZS F=2 A=65536 V={speed}*65536 MV G; 0.01 s; 2 steps of {-speed}; {pin} released; "
     f"2 samples; W {flags + BO}; still"
     for pin, speed, flags in (("C", 10, BR + BP), ("D", -10, BL + BM))],
    # A=1 gives steps of 9 8 7 … 1 0 counts in ten samples, the servo on; then MTB, or holding if MTB is disabled
    '4.1, motor protection fault, item 1: "If F=1 is issued, the controller decelerates to a stop"; 4.2, 7.1: '
    "limits":
    [f"{disable}F=1 {CRUISE}; 0.01 s; jam; 101 samples; W te; "
     + "; ".join(f"RV -> {speed * 65536}; 1 sample" for speed in range(10, 0, -1))
     + f"; 3 samples; W {BE + off}; RMODE RV -> {mode} 0"
     for disable, off, mode in (("", BO, "B"), ("BRKRLS OFF ", 0, "V"))],
    '4.1, item 4: "program goes to label C1": without C1 a position error ends the program, a limit does not':
    [f"C low; D low; load F={f} {COUNTING}; UCP UDM ZS RUN {CRUISE}; 0.05 s; C released; 20 samples; keep a; "
     "0.05 s; "
     f"a grew; C low; ZS {CRUISE}; 0.05 s; jam; 101 samples; keep a; 0.05 s; a kept; RBs -> 0"
     for f in (0, 32)],
    '9.1: a dwell is "the number of external encoder counts", "can be set to zero"; below zero it acts as zero':
    "MF4 F=16 D=-50 BASE=80 SIZE=4 aw[0] 0 10 20 30 40. MC G; "
    + "; ".join(f"master 10 in 0 s; 2 samples; at {place}" for place in range(5, 65, 5)),
    # on the way to 400, not to 999
    '10.1: times may be omitted "Having sent the first two times"; an earlier position without time is replaced':
    f"MD {points((0, 0))}{position(999)}{points((400, 100))}G; 50 samples; at > 189; at < 205; RBs -> 0",
})  # fmt: skip
def test_decisions_faults(script):
    play(script)
