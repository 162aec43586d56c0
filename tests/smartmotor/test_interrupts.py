"""Chapter 7: F=32 calls C1 at a fault, F=64 calls C2 at a falling edge of pin G."""

from .scenarios import COUNTING
from .scripts import play, scripts
from .talking import advance, ready, run, send, values


@scripts({
    # Calls of C1 and C2, and returns from C1 and C2
    '7.1, F=64: "when the I/O pin G goes from a high to low edge transition"; a low level alone calls nothing':
    f"run F=64{COUNTING}; G low; 200 samples; i is 0; j is 1; G high; 200 samples; i is 0; j is 1; G low; "
    "200 samples; i is 0; j is 2; G high; 200 samples; i is 0; j is 2; G low; 200 samples; i is 0; j is 3; "
    "G high; 200 samples; i is 0; j is 3; G low; 200 samples; i is 0; j is 4; G high; 200 samples; i is 0; "
    "j is 4",
    "without f 64 an edge calls nothing":
    f"wired; run F=0{COUNTING}; trigger; C high; 50 samples; i is 0; j is 0",
    "7.1: an edge calls C2; a pin that is already low when F=64 is given does not":
    f"G low; 50 samples; run F=64{COUNTING}; j is 0; G high; 50 samples; trigger; j is 1",
    '1.2, F=32: "on a new occurrence of motor protection fault"; 7.1: when Bp or Bm "becomes active"':
    [f"wired; run F=32{COUNTING}; {names} high; 50 samples; i is 1; j is 0; {names} low; ZS; 50 samples; "
     f"i is 1; j is 0; {names} high; 50 samples; i is 2; j is 0; {names} low; ZS; 50 samples; i is 2; "
     f"j is 0; {names} high; 50 samples; i is 3; j is 0; {names} low; ZS; 50 samples; i is 3; j is 0"
     for names in ("C", "D")],
    "7.1: first Bp and then Bm are two occurrences, so C1 is called twice":
    f"wired; run F=32{COUNTING}; C high; 50 samples; D high; 50 samples; i is 2",
    '7.1: C1 is called when the limit "becomes active", not for a limit that already is':
    f"wired; C high; 50 samples; UCI ZS UCP; 50 samples; RBp -> 1; UCI ZS; 0.01 s; load {COUNTING.strip()}; "
    "UCP; 0.01 s; RUN; 0.01 s; F=32; 0.01 s; i is 0",
    '7.1: C1 is called for limits "via software or hardware limits"':
    f"wired; run F=32{COUNTING}; SLN=-5000 SLP=100 SLE A=65536 V=65536 P=1000 G; 90 samples; i is 0; "
    "30 samples; i is 1",
    "7.1: Bh (overheat) calls C1":
    f"run F=32{COUNTING}; THD=100 TH=10; 200 samples; RBh -> 1; i is 1",
    '1.2: "a new occurrence": if a limit opens while C1 handles a position error, C1 is called again '
    "afterwards":
    "wired; "
    "run F=32 / E=20 / A=65536 / V=65536 / MV / G / WHILE 1 / LOOP / END / C1 / i=i+1 / WAIT=60 / j=j+1 / "
    "RETURNF; jam; 30 samples; C high; 10 samples; i is 1; j is 0; 300 samples; i is 2; j is 2",
    "RULINGS 17: after the main program of 4.3 has ended, a fault calls C1; the main program does not "
    "continue":
    "wired; load F=32 / a=1 / END / a=2 / C1 / i=i+1 / RETURNF / a=3; RUN; 0.05 s; C high; 50 samples; i is 1; "
    "a is 1; C low; ZS; 0.01 s; C high; 50 samples; i is 2; a is 1",
    '7.1: RETURNI returns "to program pointer when the input was triggered"':
    f"run F=64{COUNTING}; trigger; keep m; 300 samples; m grew by 100",
    "7.1: a low level for the number of samples in option `debounce_samples` is an edge; a shorter one is not":
    [f"with debounce_samples={n}; run F=64{COUNTING}; G low; {n - 1} samples; G high; 50 samples; j is 0; G low; "
     f"{n} samples; G high; 50 samples; j is 1"
     for n in (1, 2, 5, 20)],
    '7.1: the pin is "polled once per sample", so a pulse between two polls is not detected':
    f"with debounce_samples=1; run F=64{COUNTING}; 0.00001 s; G low; 0.00019 s; G high; 50 samples; j is 0",
    # the switch bounces for less than seven samples; an edge requires eight equal samples
    '7.1: the pin "is de-bounced": 15 changes, 100 µs apart, before it stays low, and 15 before it stays high':
    f"with debounce_samples=8; run F=64{COUNTING}; "
    + 7 * "G low; 0.0001 s; G high; 0.0001 s; "
    + "G low; 0.0001 s; 100 samples; "
    + 7 * "G high; 0.0001 s; G low; 0.0001 s; "
    + "G high; 0.0001 s; 100 samples; j is 1",
    '4.1: "End program execution, if F=32 is not issued. If F=32 is issued, program goes to label C1"':
    [f"run F={functions}{COUNTING}; E=50 A=65536 V=65536*4 MV G; jam; 100 samples; RBe -> 1; keep m; 100 samples; "
     f"i is {functions // 32}; m {how}"
     for functions, how in ((0, "kept"), (32, "grew"))],
})  # fmt: skip
def test_interrupts(script):
    play(script)


# Calls of C1 and C2, and returns from C1 and C2


def test_a_jammed_motor_overheats_and_calls_c1(bench):
    """7.1, Bh: "this is also RMS over-current"; here full torque on a shaft that cannot turn."""
    motor = ready(bench, shaft={"motor": "frame23"})
    run(bench, motor, "F=32\nMT\nT=1023" + COUNTING)
    motor.axes["shaft"].jam(True)
    assert any(send(bench, motor, "RBh", 0.1) == b"1\r" for _ in range(600))
    advance(bench, 20)
    assert values(bench, motor, "i") == [1] and send(bench, motor, "RMODE RBo", 0) == b"B\r1\r"
