"""Section 9 of the base language, and chapter 6: reports (R…) and PRINT.

A report is decimal text and one CR, which the motor adds.  PRINT adds nothing.
"""

from functools import lru_cache
from typing import TYPE_CHECKING

from axistwin.controllers.smartmotor.kernel.interpreter import MODE_TOLD, POSITION, STATUS_WORD, computed
from axistwin.controllers.smartmotor.kernel.state import (
    BUFFERED_MODE,
    M_BRAKE,
    M_CAM,
    M_ERROR,
    M_FOLLOW,
    M_HOLD,
    M_HOST,
    M_OFF,
    M_POSITION,
    M_RATIO,
    M_RELATIVE,
    M_STEP,
    M_STEP_RATIO,
    M_STOP,
    M_TORQUE,
    M_VELOCITY,
    PID_RATE,
    RELATIVE,
)
from axistwin.controllers.smartmotor.language.expressions import Expression, Reader

if TYPE_CHECKING:
    from axistwin.controllers.smartmotor.motor import Motor

SAMPLE_PERIOD = 24576
"""In units of 10 ns."""
FIRMWARE = 476

LETTERS = {
    M_OFF: "O",
    M_BRAKE: "B",
    M_ERROR: "E",
    M_POSITION: "P",
    M_RELATIVE: "R",
    M_VELOCITY: "V",
    M_TORQUE: "T",
    M_FOLLOW: "F",
    M_RATIO: "X",
    M_STEP: "S",
    M_STEP_RATIO: "X",
    M_CAM: "C",
    M_HOST: "H",
}


def variable(motor: "Motor", name: str) -> str | None:
    """RP, RV, RW, RBt, RUA …: the value of a variable, in decimal digits, with a minus sign if it is negative."""
    return value(motor, _expression(name).value(motor))


def value(_motor: "Motor", number: int | None) -> str | None:
    """Ra, Raw[exp], RAINpc …: a value that has been worked out already."""
    return None if number is None else str(number)


@lru_cache
def _expression(name: str) -> Expression:
    return Reader(name).expression()


def position_and_status(motor: "Motor") -> str:
    """RPW: `position,word`: the actual position in counts and the status word W."""
    return f"{computed(motor.i, POSITION)},{computed(motor.i, STATUS_WORD)}"


def mode(motor: "Motor") -> str:
    """RMODE: a letter for the mode in force.

    P absolute and R relative position, V velocity, T torque, F and S follow the external encoder or steps, X with a
    ratio, C cam, H host mode, B mode torque brake, O off, E error.  A servo that holds or stops reports the letter of
    what the next G starts.
    """
    i = motor.i
    told = computed(i, MODE_TOLD)
    if told in (M_HOLD, M_STOP):
        told = i[BUFFERED_MODE]
        return LETTERS[M_RELATIVE if told == M_POSITION and i[RELATIVE] else told]
    return LETTERS[told]


def sample_rate(motor: "Motor") -> str:
    """RSP: the period between two updates of the servo in units of 10 ns (PIDn multiplies it), and the firmware."""
    return f"{SAMPLE_PERIOD * motor.i[PID_RATE]}/{FIRMWARE}"


def channel_errors(motor: "Motor", channel: int | None = None) -> str:
    """RCHN, RCHN0, RCHN1 (RCS, RCS1): 1 overflow, 2 framing, 4 syntax, 8 parity; RCHN: of both channels."""
    asked = motor.channels if channel is None else (motor.channels[channel],)
    word = 0
    for one in asked:
        word |= one.status()
    return str(int(word))


def print_(motor: "Motor", *items: str | int | bytes, channel: int | None = None) -> None:
    """PRINT(…), PRINT1(…): texts as they are, values in decimal, `#n` as one character.  Nothing is added at the end.

    PRINT1 speaks to channel 1; while that is not open it is lost.  PRINT of a host speaks to channel 0, whichever it is
    sent on (6.1); that of a program goes to channel 1 with F=4.
    """
    if channel is None and motor.obeys_host:
        channel = 0
    motor.say(b"".join(item if isinstance(item, bytes) else str(item).encode("latin-1") for item in items), channel)


def print_device(_motor: "Motor", *_items: str | int | bytes, **_device: str) -> None:
    """PRINTA(…) to PRINTH(…): to a display on the AniLink bus.  None is there; it is lost."""


LOOKING = (variable, value, position_and_status, mode, sample_rate, channel_errors)
"""Reports that change nothing, but for those of `I`, which clears Bi."""
