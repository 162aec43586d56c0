"""Section 6 of the base language: variables kept without power, in the data EEPROM of 8000 bytes.

EPTR points to a byte.  VST and VLD advance EPTR for each value: by 1 byte for ab[], 2 bytes for aw[], 4 bytes for all
others.  The most significant byte comes first.
"""

from collections.abc import Callable
from typing import NamedTuple

from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.interpreter import BYTE, LONG, VARIABLE, WORD, element, set_element
from axistwin.controllers.smartmotor.processor import Processor

BYTES = {BYTE: 1, WORD: 2, LONG: 4, VARIABLE: 4}
WRITE_SAMPLES = 21  # A VST in a program takes the 5 ms of an EEPROM's write cycle.


class Run(NamedTuple):
    """A range of variables or array elements: kind, first index, and number of elements to the end of the group."""

    kind: int
    first: int
    left: int


FindRun = Callable[[Processor], Run | None]  # Returns the range of the first operand of a VST or VLD, or None.


def pointer(motor: Processor, value: int) -> None:
    """EPTR=exp: set the EEPROM address (0 to 7999) of the next VST or VLD.  Any other value sets Bs."""
    if 0 <= value < motor.options.data_bytes:
        motor.i[s.EPTR] = value
    else:
        motor.syntax_error(f"{value} is out of range: expected 0 to {motor.options.data_bytes - 1}")


def store_variables(motor: Processor, find: FindRun, count: int) -> None:
    """VST(variable,n): store n variables in the EEPROM, beginning with the named variable.

    The groups are a…z, aa…zz, aaa…zzz and each array.  If the values exceed the group or the EEPROM, Bs is set, nothing
    is stored and EPTR does not change.
    """
    run = _checked(motor, find(motor), count)
    if run is None:
        return
    size = BYTES[run.kind]
    data = b"".join(_get(motor, run.kind, run.first + n).to_bytes(size, "big", signed=True) for n in range(count))
    if motor.nonvolatile.write(motor.i[s.EPTR], data):
        motor.nonvolatile.save(motor.store)
    motor.i[s.EPTR] += len(data)
    motor.i[s.WAIT_UNTIL] = max(motor.i[s.WAIT_UNTIL], motor.i[s.SAMPLE] + 1 + WRITE_SAMPLES)


def load_variables(motor: Processor, find: FindRun, count: int) -> None:
    """VLD(variable,n): load n variables from the EEPROM, beginning with the named variable.

    The limits are those of VST; erased bytes are -1.
    """
    run = _checked(motor, find(motor), count)
    if run is None:
        return
    size = BYTES[run.kind]
    data = motor.nonvolatile.read(motor.i[s.EPTR], count * size)
    for n in range(count):
        value = int.from_bytes(data[n * size : (n + 1) * size], "big", signed=True)
        _set(motor, run.kind, run.first + n, value)
    motor.i[s.EPTR] += len(data)


def _checked(motor: Processor, run: Run | None, count: int) -> Run | None:
    """Return the run, or set Bs and return None if the run or the EEPROM is too small for the values."""
    if run and 0 < count <= run.left and motor.i[s.EPTR] + count * BYTES[run.kind] <= motor.options.data_bytes:
        return run
    motor.syntax_error("so many values do not fit: choose fewer values, or a lower EPTR")
    return None


def _get(motor: Processor, kind: int, place: int) -> int:
    return motor.v[place] if kind == VARIABLE else element(motor.i, motor.v, kind, place)


def _set(motor: Processor, kind: int, place: int, value: int) -> None:
    if kind == VARIABLE:
        motor.v[place] = value
    else:
        set_element(motor.i, motor.v, kind, place, value)
