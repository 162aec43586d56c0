"""Reports (R…) and PRINT (section 9 of the base language, and chapter 6).

A report is decimal text and one CR.  PRINT adds no CR.
"""

from axistwin.controllers.smartmotor.chapters.variables import NAMES
from axistwin.controllers.smartmotor.kernel import interpreter as ops
from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.interpreter import computed, evaluate
from axistwin.controllers.smartmotor.processor import Processor

SAMPLE_PERIOD = 24576  # The period that RSP reports, in units of 10 ns.
FIRMWARE = 476

LETTERS = {
    s.M_OFF: "O", s.M_BRAKE: "B", s.M_ERROR: "E", s.M_POSITION: "P", s.M_RELATIVE: "R", s.M_VELOCITY: "V",
    s.M_TORQUE: "T", s.M_FOLLOW: "F", s.M_RATIO: "X", s.M_STEP: "S", s.M_STEP_RATIO: "X", s.M_CAM: "C", s.M_HOST: "H",
}  # fmt: skip


def variable(motor: Processor, name: str) -> str:
    """RP, RV, RW, RBt, RUA …: report the value of a variable as a decimal number."""
    found, stack = NAMES[name], [0]
    evaluate(motor.i, motor.v, stack, (found.operation, found.place, ops.RESULT), 0)
    return str(stack[0])


def value(_motor: Processor, number: int) -> str:
    """Ra, Raw[exp], RAINpc …: the value of the operand."""
    return str(number)


def position_and_status(motor: Processor) -> str:
    """RPW: report the actual position in counts and the status word W."""
    return f"{computed(motor.i, ops.POSITION)},{computed(motor.i, ops.STATUS_WORD)}"


def mode(motor: Processor) -> str:
    """RMODE: report the letter of the present mode.

    P absolute and R relative position, V velocity, T torque, F and S follow the external encoder or steps, X with a
    ratio, C cam, H host mode, B mode torque brake, O off, E error.  A servo that holds or stops reports the mode
    that the next G starts.
    """
    i = motor.i
    reported = computed(i, ops.MODE_REPORTED)
    if reported in (s.M_HOLD, s.M_STOP):
        reported = i[s.BUFFERED_MODE]
        return LETTERS[s.M_RELATIVE if reported == s.M_POSITION and i[s.RELATIVE] else reported]
    return LETTERS[reported]


def sample_rate(motor: Processor) -> str:
    """RSP: the period between two updates of the servo in units of 10 ns (PIDn multiplies it), and the firmware."""
    return f"{SAMPLE_PERIOD * motor.i[s.PID_RATE]}/{FIRMWARE}"


def channel_errors(motor: Processor, channel: int | None = None) -> str:
    """RCHN, RCHN0, RCHN1 (RCS, RCS1): errors, 1 overflow, 2 framing, 4 syntax, 8 parity.  RCHN: of both channels."""
    first, second = (one.status() for one in motor.channels)
    return str(int((first, second)[channel] if channel is not None else first | second))


def print_(motor: Processor, *items: str | int | bytes, channel: int | None = None) -> None:
    """PRINT(…), PRINT1(…): print texts unchanged, values in decimal, `#n` as one character, without a terminator.

    PRINT1 prints on channel 1; the text is lost while the channel is closed.  PRINT of a host prints on channel 0,
    even if the command came on channel 1 (6.1).  PRINT of a program prints on channel 1 with F=4.
    """
    if channel is None and motor.host is not None:
        channel = 0
    motor.send(b"".join(item if isinstance(item, bytes) else str(item).encode("latin-1") for item in items), channel)


def print_device(_motor: Processor, *_items: str | int | bytes, **_device: str) -> None:
    """PRINTA(…) to PRINTH(…): print to a display on the AniLink bus.  No display exists, so the text is lost."""


READ_ONLY = (variable, value, position_and_status, mode, sample_rate, channel_errors)
"""Reports that change nothing, except those of `I`, which clears Bi."""
