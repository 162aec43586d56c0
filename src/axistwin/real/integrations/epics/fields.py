"""Fields of a motor record: type, value at the start, and the check of written values."""

from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from typing import Any

from axistwin.drivers.errors import RefusedError


class Kind(Enum):
    """Data type of a field in an EPICS record, e.g. `MENU`."""

    DOUBLE = "double"
    LONG = "long"
    MENU = "menu"
    STRING = "string"
    TEXT = "text"  # A string of up to 256 characters.


@dataclass(frozen=True)
class Field:
    """A field of an EPICS record."""

    kind: Kind
    value: Any
    menu: tuple[str, ...] = ()  # Choices of a menu.
    scaled: bool = False  # True if the value has the record's unit, precision and limits.
    most: int = 1  # Largest value of an integer field that clients can write; the smallest is 0.


def _doubles(names: str, value: float = 0.0, *, scaled: bool = True) -> dict[str, Field]:
    return {name: Field(Kind.DOUBLE, value, scaled=scaled) for name in names.split()}


def _longs(names: str, value: int = 0) -> dict[str, Field]:
    return {name: Field(Kind.LONG, value) for name in names.split()}


def _menu(*choices: str, value: int = 0) -> Field:
    return Field(Kind.MENU, value, choices)


def _strings(names: str) -> dict[str, Field]:
    return {name: Field(Kind.STRING, "") for name in names.split()}


NO_YES = ("No", "Yes")
SEVERITIES = ("NO_ALARM", "MINOR", "MAJOR", "INVALID")
STOP, PAUSE, MOVE, GO = range(4)  # Choices of SPMG.
MOST_DECIMALS = 6
MOST = 1e15  # No number of a motor record reaches this value.
LONGEST_TEXT = 39

MOTOR: dict[str, Field] = {
    **_doubles("VAL RBV DVAL DRBV RLV DIFF OFF HLM LLM DHLM DLLM"), **_doubles("RVAL RRBV RDIF", scaled=False),
    **_doubles("VELO VBAS VMAX JVEL JAR HVEL BVEL TWV RDBD SPDB BDST"),
    **_doubles("ACCL BACC DLY S SBAS SMAX VERS", scaled=False),
    **_doubles("MRES ERES RRES UREV FRAC", 1.0, scaled=False), **_longs("DMOV SREV", 1),
    **_longs("MOVN STOP JOGF JOGR HOMF HOMR TWF TWR SYNC HLS LLS RHLS RLLS LVIO MSTA TDIR CDIR ATHM MISS RCNT RTRY"),
    **_longs("CARD UDF PROC"), "PREC": Field(Kind.LONG, 0, most=15),
    "SPMG": _menu("Stop", "Pause", "Move", "Go", value=GO), "DIR": _menu("Pos", "Neg"), "SET": _menu("Use", "Set"),
    "FOFF": _menu("Variable", "Frozen"), "UEIP": _menu(*NO_YES), "URIP": _menu(*NO_YES),
    "STUP": _menu("OFF", "ON", "BUSY"), "CNEN": _menu("Disable", "Enable", value=1), "SEVR": _menu(*SEVERITIES),
    **_strings("EGU DESC NAME RTYP DTYP OUT STAT"), "FAULT": Field(Kind.TEXT, ""), "CLEAR": Field(Kind.LONG, 0),
}  # fmt: skip
"""Fields of a motor record, with the names of EPICS' motor module."""
OWN = ("FAULT", "CLEAR")  # Not in EPICS' motor record: served as records of their own, `LAB:if1:X:FAULT`.


def called(record: str, field: str) -> str:
    """Return the EPICS channel name of a field, e.g. `LAB:if1:X.VAL`."""
    return f"{record}:{field}" if field in OWN else f"{record}.{field}"


def decimals(per: Fraction) -> int:
    """Return the decimals that one count needs, at most 6."""
    return next((n for n in range(MOST_DECIMALS) if (10**n / per).denominator == 1), MOST_DECIMALS)


def checked(field: str, value: Any) -> Any:
    """Convert a client's value, e.g. "1.5", or a menu's choice to its number.  Raises RefusedError."""
    found = MOTOR[field]
    try:
        match found.kind:
            case Kind.DOUBLE:
                value = float(value)
                if not abs(value) < MOST:
                    raise RefusedError(f"{field} cannot be {value}: expected a number below {MOST:g}")
            case Kind.LONG:
                if not 0 <= float(value) <= found.most or float(value) != int(float(value)):
                    raise RefusedError(f"{field} cannot be {value}: expected an integer from 0 to {found.most}")
                value = int(float(value))
            case Kind.MENU:
                value = found.menu.index(value) if isinstance(value, str) else int(value)
                if not 0 <= value < len(found.menu):
                    raise RefusedError(f"invalid value {value} for {field}: expected one of {', '.join(found.menu)}")
            case _:
                value = str(value)
                if len(value) > LONGEST_TEXT:
                    raise RefusedError(f"{field} cannot hold {len(value)} characters: expected at most {LONGEST_TEXT}")
    except (ValueError, TypeError):
        expected = ", ".join(found.menu) or f"a {found.kind.value}"
        raise RefusedError(f"invalid value {value!r} for {field}: expected {expected}") from None
    return value
