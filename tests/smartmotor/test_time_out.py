"""The time-out of OCHN (2 of the base language): what it drops, and what tells of it."""

from .talking import send


def test_a_command_that_comes_too_late_is_a_scan_error(bench, motor):
    """OCHN's last parameter; RCHN: "4 scan/syntax".  Half a command is dropped and Bs is set; Zs clears both."""
    send(bench, motor, "OCHN(RS2,0,N,9600,1,8,C,100) ZS", 0)
    assert send(bench, motor, "RBs RCHN", 0) == b"0\r0\r"
    send(bench, motor, "a=", 0)
    bench.run(2.0)
    assert send(bench, motor, "RBs RCHN", 0) == b"1\r4\r"
    assert send(bench, motor, "Zs RBs RCHN", 0) == b"0\r0\r"
