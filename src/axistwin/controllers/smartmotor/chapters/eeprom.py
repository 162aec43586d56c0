"""Section 6 of the base language: variables kept without power, in the data EEPROM of 8000 bytes.

EPTR points to a byte.  VST and VLD move it on by 1, 2 or 4 bytes for each value (ab[], aw[], everything else), the most
significant byte first.
"""

from typing import TYPE_CHECKING, NamedTuple

from axistwin.controllers.smartmotor.chapters.variables import ARRAY_SIZES, values
from axistwin.controllers.smartmotor.kernel.interpreter import BYTE, LONG, VARIABLE, WORD, element, set_element
from axistwin.controllers.smartmotor.kernel.state import EPTR, SAMPLE, WAIT_UNTIL
from axistwin.controllers.smartmotor.language.expressions import Malformed, Reader

if TYPE_CHECKING:
    from axistwin.controllers.smartmotor.motor import Motor

BYTES = {BYTE: 1, WORD: 2, LONG: 4, VARIABLE: 4}
WRITE_SAMPLES = 21
"""A VST in a program takes the 5 ms of an EEPROM's write cycle."""


class Run(NamedTuple):
    """Consecutive variables or elements: what they are, the first one, how many there are to the end of its group."""

    kind: int
    first: int
    left: int


def pointer(motor: "Motor", value: int) -> None:
    """EPTR=exp: the byte that the next VST or VLD begins with, 0 to 7999; anything else sets Bs."""
    if 0 <= value < motor.options.data_bytes:
        motor.i[EPTR] = value
    else:
        motor.syntax_error()


def store_variables(motor: "Motor", name: str, count: int) -> None:
    """VST(variable,n): store n variables from this one on.  They do not go beyond their group: a…z, aa…zz, aaa…zzz,
    one array; nor beyond the end of the EEPROM.  Otherwise Bs is set, nothing is stored and EPTR stays.
    """
    run = _run(motor, name, count)
    if run is None:
        motor.syntax_error()
        return
    size = BYTES[run.kind]
    data = b"".join(_get(motor, run.kind, run.first + n).to_bytes(size, "big", signed=True) for n in range(count))
    if motor.nonvolatile.write(motor.i[EPTR], data):
        motor.nonvolatile.save(motor.store)
    motor.i[EPTR] += len(data)
    motor.i[WAIT_UNTIL] = max(motor.i[WAIT_UNTIL], motor.i[SAMPLE] + 1 + WRITE_SAMPLES)


def load_variables(motor: "Motor", name: str, count: int) -> None:
    """VLD(variable,n): load n variables from this one on; the limits are those of VST.  Erased bytes are -1."""
    run = _run(motor, name, count)
    if run is None:
        motor.syntax_error()
        return
    size = BYTES[run.kind]
    data = motor.nonvolatile.read(motor.i[EPTR], count * size)
    for n in range(count):
        value = int.from_bytes(data[n * size : (n + 1) * size], "big", signed=True)
        _set(motor, run.kind, run.first + n, value)
    motor.i[EPTR] += len(data)


def _run(motor: "Motor", name: str, count: int) -> Run | None:
    """`count` variables or elements from `name` on, if there are as many and the EEPROM has room from EPTR on."""
    run = _array(motor, name) if "[" in name else _named(name)
    if run is None or not 0 < count <= run.left:
        return None
    return run if motor.i[EPTR] + count * BYTES[run.kind] <= motor.options.data_bytes else None


def _named(name: str) -> Run | None:
    group = values(name)
    return None if group is None else Run(VARIABLE, group.start, len(group))


def _array(motor: "Motor", name: str) -> Run | None:
    kind, length = ARRAY_SIZES.get(name[:2], (0, 0))
    reader = Reader(name, 2)
    try:
        index = reader.index()
    except Malformed:
        return None
    first = index.value(motor) if reader.at == len(name) else None
    return None if first is None or not 0 <= first < length else Run(kind, first, length - first)


def _get(motor: "Motor", kind: int, place: int) -> int:
    return motor.v[place] if kind == VARIABLE else element(motor.i, motor.v, kind, place)


def _set(motor: "Motor", kind: int, place: int, value: int) -> None:
    if kind == VARIABLE:
        motor.v[place] = value
    else:
        set_element(motor.i, motor.v, kind, place, value)
