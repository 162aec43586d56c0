"""Language support for conversations: data of the host, pins and axes, and their values."""

import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from functools import cache, partial
from typing import Any

from axistwin.bench import Bench, product
from axistwin.bench.actions import LEVELS, subjects, targets
from axistwin.bench.codec import codec_of
from axistwin.bench.models import models
from axistwin.bench.talk.conversation import named_model
from axistwin.controllers.diagnostics import Session
from axistwin.controllers.product import Product
from axistwin.core.errors import UsageError, with_article
from axistwin.scenes.diagnostics.checking import read_acts, sessions
from axistwin.ui.editor import compumotor, digiplan, smartmotor
from axistwin.ui.editor.answers import Hover, Item, Symbol, explain, item

_LINE = re.compile(r"(?P<before>\s*(?:(?P<name>[\w.-]+):\s+)?(?P<mark>[;+><!=])\s*)(?P<rest>.*)", re.DOTALL)
_ESCAPE = re.compile(r"\\(?:x[0-9A-Fa-f]{2}|.?)")
_END = re.compile(r"\\[rn]|\\x0[aAdD]")
MARKS = {
    ">": "the host transmits", "<": "the controller transmits", "+": "time passes, in seconds",
    "!": "an action at the machine", "=": "an assertion", ";": "a comment",
}  # fmt: skip


class Conversations:
    """Language support for conversations (`.talk` files)."""

    def hover(self, lines: list[str], line: int, at: int) -> Hover | None:
        found = _LINE.match(lines[line - 1])
        if found is None:
            return None
        begin = len(found["before"])
        if at < begin:
            return Hover(f"**{found['mark']}** {MARKS[found['mark']]}", found.start("mark"), found.end("mark"))
        made = _product(lines)
        if made is None or found["mark"] not in "><":
            return _terminal(made, found["rest"], at - begin, begin) if found["mark"] in "!=" else None
        return _data_hover(made, found["rest"], at - begin, begin) if found["mark"] == ">" else None

    def complete(self, lines: list[str], line: int, at: int) -> list[Item]:
        text = lines[line - 1][:at]
        found = _LINE.match(text)
        if found is None:
            return [Item(mark, "value", meaning) for mark, meaning in MARKS.items()] if not text.strip() else []
        made = _product(lines)
        if found["mark"] == ";":
            return _headers(found["rest"])
        if made is None:
            return []
        match found["mark"]:
            case ">":
                return _data_completions(made, found["rest"], partial(_session, lines[: line - 1], made, found["name"]))
            case "!" | "=":
                return _acts(made.model, found["mark"], found["rest"])
        return []

    def symbols(self, lines: list[str]) -> list[Symbol]:
        made = _product(lines)
        if made is None or made.family != "digiplan":
            return []
        return [symbol for number, line in enumerate(lines, 1) for symbol in _sequences(line, number)]


def _product(lines: list[str]) -> Product | None:
    return known(named_model(lines))


def known(model: str) -> Product | None:
    """Return a model by its name; None if there is none, or if the package that has it cannot be imported."""
    with suppress(UsageError):
        return product(model)
    return None


def _masked(text: str) -> str:
    return _ESCAPE.sub(lambda found: " " * len(found[0]), text)


def _pieces(text: str) -> Iterator[tuple[int, str]]:
    begin = 0
    for end in _END.finditer(text):
        yield begin, _masked(text[begin : end.start()])
        begin = end.end()
    yield begin, _masked(text[begin:])


def _data_hover(made: Product, text: str, at: int, offset: int) -> Hover | None:
    if made.family == "compumotor":
        return compumotor.Commands(made).hover_at(text.partition(";")[0], at, offset)
    begin, piece = next((b, p) for b, p in reversed(list(_pieces(text))) if b <= at)
    if made.family == "digiplan":
        return digiplan.hover(piece, at - begin, offset + begin)
    if made.family != "smartmotor":
        found = next((each for each in made.commands if _matches(made, each, piece)), None)
        return None if found is None else Hover(explain(found), offset + begin, offset + begin + len(piece.rstrip()))
    words = ((m.start(), m[0]) for m in re.finditer(r"[^ \t]+", piece))
    word = next(((b, word) for b, word in words if b <= at - begin <= b + len(word)), None)
    return smartmotor.hover(word[1], at - begin - word[0], offset + begin + word[0]) if word else None


def _matches(made: Product, command: Any, line: str) -> bool:
    """True if a line of text is this command of a device of others."""
    ignore_case = getattr(getattr(made.driver, "framing", None), "ignore_case", None)  # None: no lines.
    return ignore_case is not None and bool(command.pattern.compiled(made.axes, ignore_case).fullmatch(line.strip()))


def _data_completions(made: Product, text: str, session: Callable[[], Session]) -> list[Item]:
    if made.family == "compumotor":
        return compumotor.Commands(made, ".talk").complete_at(text, session)
    *_, (_, piece) = _pieces(text)
    if made.family == "digiplan":
        return digiplan.following(piece)
    if made.family != "smartmotor":
        return [item(each, str(each.code)) for each in made.commands] if not piece.strip() else []
    return smartmotor.following(piece, smartmotor.Source(()), None)


def _session(lines: list[str], made: Product, name: str | None) -> Session:
    """Return the commands in a `.talk` file that change the mode of the controller `name`."""
    codec, commands = codec_of(made), compumotor.Commands(made)
    acts, _ = read_acts([line if _is_modal(line, name, commands) else "" for line in lines], ".talk", codec)
    listed = [session for host in sessions(acts, lines, ".talk", codec) for session in host]
    return listed[-1] if listed else Session(())


def _is_modal(line: str, name: str | None, commands: compumotor.Commands) -> bool:
    found = _LINE.match(line)
    if found is None or found["name"] != name:
        return False
    return found["mark"] == "!" or (found["mark"] == ">" and commands.is_modal(found["rest"]))


def _sequences(line: str, number: int) -> Iterator[Symbol]:
    found = _LINE.match(line)
    if found is not None and found["mark"] == ">":
        for begin, piece in _pieces(found["rest"]):
            yield from digiplan.sequences(piece, number, len(found["before"]) + begin)


# Pins and axes


@cache
def terminals(model: str) -> dict[str, tuple[str, ...]]:
    """Return the names that are valid after `!` and after `=` for a model, and the pins of the model."""
    controller = Bench().add(model)
    acts, asked = (_each(names, controller.axes) for names in (targets(controller), subjects(controller)))
    return {"!": acts, "=": asked, "pins": tuple(controller.pins)}


def _each(names: Iterable[str], axes: Iterable[str]) -> tuple[str, ...]:
    listed = list(axes)
    return tuple(
        each
        for name in names
        for each in ([name.replace("AXIS", axis) for axis in listed] if "AXIS" in name else [name])
    )


def _acts(model: str, mark: str, text: str) -> list[Item]:
    target, blank, _ = text.partition(" ")
    if not blank:
        return [Item(name, "pin", MARKS[mark]) for name in terminals(model)[mark] if "PIN" not in name]
    if target in terminals(model)["!"] and ("." not in target or target.endswith(".jam")):
        return [Item(level, "value") for level in (*LEVELS, *(("release",) if mark == "!" else ()))]
    return []


def _terminal(made: Product | None, text: str, at: int, offset: int) -> Hover | None:
    word = next((m for m in re.finditer(r"\S+", text) if m.start() <= at <= m.end()), None)
    if made is None or word is None or word.start() != 0:
        return None
    known = {name for names in terminals(made.model).values() for name in names}
    if word[0] not in known:
        return None
    kind = "axis" if "." in word[0] else "terminal or line"
    return Hover(f"**{word[0]}** {kind} of {with_article(made.title)}", offset + word.start(), offset + word.end())


def _headers(text: str) -> list[Item]:
    if text.startswith("model:"):
        return [Item(name, "value", made.title) for name in models() if (made := known(name)) is not None]
    return [Item(f"{key}: ", "key") for key in ("model", "options", "line", "patience")] if not text else []
