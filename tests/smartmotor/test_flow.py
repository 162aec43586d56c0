"""Program flow with a host: RUN, END, GOSUB, interrupts (8 of the base language; 4.1 and 7.0 of the manual)."""

from .playing import play, scripts
from .talking import ask, load, ready, send


def motor_with(bench, program):
    """Return a motor without faults with this program, not started."""
    motor = ready(bench)
    load(bench, motor, program)
    return motor


@scripts(
    {
        "RUN without a program does nothing; GOSUB5 sets Bs, because there is no label C5":
        "RUN GOSUB5; 0.01 s; RBs -> 1",
    }
)  # fmt: skip
def test_flow(script):
    play(script)


def test_run_starts_the_program_from_the_top_and_keeps_the_variables(bench):
    motor = motor_with(bench, "a=a+1 END")
    send(bench, motor, "a=5 RUN", 0.01)
    send(bench, motor, "RUN", 0.01)
    assert ask(bench, motor, "Ra") == "7"


def test_end_stops_the_program_and_forgets_its_returns(bench):
    motor = motor_with(bench, "GOSUB5 b=1 END C5 WHILE 1 a=a+1 LOOP")
    send(bench, motor, "RUN", 0.01)
    send(bench, motor, "END RETURN", 0.01)
    first = ask(bench, motor, "Ra", 0.01)
    assert (first != "0", ask(bench, motor, "Ra", 0.01)) == (True, first)
    assert (ask(bench, motor, "Rb"), ask(bench, motor, "RBs")) == ("0", "1")


def test_a_subroutine_called_by_a_host_while_no_program_runs(bench):
    """The subroutine ends at its RETURN; its label is found without a running program."""
    motor = motor_with(bench, 'END C4 PRINT("g=",g,#13) RETURN a=1')
    assert send(bench, motor, "g=-1 GOSUB4", 0.01) == b"g=-1\r"
    assert ask(bench, motor, "Ra") == "0"


def test_a_subroutine_called_by_a_host_while_the_program_runs(bench):
    motor = motor_with(bench, "WHILE 1 a=a+1 LOOP C4 b=b+1 RETURN")
    send(bench, motor, "RUN", 0.01)
    send(bench, motor, "GOSUB4 GOSUB4", 0.01)
    assert ask(bench, motor, "Rb") == "2"
    before = int(ask(bench, motor, "Ra", 0.01))
    assert int(ask(bench, motor, "Ra")) > before


def test_goto_from_a_host_starts_there(bench):
    motor = motor_with(bench, "a=1 END C9 b=1 END")
    send(bench, motor, "GOTO9", 0.01)
    assert (ask(bench, motor, "Ra"), ask(bench, motor, "Rb")) == ("0", "1")


def test_run_wait_stops_a_program_that_power_up_has_started(bench):
    motor = motor_with(bench, "a=1 RUN? b=1 END")
    motor.power_cycle()
    bench.run(0.5)
    assert (ask(bench, motor, "Ra"), ask(bench, motor, "Rb")) == ("1", "0")
    send(bench, motor, "RUN", 0.01)
    assert ask(bench, motor, "Rb") == "1"


def test_a_pause_ends_with_a_serial_character(bench):
    motor = motor_with(bench, "a=1 ! a=2 END")
    send(bench, motor, "RUN", 0.1)
    bench.run(0.1)
    assert ask(bench, motor, "Ra") == "1"  # the report did not stop the program
    assert ask(bench, motor, "Ra", 0.01) == "2"


def test_total_reset(bench):
    motor = motor_with(bench, "END")
    send(bench, motor, "a=5 F=33 Z", 0.5)
    assert ask(bench, motor, "Ra") == "0"


def test_wait_takes_its_samples_to_the_nanosecond(bench):
    """WAIT=4069 is one second of samples of 245.76 µs."""
    motor = motor_with(bench, 'WAIT=4069 PRINT("x") END')
    send(bench, motor, b"RUN ", 0.99)
    assert motor.serial.read() == b""
    bench.run(0.02)
    assert motor.serial.read() == b"x"


def test_a_host_does_not_cut_wait_short(bench):
    motor = motor_with(bench, "WAIT=4069 b=1 END C4 a=1 RETURN")
    send(bench, motor, "RUN", 0.1)
    send(bench, motor, "GOSUB4", 0.1)
    assert (ask(bench, motor, "Ra"), ask(bench, motor, "Rb")) == ("0", "0")
    bench.run(1.0)
    assert (ask(bench, motor, "Ra"), ask(bench, motor, "Rb")) == ("1", "1")
