"""The two C programs of the manual's appendix D, read from the manual, with the changes that gcc needs.

The listings are read from the manual's text when a test needs them.  Of the two versions of each function, the I/O
mapped one is used.  Comments are left out, because scanning has damaged them.  A table lists all other changes with
their reasons.
"""

import re
from pathlib import Path
from typing import NamedTuple

MANUAL = Path(__file__).parents[3] / "shared" / "seeds" / "000_82164efb254bb5df.txt"

PROGRAMS = {"1810U.C": ("SNDCMD", "RCVCMD", "STAT WAIT"), "FIFO.C": ("I FIFO", "O FIFO")}
"""Functions of each program."""


class Change(NamedTuple):
    """In this function (or in all), replace `found`, which must occur, by `wanted`."""

    function: str
    found: str
    wanted: str
    reason: str


SPACE = "the underscore in a name is printed as a blank"
COLON = "the ; that ends the declaration is printed as :"
BRACE = "the brace that opens the function's body is lost, the one that closes it is there"

CHANGES = (
    *(Change("DEFINES", name, name.replace(" ", "_"), SPACE) for name in (
        "ENB INT", "MSG RED", "MSG RDY", "BFR RDY", "INT MSK",
    )),
    Change("DEFINES", "#define PASS", "#define PASS 0", "the 0 is printed on the line before"),
    Change("SNDCMD", "stat wait", "stat_wait", SPACE),
    Change("SNDCMD", "STAT ADDR", "STAT_ADDR", SPACE),
    Change("SNDCMD", "BFR RDY", "BFR_RDY", SPACE),
    Change("SNDCMD", "cmd arr", "cmd_arr", SPACE),
    Change("SNDCMD", "nbr bytes", "nbr_bytes", SPACE),
    Change("SNDCMD", "nbr_bytes:", "nbr_bytes;", COLON),
    Change("SNDCMD", "  if (stat_wait", "{ if (stat_wait", BRACE),
    Change("RCVCMD", "stat wait", "stat_wait", SPACE),
    Change("RCVCMD", "STAT ADDR", "STAT_ADDR", SPACE),
    Change("RCVCMD", "CTRL ADDR", "CTRL_ADDR", SPACE),
    Change("RCVCMD", "MSG RDY", "MSG_RDY", SPACE),
    Change("RCVCMD", "MSG RED", "MSG_RED", SPACE),
    Change("RCVCMD", "cmd arr", "cmd_arr", SPACE),
    Change("RCVCMD", "nbr bytes", "nbr_bytes", SPACE),
    Change("RCVCMD", "*address:", "*address;", COLON),
    Change("RCVCMD", "  if (stat_wait", "{ if (stat_wait", BRACE),
    Change("STAT WAIT", "stat wait", "stat_wait", SPACE),
    Change("STAT WAIT", "MAX READS", "MAX_READS", SPACE),
    Change("STAT WAIT", "char *address;", "char *address; int mask;", "a declaration is lost; its remark is there"),
    Change("I FIFO", "nbr bytes", "nbr_bytes", SPACE),
    Change("I FIFO", "cmd arr", "cmd_arr", SPACE),
    Change("I FIFO", " while (n", "{ while (n", BRACE),
    Change("O FIFO", "o fifo", "o_fifo", SPACE),
    Change("O FIFO", "nbr bytes", "nbr_bytes", SPACE),
    Change("O FIFO", "cmd arr", "cmd_arr", SPACE),
    Change("O FIFO", " while (n != 0)", "{ while (n != 0) {", BRACE + "; so is the one that opens the loop's"),
    Change("O FIFO", " }\n", " }\n}\n", "the brace that closes the function is lost"),
)  # fmt: skip

FORWARD = "char stat_wait();\n"
"""Declaration added to 1810U.C: without it, a function called before its definition returns an int, not a char."""
COUNT = "-Dn=nbr_bytes"
"""Macro for FIFO.C: its loops count down n, which is not declared; nbr_bytes is meant."""


def programs() -> dict[str, str]:
    """Return the source of each program as in the manual; gcc also needs `FORWARD` and `COUNT`."""
    text = MANUAL.read_text(encoding="utf-8")
    listing = text[text.index("Program #1: 1810U.C") : text.index("ADDENDUM TO 1810/11")]
    found = {name: "\n".join(_function(listing, function) for function in has) for name, has in PROGRAMS.items()}
    defines = "\n".join(re.findall(r"^#define .*$", listing[: listing.index("SNDCMD - ")], re.MULTILINE))
    found["1810U.C"] = "\n".join((_repaired("DEFINES", _bare(defines)), found["1810U.C"]))
    return found


def _function(listing: str, function: str) -> str:
    return _repaired(function, _bare(_section(listing, function)))


def _section(listing: str, function: str) -> str:
    begin = re.search(rf"I/O mapped version, {function}", listing)
    end = re.compile(rf"Memory mapped version, {function}|^/\*{{2,}}", re.MULTILINE).search(listing, begin.end())
    return listing[begin.end() : end.start()]


def _bare(text: str) -> str:
    """Return a listing without comments, page headers and page footers."""
    text = re.sub(r"/\*.*$|\*/|```", "", text, flags=re.MULTILINE)
    return re.sub(r"[ \t]+$\n?", "\n", text, flags=re.MULTILINE)


def _repaired(function: str, text: str) -> str:
    for change in CHANGES:
        if change.function == function:
            assert change.found in text, change
            text = text.replace(change.found, change.wanted)
    return text
