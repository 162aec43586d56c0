"""The names of all models and where their code is, without importing it: ours, installed ones, and loaded files."""

import os
import re
import sys
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import NamedTuple

from axistwin.core.errors import UsageError

OURS = {
    "if1": "axistwin.controllers.digiplan.card:IF1",
    "if2": "axistwin.controllers.digiplan.card:IF2",
    "1810": "axistwin.controllers.compumotor.card:BOARD_1810",
    "1811": "axistwin.controllers.compumotor.card:BOARD_1811",
    "smartmotor": "axistwin.controllers.smartmotor.card:SMARTMOTOR",
}
"""Our models, in the notation of entry points.  A table, because the look at installed packages takes its time."""
GROUP = "axistwin.devices"  # Group of the entry points of other packages.
NAME = re.compile(r"[a-z0-9][a-z0-9_-]*")  # A model's name, which scenes and command lines contain.


class Place(NamedTuple):
    """The object of a model as `module:name`, and for messages where it comes from: a package, or a line of a file."""

    object: str
    where: str


LOADED: dict[str, Place] = {}
"""Models of the files that `axistwin.devices.load` has loaded in this process, by name."""
FILES: dict[str, tuple[str, str]] = {}
"""Path and text of each of these files, by the name of its module."""


def texts_of(models: Iterable[str]) -> dict[str, str]:
    """Return the texts of the loaded files with these models, by path, to load them in another process."""
    found = (LOADED[name.lower()].object.partition(":")[0] for name in models if name.lower() in LOADED)
    return dict(FILES[module] for module in sorted(set(found)))


def places(name: str) -> tuple[Place, ...]:
    """Return the places of a model: none for an unknown name, several if two packages use the same name."""
    name = name.lower()
    if name in OURS:
        return (Place(OURS[name], "axistwin"),)
    if not NAME.fullmatch(name):
        return ()  # The name of a file or a port: no look at the installed packages.
    return (*([LOADED[name]] if name in LOADED else ()), *installed().get(name, ()))


def names() -> tuple[str, ...]:
    return tuple(dict.fromkeys((*OURS, *LOADED, *sorted(installed()))))


@cache
def installed() -> dict[str, tuple[Place, ...]]:
    """Return the models of installed packages; ours keep their names.

    The files are read here, because `importlib.metadata` takes ten times as long.
    """
    found: dict[str, tuple[Place, ...]] = {}
    for package, text in _entry_points().items():
        for name, place in _devices(text):
            if NAME.fullmatch(name) and name not in OURS:
                found[name] = (*found.get(name, ()), Place(place, f"{place} of {package}"))
    return found


def _entry_points() -> dict[str, str]:
    """Return the texts of the entry points by package, e.g. "my_stage 1.0"; the first one on the path counts."""
    found: dict[str, str] = {}
    seen = set()
    for folder in sys.path:
        with suppress(OSError):  # Not a folder: a zip file, or a path that does not exist.
            for name in sorted(os.listdir(folder or ".")):
                package, dot, kind = name.rpartition(".")
                if kind not in ("dist-info", "egg-info") or not dot or package.partition("-")[0].lower() in seen:
                    continue
                seen.add(package.partition("-")[0].lower())
                with suppress(OSError, UnicodeDecodeError):  # Most packages have no entry points.
                    text = Path(folder, name, "entry_points.txt").read_text(encoding="utf-8")
                    if GROUP in text:
                        found[" ".join(package.split("-")[:2])] = text
    return found


def _devices(text: str) -> Iterator[tuple[str, str]]:
    section = ""
    for line in map(str.strip, text.splitlines()):
        if line.startswith("["):
            section = line.strip("[] ")
        elif section == GROUP and not line.startswith(("#", ";")):
            name, _, place = line.partition("=")
            if place:
                yield name.strip().lower(), place.partition("[")[0].strip()


def check_name(model: str, what: str) -> None:
    """Raise UsageError if the name of a model cannot be written in scenes and command lines, or is one of ours."""
    if not NAME.fullmatch(model):
        raise UsageError(f"{what} has the model {model!r}: expected lower-case letters, digits, - and _, e.g. 'stage'")
    if model in OURS:
        raise UsageError(f"{what} has the model {model!r}, which is a model of axistwin ({OURS[model]}): rename it")
