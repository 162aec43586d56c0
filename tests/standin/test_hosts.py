"""Legacy hosts drive the stand-in through a pseudo terminal: `benchmarks/robustness/stand_in_hosts.py` in small."""

import sys
from time import monotonic

import pytest
import serial

from axistwin.real.standin.wiring import AxisPins, BoardPin

from ..basic.hosting import perform
from ..basic.listings import MANUAL
from ..links.serving import HOST_TIMEOUT_S, Served
from .metal import X, Y
from .served_board import ServedBoard

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="needs a pseudo terminal")

Y_UPRIGHT = AxisPins(Y.axis, Y.step, BoardPin("P6"), Y.enable)
SPEED = 20
PINS = {"X": 2, "Y": 5}


@pytest.mark.skipif(not MANUAL.exists(), reason="the manual is not here")
def test_a_basic_program_of_the_manual_moves_the_motors(tmp_path):
    """Sample program 7: X forth, Y forth, X back and Y back."""
    boards = []
    session = perform(
        7, "U61", tmp_path, link="pty", line="2400 8N2", name="table",
        prepare=lambda bench: boards.append(ServedBoard(bench, (X, Y_UPRIGHT))),
    )  # fmt: skip
    session.bench.run(2.5)
    [board] = boards
    assert board.lines == [] and board.moves(PINS) == [{"X": 1000}, {"Y": 1000}, {"X": -1000}, {"Y": -1000}]
    assert board.moves(PINS) == session.moves() and not [word for word in ("rror", "imeout") if word in session.screen]


def test_a_host_with_pyserial_moves_the_motors(tmp_path):
    link = tmp_path / "host"
    with Served(speed=SPEED) as served:
        if1 = served.add(name="table", line="instant")
        board = served.do(lambda: ServedBoard(served.bench, (X, Y_UPRIGHT)))
        served.open(if1, f"pty:{link}")
        with serial.Serial(str(link), 9600, timeout=HOST_TIMEOUT_S) as host:
            for message in (b"X-Y+300 @ 1000 $ \r", b"X+40 $ \r"):
                host.write(message)
                answer = b""
                while answer != b"C\r":
                    host.write(b"E\r")
                    answer = host.read_until(b"\r")
                    assert answer in (b"E\r", b"C\r")  # executing, or complete
        made, ends_s = [], monotonic() + HOST_TIMEOUT_S
        while len(made) < 2 or made[-1].get("X", 0) < 40:
            assert monotonic() < ends_s, made
            made = served.do(lambda: board.moves(PINS))
    assert made == [{"X": -300, "Y": 300}, {"X": 40}] and board.lines == []
