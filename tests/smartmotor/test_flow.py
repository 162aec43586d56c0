"""Program flow with a host: RUN, END, GOSUB, interrupts (8 of the base language; 4.1 and 7.0 of the manual)."""

from .scripts import play, scripts
from .talking import ask, load, ready, send


def motor_with(bench, program):
    """Return a motor without faults with this program, not started."""
    motor = ready(bench)
    load(bench, motor, program)
    return motor


@scripts({
    "RUN without a program does nothing; GOSUB5 sets Bs, because there is no label C5":
    "RUN GOSUB5; 0.01 s; RBs -> 1",
    "run starts the program from the top and keeps the variables":
    "load a=a+1 END; a=5 RUN; 0.01 s; RUN; 0.01 s; Ra -> 7",
    "The subroutine ends at its RETURN; its label is found without a running program":
    'load END C4 PRINT("g=",g,#13) RETURN a=1; g=-1 GOSUB4 -> g=-1 in 0.01 s; Ra -> 0',
    "a subroutine called by a host while the program runs":
    "load WHILE 1 a=a+1 LOOP C4 b=b+1 RETURN; RUN; 0.01 s; GOSUB4 GOSUB4; 0.01 s; Rb -> 2; keep a; 0.01 s; "
    "a grew",
    "goto from a host starts there":
    "load a=1 END C9 b=1 END; GOTO9; 0.01 s; Ra -> 0; Rb -> 1",
    "run wait stops a program that power up has started":
    "load a=1 RUN? b=1 END; power cycle; 0.5 s; Ra -> 1; Rb -> 0; RUN; 0.01 s; Rb -> 1",
    "a pause ends with a serial character":
    "load a=1 ! a=2 END; RUN; 0.1 s; 0.1 s; Ra -> 1; 0.001 s; Ra -> 2 in 0.01 s",
    "total reset":
    "load END; a=5 F=33 Z; 0.5 s; Ra -> 0",
    "WAIT=4069 is one second of samples of 245.76 µs":
    'load WAIT=4069 PRINT("x") END; RUN; 0.99 s; receives nothing; 0.02 s; receives x',
    "a host does not cut wait short":
    "load WAIT=4069 b=1 END C4 a=1 RETURN; RUN; 0.1 s; GOSUB4; 0.1 s; Ra -> 0; Rb -> 0; 1.0 s; Ra -> 1; Rb -> 1",
})  # fmt: skip
def test_flow(script):
    play(script)


def test_end_stops_the_program_and_forgets_its_returns(bench):
    motor = motor_with(bench, "GOSUB5 b=1 END C5 WHILE 1 a=a+1 LOOP")
    send(bench, motor, "RUN", 0.01)
    send(bench, motor, "END RETURN", 0.01)
    first = ask(bench, motor, "Ra", 0.01)
    assert (first != "0", ask(bench, motor, "Ra", 0.01)) == (True, first)
    assert (ask(bench, motor, "Rb"), ask(bench, motor, "RBs")) == ("0", "1")
