"""Control of data transfer, Initialisation: what waits for transmission when the power goes is never sent."""

import pytest

from .talking import ask, command, detect, initialise, ready


@pytest.mark.parametrize("line", ["dtr", "rts"])
@pytest.mark.parametrize("said", ["K\r", ":%:$\r", ">1\r" + "0" * 55])
def test_what_waits_for_dsr_and_cts_is_gone_with_the_power(bench, line, said):
    """Control lines: it "will not transmit data until DSR and CTS are both set"; then its power is off.

    The waiting characters are a reply, the prompt of a sequence, or the X-off of a buffer that is 80 % full.
    """
    if1 = ready(bench, "U67")
    setattr(if1.serial.host, line, False)
    command(bench, if1, said, end="")
    assert if1.serial.rts
    if1.power(False)
    bench.run(0.1)
    setattr(if1.serial.host, line, True)
    bench.run(0.1)
    assert if1.serial.read() == b"" and not if1.serial.rts
    if1.power(True)
    if1.serial.host.bytesize, if1.serial.host.stopbits = 8, 2
    detect(bench, if1)  # U and CR, and nothing before them


def test_an_x_off_that_waits_when_the_power_goes_does_not_come_after_it(bench):
    """Control of data transfer: the buffer is empty after power-up, so a waiting X-off is not sent."""
    if1 = ready(bench, "U67")
    if1.serial.host.rts = False
    command(bench, if1, ">1\r" + "0" * 55, end="")
    if1.power_cycle()
    bench.run(1.2)
    if1.serial.host.rts = True
    bench.run(0.1)
    assert if1.serial.read() == b""
    if1.serial.host.stopbits = 2
    initialise(bench, if1)
    assert ask(bench, if1, "K") == b"0\r"
