"""Rescue: write the contents of a controller into a directory, start a twin from it and ask the same again."""

import json
import shutil
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

from axistwin.bench import Bench, product
from axistwin.core.errors import AxistwinError, LinkError, UsageError
from axistwin.core.storage import write_error
from axistwin.real.hosts.end import End
from axistwin.real.hosts.exchange import Exchange, Report
from axistwin.real.hosts.virtual_time import VirtualEnd
from axistwin.real.probing.rescue.contents import Contents, reader
from axistwin.real.probing.rescue.finding import Found
from axistwin.scenes.scene import Scene
from axistwin.scenes.toml_text import tables

SCENE, TALK, VALUES = "machine.toml", "exchange.talk", "rescue.json"
PORTS = {False: "tcp://127.0.0.1:5001", True: "bus://127.0.0.1:1811"}


@dataclass
class Rescue:
    """The contents of a controller, and the values in which its twin differs."""

    found: Found
    contents: Contents
    files: dict[str, str] = field(default_factory=dict)  # Texts of the written files by name.
    differences: dict[str, tuple[str, str]] = field(default_factory=dict)  # Of controller and twin, by name.

    def as_dict(self) -> dict[str, Any]:
        return {
            "model": self.found.model, "line": None if self.found.line is None else str(self.found.line),
            "values": self.contents.values, "depends on the machine": sorted(self.contents.depends),
            "missing": self.contents.missing, "differences": self.differences,
        }  # fmt: skip


def rescue(end: End, found: Found, out: Path, report: Report = lambda answers, unanswered: None) -> Rescue:
    """Read the programs and data of a controller, and save both in a new directory.

    `end`: the connection to the controller.  `out`: the directory.
    `report` is called after each request, with the number of answers and of the last requests without one.  Raises
    LinkError if the controller does not answer or is moving; what has been received by then is written into the
    directory.
    """
    check_new(out)
    exchange = Exchange(end, found.model, found.line, report)
    family = reader(found.model)
    try:
        contents = family.read(exchange)
    except AxistwinError as error:
        if (file := _saved_talk(exchange, out)) is None:
            raise
        raise LinkError(f"{error}; the data received before this error are in {file}") from None
    done = Rescue(found, contents)
    done.files = _scene(found, contents) | {TALK: exchange.talk()}
    scratch = _scratch(out)
    try:
        _write(scratch, done.files)
        done.differences = contents.differences(_twin(scratch, found, contents))
        done.files[VALUES] = json.dumps(done.as_dict(), indent=1, ensure_ascii=False) + "\n"
        _write(scratch, {VALUES: done.files[VALUES]})
        scratch.rename(out)
    except OSError as error:
        raise write_error(f"cannot write to {out}", error, "choose another directory") from None
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    return done


def check_new(out: Path) -> None:
    """Raise UsageError if the directory exists and is not empty."""
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise UsageError(f"{out} exists already: choose another directory")


def _saved_talk(exchange: Exchange, out: Path) -> Path | None:
    if not exchange.received:
        return None
    try:
        out.mkdir(parents=True, exist_ok=True)
        _write(out, {TALK: exchange.talk()})
    except OSError:
        return None
    return out / TALK


def _scratch(out: Path) -> Path:
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        return Path(mkdtemp(prefix=f".{out.name}-", dir=out.parent))
    except OSError as error:
        raise write_error(f"cannot write to {out}", error, "choose another directory") from None


def _write(directory: Path, files: dict[str, str]) -> None:
    for name, text in files.items():
        (directory / name).write_text(text, encoding="utf-8", newline="\n")


def _scene(found: Found, contents: Contents) -> dict[str, str]:
    made = product(found.model)
    restoring = reader(found.model).restore(contents, new(found.model))
    controller: dict[str, Any] = {"model": found.model, "ports": [PORTS[made.line is None]]}
    if found.line not in (made.line, None) and made.model != "smartmotor":
        controller["line"] = str(found.line)
    data: dict[str, Any] = {"title": f"Rescued {made.model}", "controller": [controller | restoring.controller]}
    if restoring.actions:
        data["script"] = [{"at": 0, "do": restoring.actions}]
    notes = "".join(f"# Not read: {line}.\n" for line in contents.missing)
    return {SCENE: notes + tables(data)} | restoring.files


@cache
def new(model: str) -> Contents:
    bench = Bench()
    end = VirtualEnd(bench, bench.add(model))
    family = reader(model)
    family.start(bench, Contents({"format": "U61"}))
    return family.read(Exchange(end, model))


def _twin(directory: Path, found: Found, contents: Contents) -> Contents:
    bench = Scene.load(directory / SCENE).build()
    (controller,) = bench.controllers.values()
    end = VirtualEnd(bench, controller)
    family = reader(found.model)
    family.start(bench, contents)
    try:
        return family.read(Exchange(end, found.model, controller.serial.host.format if end.has_line else None))
    finally:
        end.close()
