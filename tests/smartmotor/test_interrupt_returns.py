"""Chapter 7: how C1 and C2 are left, when C2 is called again, and which pin roles call it."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.bench import Controller

from .talking import ask, load, ready, tell

SAMPLE_NS = 245_760


def samples(bench: Bench, count: int) -> None:
    bench.clock.run_to((-(-bench.now // SAMPLE_NS) + count) * SAMPLE_NS)


def running(bench: Bench, motor: Controller, program: str) -> None:
    load(bench, motor, program.strip() + "\n")
    tell(bench, motor, "RUN", 0)
    samples(bench, 100)


def value(bench: Bench, motor: Controller, name: str) -> int:
    return int(ask(bench, motor, f"R{name}", 0))


def trigger(bench: Bench, motor: Controller, low: int = 20, high: int = 20) -> None:
    motor.pins["G"].drive(False)
    samples(bench, low)
    motor.pins["G"].drive(True)
    samples(bench, high)


def main_with(c2: str) -> str:
    return f"""
UGI
F=64
WHILE 1
m=m+1
LOOP
END
C9
k=k+1
WHILE 1
n=n+1
LOOP
END
C2
j=j+1
{c2}
"""


# Re-entrance


def test_an_edge_during_c2_does_not_call_it_again(bench):
    """7.1: not "until a prior GOSUB2 call has been completed by" RETURNI."""
    motor = ready(bench)
    running(bench, motor, main_with("WHILE p==0\nLOOP\nRETURNI"))
    for _ in range(5):
        trigger(bench, motor)
        assert value(bench, motor, "j") == 1
    tell(bench, motor, "p=1", 0)
    samples(bench, 50)
    assert value(bench, motor, "j") == 1
    tell(bench, motor, "p=0", 0)
    trigger(bench, motor)
    assert value(bench, motor, "j") == 2


def test_return_instead_of_returni_leaves_c2_closed(bench):
    """7.1: "A return by RETURNI rather than RETURN"."""
    motor = ready(bench)
    running(bench, motor, main_with("RETURN"))
    trigger(bench, motor)
    before = value(bench, motor, "m")
    trigger(bench, motor)
    trigger(bench, motor)
    assert value(bench, motor, "j") == 1
    assert value(bench, motor, "m") > before


def test_stack_and_goto_complete_c2(bench):
    """7.1: "STACK (which should immediately be followed by GOTO)"; more often than any stack is deep."""
    motor = ready(bench)
    running(bench, motor, main_with("STACK\nGOTO9"))
    for count in range(1, 31):
        trigger(bench, motor)
        assert (value(bench, motor, "j"), value(bench, motor, "k")) == (count, count)
    assert ask(bench, motor, "RBs", 0) == "0"


def test_stack_in_the_main_program_after_a_plain_return(bench):
    """7.1: STACK completes it wherever it stands."""
    motor = ready(bench)
    program = "UGI\nF=64\nC5\nIF s==1\ns=0\nSTACK\nGOTO5\nENDIF\nGOTO5\nEND\nC2\nj=j+1\nRETURN\n"
    running(bench, motor, program)
    trigger(bench, motor)
    trigger(bench, motor)
    assert value(bench, motor, "j") == 1
    tell(bench, motor, "s=1", 0)
    samples(bench, 30)
    trigger(bench, motor)
    assert value(bench, motor, "j") == 2


def test_end_completes_c2(bench):
    """7.1: "Or, END"; the program has to be run again."""
    motor = ready(bench)
    running(bench, motor, main_with("END"))
    trigger(bench, motor)
    before = value(bench, motor, "m")
    samples(bench, 100)
    assert (value(bench, motor, "j"), value(bench, motor, "m")) == (1, before)
    tell(bench, motor, "RUN", 0)
    samples(bench, 30)
    trigger(bench, motor)
    assert value(bench, motor, "j") == 2


def test_a_hosts_end_and_run_complete_c2(bench):
    """7.1: END from the host in the middle of C2; 8 of the base language: RUN clears the return stack."""
    motor = ready(bench)
    running(bench, motor, main_with("WHILE 1\nLOOP\nRETURNI"))
    for count in range(1, 16):
        trigger(bench, motor)
        assert value(bench, motor, "j") == count
        tell(bench, motor, "END RUN" if count % 2 else "RUN", 0)
        samples(bench, 30)


def test_a_thousand_calls_do_not_overflow_the_stack(bench):
    """7.1: "recursive loop overflowing the stack"."""
    motor = ready(bench)
    running(bench, motor, main_with("RETURNI"))
    for _ in range(1000):
        trigger(bench, motor, 4, 6)
    assert value(bench, motor, "j") == 1000
    assert ask(bench, motor, "RBs", 0) == "0"


def test_subroutines_within_subroutines_within_c2(bench):
    """7.1 with GOSUB: the way back is kept in order."""
    program = """
UGI
F=64
WHILE 1
GOSUB10
LOOP
END
C10
PRINT("a")
WAIT=40
PRINT("b")
RETURN
C2
GOSUB11
PRINT("y")
RETURNI
C11
PRINT("x")
RETURN
"""
    motor = ready(bench)
    load(bench, motor, program.strip() + "\n")
    tell(bench, motor, "RUN", 0)
    samples(bench, 20)
    motor.pins["G"].drive(False)
    samples(bench, 60)
    assert motor.serial.read().startswith(b"axyba")


# Which return


@pytest.mark.parametrize("word", ["RETURNF", "RETURNI", "RETURN"])
def test_a_return_with_nothing_to_return_to(bench, word):
    """Neither an interrupt nor a GOSUB: nothing breaks, and the motor still answers."""
    motor = ready(bench)
    running(bench, motor, f"a=1\n{word}\nb=1\nEND\n")
    assert value(bench, motor, "a") == 1
    assert ask(bench, motor, "RP", 0) == "0"
    tell(bench, motor, word)
    assert ask(bench, motor, "RP", 0) == "0"


@pytest.mark.parametrize("word", ["RETURNF", "RETURNI"])
def test_the_host_may_call_a_handler(bench, word):
    """1.2, GOSUBn by a host: the subroutine is run, and the idle motor is idle again."""
    motor = ready(bench)
    number = 1 if word == "RETURNF" else 2
    load(bench, motor, f"END\nC{number}\na=a+1\n{word}\nb=b+1\nEND\n")
    tell(bench, motor, f"GOSUB{number}", 0.01)
    assert value(bench, motor, "a") == 1


def test_an_end_in_c1_ends_the_program(bench):
    """4.1, 7.1."""
    motor = ready(bench)
    motor.pins["C"].drive(False)
    tell(bench, motor, "UCP ZS", 0.01)
    running(bench, motor, "F=32\nWHILE 1\nm=m+1\nLOOP\nEND\nC1\ni=i+1\nEND\n")
    motor.pins["C"].drive(True)
    samples(bench, 30)
    before = value(bench, motor, "m")
    samples(bench, 30)
    assert (value(bench, motor, "i"), value(bench, motor, "m")) == (1, before)


def test_without_a_label_the_motor_keeps_its_wits(bench):
    """F=96 without C1 and C2: no program counter is lost, commands are answered."""
    motor = ready(bench)
    motor.pins["C"].drive(False)
    tell(bench, motor, "UCP ZS", 0.01)
    running(bench, motor, "F=96\nUGI\nWHILE 1\nm=m+1\nLOOP\nEND\n")
    motor.pins["C"].drive(True)
    trigger(bench, motor)
    assert ask(bench, motor, "RBp", 0) == "1"
    motor.pins["C"].drive(False)
    tell(bench, motor, "ZS END m=5 RUN", 0)
    samples(bench, 40)
    assert value(bench, motor, "m") > 5


# UG, UGI, UGO, BRKG


def test_f_64_and_ug_goes_and_calls_c2(bench):
    """7.1, F=64 1: "GOSUB2 triggered with concurrent "Go" on input pin G high to low edge transition"."""
    motor = ready(bench)
    running(bench, motor, main_with("RETURNI").replace("UGI", "UG\nA=65536\nV=65536\nP=100"))
    trigger(bench, motor, 300, 20)
    assert value(bench, motor, "j") == 1
    assert motor.axes["shaft"].position == 100


def test_f_64_and_ugi_only_calls_c2(bench):
    """7.1, F=64 2."""
    motor = ready(bench)
    running(bench, motor, main_with("RETURNI").replace("UGI", "UGI\nA=65536\nV=65536\nP=100"))
    trigger(bench, motor, 300, 20)
    assert value(bench, motor, "j") == 1
    assert motor.axes["shaft"].position == 0


def test_f_64_and_ugo_calls_c2_when_the_latch_goes_low(bench):
    """7.1, F=64 3: "GOSUB2 triggered on UG=0 (when Port G goes from High to Low)"."""
    motor = ready(bench)
    running(bench, motor, main_with("RETURNI").replace("UGI", "UG=1\nUGO"))
    assert value(bench, motor, "j") == 0
    for count in (1, 2, 3):
        tell(bench, motor, "UG=0", 0)
        samples(bench, 20)
        assert value(bench, motor, "j") == count
        tell(bench, motor, "UG=1", 0)
        samples(bench, 20)
        assert value(bench, motor, "j") == count


def test_a_program_triggers_itself(bench):
    """7.1, F=64 3: UG=0 in the program; C2 is called in the WAIT behind it, which it cuts short."""
    motor = ready(bench)
    running(bench, motor, "UG=1\nUGO\nF=64\nWAIT=20\nUG=0\nWAIT=9000\nb=CLK\nEND\nC2\ng=CLK\nRETURNI\n")
    assert 0 < value(bench, motor, "g") < value(bench, motor, "b")


@pytest.mark.parametrize("mode", ["BRKSRV", "BRKTRJ"])
def test_brkg_calls_c2_when_the_brake_is_released(bench, mode):
    """7.1, F=64 3a: "C2 will be called anytime port G goes low due to brake control"; 5.1 note 4."""
    motor = ready(bench)
    running(bench, motor, main_with("RETURNI").replace("UGI", f"UGO\nBRKG\n{mode}\nA=65536\nV=65536\nD=50"))
    assert value(bench, motor, "j") == 0
    for count in (1, 2, 3):
        tell(bench, motor, "G", 0)
        samples(bench, 100)
        assert value(bench, motor, "j") == count
        tell(bench, motor, "OFF", 0)
        samples(bench, 50)
        assert value(bench, motor, "j") == count


def test_a_motor_fault_calls_c1_while_g_is_a_motor_fault_output(bench):
    """5.1 note 3: BRKG with BRKSRV: G rises at the fault; "If F=32 is issued, C1 will also be called"."""
    motor = ready(bench)
    program = "F=32\nUGO\nBRKG\nE=50\nMV\nA=65536\nV=65536\nG\nWHILE 1\nLOOP\nEND\nC1\ni=i+1\nRETURNF\n"
    running(bench, motor, program)
    assert motor.pins["G"].level is False
    motor.axes["shaft"].jam(True)
    samples(bench, 200)
    assert (value(bench, motor, "i"), motor.pins["G"].level) == (1, True)


# Anything at all


ACTS = """
G0 G1 C0 C1 D0 D1 ZS F=96 F=0 F=64 F=32 F=F&191 RUN END STACK RETURNI RETURNF RETURN GOSUB1 GOSUB2 GOTO2 UG UGI UGO
UG=0 UG=1 BRKG BRKI BRKTRJ G OFF UCI UCP Z WAIT=9 F=-1 F=255 F=256 F=2147483647
"""
PROGRAM = """
UGI
F=96
A=65536
V=65536
D=30
WHILE 1
G
WAIT=10
GOSUB5
LOOP
END
C5
m=m+1
RETURN
C1
F=F&191
i=i+1
WAIT=5
ZS
F=96
RETURNF
C2
j=j+1
GOSUB5
RETURNI
"""


def played(acts: list[tuple[str, int]], pieces: int) -> tuple[bytes, int, int]:
    bench = Bench()
    motor = ready(bench)
    motor.pins["C"].drive(False)
    motor.pins["D"].drive(False)
    running(bench, motor, PROGRAM)
    heard = b""
    for act, count in acts:
        if act[1:] in {"0", "1"}:
            motor.pins[act[0]].drive(act[1] == "1")
        else:
            motor.serial.write(act.encode() + b" ")
        for _ in range(pieces):
            bench.clock.run_to(bench.now + count * SAMPLE_NS // pieces)
        heard += motor.serial.read()
    motor.serial.write(b"END RW Ri Rj Rm RP RCLK ")
    bench.run(0.01)
    return heard + motor.serial.read(), motor.axes["shaft"].position, bench.now


@settings(deadline=None, max_examples=60)
@given(acts=st.lists(st.tuples(st.sampled_from(ACTS.split()), st.sampled_from([0, 1, 2, 3, 4, 8, 48])), max_size=30))
def test_any_order_of_edges_faults_and_words_is_survived_and_repeatable(acts):
    """Played twice, and in pieces: the same bytes, the same counts."""
    first = played(acts, 1)
    assert first[0].count(b"\r") == 6
    assert played(acts, 1) == first
    assert played(acts, 32)[:2] == first[:2]
