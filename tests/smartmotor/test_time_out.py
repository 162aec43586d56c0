"""The time-out of OCHN (2 of the base language): what it drops, and what tells of it."""

from .cam import say
from .talking import ready


def test_a_command_that_comes_too_late_is_a_scan_error(bench):
    """OCHN's last parameter; RCHN: "4 scan/syntax".  Half a command is dropped and Bs is set; Zs clears both."""
    motor = ready(bench)
    say(bench, motor, "OCHN(RS2,0,N,9600,1,8,C,100) ZS ")
    assert say(bench, motor, "RBs RCHN ") == b"0\r0\r"
    say(bench, motor, "a=")
    bench.run(2.0)
    assert say(bench, motor, "RBs RCHN ") == b"1\r4\r"
    assert say(bench, motor, "Zs RBs RCHN ") == b"0\r0\r"
