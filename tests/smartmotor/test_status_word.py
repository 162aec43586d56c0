"""The status word W and its low byte S: what sets and clears each bit (table 4.1, section 1.2, reference 10)."""

from hypothesis import assume, given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.bench import Controller

from .scripts import play, scripts
from .talking import UNIT, ask, ready, send

BITS = {letter: 1 << bit for bit, letter in enumerate("trliwehoxpmdusak")}
ARRAY_ERRORS = [
    "aw[102]=1", "ab[204]=1", "al[51]=1", "ab[-1]=1", "a=aw[102]", "Raw[102]", "n=300 ab[n]=1", "aw[101] 1 2 3.",
]  # fmt: skip
OVERFLOWS = ["a=1/0", "a=1%0", "a=2147483647+1", "a=-2147483648-1", "a=65536*65536", "a=2147483647 a=a+1"]
MISTAKES = [
    "J", "A", "A=", "a=", "a==1=", "G=1", "RQ", "RBz", "Zq", "GOSUB99", "GOTO99", "=5", "a=(1", "a=1)", "ZS=1", "A=1.5",
]  # fmt: skip


def bits(bench: Bench, motor: Controller) -> str:
    """Return the letters of the bits of RW that are 1, least significant first; RBx and RS must agree."""
    word = int(ask(bench, motor, "RW"))
    assert int(ask(bench, motor, "RS")) == word & 0xFF and ask(bench, motor, "RPW").split(",")[1] == str(word)
    singly = send(bench, motor, "".join(f"RB{letter} " for letter in BITS)).split()
    assert [int(bit) for bit in singly] == [int(word & value > 0) for value in BITS.values()]
    return "".join(letter for letter, value in BITS.items() if word & value)


@scripts({
    "RULINGS 10: a report of the status clears no bit":
    [f"bare; UCI UDI A5 a=1/0 aw[200]=0 -> *; {read} -> *; Bits rlodus; {read} -> *; Bits rlodus; "
     f"{read} -> *; Bits rlodus"
     for read in ("RW", "RS", "RBr", "RPW", "a=W", "a=S", "PRINT(W,#13)")],
    "x=W, x=S and the B letters have the same values in expressions as in reports":
    "a=1/0 b=W c=S d=Bd e=Bo f=Bt; Rb Rc Rd Re Rf -> 2176 128 1 1 0; PRINT(Bd+Bo+Bs,#13) -> 2",
    "Bt (1) and Bo (128) follow a move of 100 counts at one per sample; no Z command clears them":
    f"Bits o; A={UNIT} V={UNIT} P=100 G; 0.001 s; Bits t; ZS; 0.001 s; Bits t; 0.1 s; Bits ; OFF; Bits o; ZS; "
    "Bits o",
    'Reference 6: "Index out of range → command ignored, Bu=1"; Zu and ZS clear Bu':
    [f"{command}; Bits ou; Zs Zd Ze Zw Za; Bits ou; Zu; Bits o" for command in ARRAY_ERRORS],
    'Reference 3: "An unknown or malformed command is ignored and sets Bs; nothing is returned"; Zs, ZS clear '
    "it":
    [f"{command}; Bits os; Zd Zu Ze Zw Za; Bits os; Zs; Bits o" for command in MISTAKES],
    'Reference 10: Bi means a captured index, "cleared by RI or by using I"; then the next index is captured':
    f"with index_at=300; A={UNIT} V={UNIT} P=400 G; 0.2 s; Bits i; RI -> 300; Bits ; P=200 G; 0.2 s; Bits i; "
    "ZS a=I; Bits ; Ra -> 300",
    "Bx is real-time: 1 on the index mark, 0 next to it":
    f"with index_at=300; A={UNIT} V={10 * UNIT} P={299} G -> *; 0.1 s; RI -> *; Bits ; "
    f"A={UNIT} V={10 * UNIT} P={300} G -> *; 0.1 s; RI -> *; Bits x; A={UNIT} V={10 * UNIT} P={301} G -> *; "
    "0.1 s; RI -> *; Bits ",
    'Reference 10, 15: "Bk=1 after a broken download; program then does not auto-run"; no Z command clears Bk':
    "LOAD => <06>; sends a=5<LF>b=6<LF> -> *; power cycle; 0.5 s; receives *; UCI UDI ZS -> *; Bits ok; "
    "Ra -> 0; Zk ZS -> *; Bits ok; load a=5 / END; power cycle; 0.5 s; UCI UDI ZS -> *; Bits o; Ra -> 5",
    '3.1, ZS: "Reset all system state flags"':
    f"A={UNIT} V={UNIT} O=2147483645 MV G; 0.01 s; S a=1/0 aw[200]=1 QQ UCP UDM; 0.01 s; Bits rlwopmdus; "
    "UCI UDI; 0.01 s; Bits rlwodus; ZS; Bits o",
    'Reference 17: "they must be silent and idempotent": Z commands return nothing and may be repeated':
    [f"A={UNIT} V={UNIT} P=5000 G; 0.01 s; {command} {command} {command}; Bits t"
     for command in ("Zr", "Zl", "Ze", "Zh", "Zs", "Zd", "Zu", "Zw", "Za", "Zb", "Zc", "Zf", "ZS")],
    "A Z command for a real-time bit is a syntax error; RULINGS 11: the manual's ZI is a typing error for Zl":
    [f"{command}; Bits os" for command in ("Zt", "Zo", "Zx", "Zp", "Zm", "ZI", "Zz")],
    "Status bits are read only: an assignment is a syntax error and has no other effect":
    [f"B{letter}=1; Bits os" for letter in "trliwehoxpmdusakbcf"],
    'Reference 7: "the assignment is abandoned (old value kept) and Bd is set"; Zd and ZS clear Bd':
    [f"a=77 {command}; Bits od; a is {2147483647 if ' ' in command else 77}; Zs Zu Ze Zw Za; Bits od; Zd; Bits o"
     for command in OVERFLOWS],
    'Reference 4: "crossing ±2^31 sets Bw", here within 20 samples at one count each; Zw and ZS clear Bw':
    [f"A={UNIT} O={start} V={speed} MV; Bits o; G; 0.01 s; Bits tw; @P {sign} 0; S G Zd Zs Zu; Bits tw; S Zw; Bits"
     for start, speed, sign in ((2**31 - 5, UNIT, "<"), (-(2**31) + 5, -UNIT, ">"))],
    "Bx is the level of the index input":
    f"with index_at=300; A={UNIT} V={10 * UNIT} P=300 G; 0.1 s; index is high; RBx -> 1",
    "Ba: driving against a jam, a frame 23 needs the amplifier's full current; Za and ZS clear Ba":
    "with frame23; jam; E=32000 A=1000 V=400000 P=2000 G; 0.5 s; Bits a; OFF; 0.1 s; Bits oa; Zs Zd Zu Ze Zw; "
    "Bits oa; "
    "Za; Bits o",
})  # fmt: skip
def test_status_word(script):
    play(script)


@settings(deadline=None, max_examples=20)
@given(st.lists(st.binary(max_size=30).map(lambda data: bytes(b & 0x7F for b in data)), max_size=8))
def test_after_any_bytes_the_motor_answers(chunks):
    """No exception, endless loop or lost command; the same bytes one by one give the same result."""
    sent = b"".join(chunks)
    # after SLEEP or LOAD the motor does not answer; after ECHO it also returns the commands
    assume(not any(word in sent for word in (b"SLEEP", b"LOAD", b"ECHO")))
    ends = []
    for whole in (True, False):
        bench = Bench()
        motor = ready(bench)
        for chunk in chunks:
            for piece in [chunk] if whole else [bytes([byte]) for byte in chunk]:
                motor.serial.write(piece)
            bench.clock.run_to(bench.now + 1_000_000)
        send(bench, motor, b" \r", 0.01)
        ends.append(send(bench, motor, "RW RP RMODE"))
        assert send(bench, motor, "ZS z=41 z=z+1 Rz") == b"42\r"
    assert ends[0] == ends[1]
