"""Parse the format of a serial line, e.g. `9600 8N2`."""

import re
from dataclasses import replace
from typing import Any

from axistwin.core.errors import UsageError
from axistwin.core.numbers import shortened, whole
from axistwin.sim.frames import UartFormat

LINE = re.compile(
    r"(?P<baudrate>[1-9]\d{0,8})? ?(?P<frame>(?P<bits>[5-8])(?P<parity>[NEOMSneoms])(?P<stop>1|1\.5|2))?", re.ASCII
)


def line_format(text: str | UartFormat | None, usual: UartFormat) -> tuple[UartFormat, bool]:
    """Parse "9600 8N2".  Return the format, and True if the text contains "instant": characters take no time."""
    if text is None or isinstance(text, UartFormat):
        return text or usual, False
    if not isinstance(text, str):
        raise UsageError(f"invalid baud rate or character format {text!r}: expected e.g. '9600 8N2', or 'instant'")
    words = text.replace(",", " ").split()
    instant = "instant" in words
    match = LINE.fullmatch(" ".join(word for word in words if word != "instant"))
    if match is None:
        raise UsageError(
            f"invalid baud rate or character format {shortened(text)}: expected e.g. '9600 8N2', or 'instant'"
        )
    baudrate = usual.baudrate if match["baudrate"] is None else whole(match["baudrate"])
    if match["frame"] is None:
        return replace(usual, baudrate=baudrate), instant
    parity: Any = match["parity"].upper()
    return UartFormat(baudrate, int(match["bits"]), parity, float(match["stop"])), instant
