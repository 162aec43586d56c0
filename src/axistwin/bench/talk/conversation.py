r"""A conversation: a text format for recordings, tests and replay.  Each line is one action.

    ; comment                     + 0.25   time passes, in seconds
    > U61\r                       the host transmits
    < U\r                         the controller transmits
    ! input1 high                 an action at the machine
    = X.position 1000             an assertion

With several controllers on the bench a line begins with the name of its controller: `left: > X100$\r`.
`docs/conversations.md` describes each act; `conversations/player.py` plays them.
"""

import re
import shlex
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any

from axistwin.bench import is_model, product, rules
from axistwin.bench.acts import Act, Comment, Do, Expect, Hear, Say, Wait
from axistwin.bench.codec import CHARACTERS, Codec, codec_of
from axistwin.bench.typography import refuse
from axistwin.core.errors import PlacedError, ProgramError, UsageError
from axistwin.core.numbers import NumberError, decimal, real, shortened
from axistwin.core.storage import contents, encoding_of, split_at_end
from axistwin.core.units import MOST_NS, S

MOST_MIB = 4
END_OF_FILE = "\x1a"  # Ctrl-Z, the end-of-file mark of DOS editors.
MOST_S = 1e9  # Longest accepted time in a header, about thirty years; a longer time is probably a typing error.
_LINE = re.compile(r"(?:(?P<name>[\w.-]+):\s+)?(?P<mark>[;+><!=])(?P<rest>.*)")
_HOST_LINE = re.compile(r"\s*(?:[\w.-]+:\s+)?>\s")
"""With a blank: in command lines of an IF1, `>2` selects a speed range."""
_SECONDS = re.compile(r"\d+(\.\d*)?|\.\d+", re.ASCII)
_HEADER = re.compile(r"(?P<key>model|options|line|patience|on-for|host):\s*(?P<value>.*)")


@dataclass(frozen=True)
class Conversation:
    """The lines of a conversation, in order.  `file`: path of the file, which error messages name."""

    acts: tuple[Act, ...]
    file: str = ""
    codec: Codec = CHARACTERS  # Codec for the notation of data in this conversation.

    @property
    def headers(self) -> dict[str, str]:
        """Settings in the comments at the beginning, e.g. {"model": "if1"} from `; model: if1`."""
        return {key: value for key, (_, value) in self._header_comments.items()}

    @property
    def _header_comments(self) -> dict[str, tuple[Comment, str]]:
        found: dict[str, tuple[Comment, str]] = {}
        for act in self.acts:
            if not isinstance(act, Comment):
                break
            if header := _HEADER.fullmatch(act.text):
                found[header["key"]] = act, header["value"].strip()
        return found

    def seconds_in(self, key: str, default: float) -> float:
        """Return 60.0 from `; patience: 60`, or `default` without this header.  Raises ProgramError with the line."""
        if key not in self.headers:
            return default
        given_value = self.headers[key]
        with self.placing_errors_at_header(key):
            try:
                seconds = real(given_value)
            except NumberError:
                seconds = -1.0
            if not 0 <= seconds <= MOST_S:
                raise UsageError(
                    f"invalid value {shortened(given_value)} of the header {key}: expected seconds, e.g. 2.5"
                )
        return seconds

    @property
    def option_words(self) -> list[str]:
        """Words of the `; options:` header.  Raises ProgramError with the line if a quotation mark is missing."""
        with self.placing_errors_at_header("options"):
            try:
                return shlex.split(self.headers.get("options", ""))
            except ValueError:
                raise UsageError(
                    "a quotation mark is missing in the options: expected a pair, e.g. line='9600 8N2'"
                ) from None

    @contextmanager
    def placing_errors_at_header(self, key: str) -> Iterator[None]:
        """Within a `with` block, give errors file and line of the header `key`, if the conversation has it."""
        if key not in self.headers:
            yield
            return
        with self.placing_errors(self._header_comments[key][0]):
            yield

    @contextmanager
    def placing_errors(self, act: Act) -> Iterator[None]:
        try:
            yield
        except (PlacedError, UsageError) as error:
            raise ProgramError(message=str(error), file=self.file, line=act.line) from None


def load(path: Path, codec: Codec | None = None) -> Conversation:
    return parse(load_text(path), str(path), codec)


def load_text(path: Path) -> str:
    """Read a text file.  Raises UsageError if the file cannot be read, ProgramError if the file is not text."""
    data, _ = split_at_end(contents(path, MOST_MIB))
    encoding = encoding_of(data)
    if encoding == "utf-16" or b"\0" in data:
        raise ProgramError("the file is not text: expected UTF-8, Latin-1, or code page 437 or 850", file=str(path))
    return data.decode(encoding, "replace").replace("\r\n", "\n").replace("\r", "\n")


def parse(text: str, file: str = "", codec: Codec | None = None, model: str = "") -> Conversation:
    """Read a conversation.  Raises ProgramError with file, line and column.

    `codec` None: the notation is that of the model in the `; model:` header, or else of `model`.
    """
    lines = text.splitlines()
    codec = codec or _codec(named_model(lines) or model)
    acts = (parse_line(line, number, file, codec) for number, line in enumerate(lines, start=1) if line.strip())
    return Conversation(tuple(acts), file, codec)


def is_conversation(lines: Sequence[str]) -> bool:
    """True for a text with a host's line, or with a header that names the model, whatever the name of its file."""
    return bool(named_model(lines)) or any(_HOST_LINE.match(line) for line in lines)


def named_model(lines: Iterable[str]) -> str:
    for line in lines:
        if line.strip() and not line.lstrip().startswith(";"):
            break
        header = _HEADER.fullmatch(line.strip("; \t"))
        if header and header["key"] == "model":
            return header["value"].strip()
    return ""


def _codec(model: str) -> Codec:
    return codec_of(product(model)) if is_model(model) else CHARACTERS


def write(conversation: Conversation | Iterable[Act], codec: Codec | None = None) -> str:
    """Return the text of a conversation.  `codec`: another notation of the data."""
    whole = conversation if isinstance(conversation, Conversation) else Conversation(tuple(conversation))
    return "".join(f"{_written(act, codec or whole.codec)}\n" for act in whole.acts)


def seconds(ns: int) -> str:
    return f"{Decimal(ns) / S:f}"


def parse_line(line: str, number: int, file: str, codec: Codec = CHARACTERS) -> Act:
    """Parse one line of a conversation; the line must not be blank."""
    found = _LINE.fullmatch(line.strip())
    indent = len(line) - len(line.lstrip())
    if not found:
        raise ProgramError(
            "unknown kind of line: expected `;`, `+`, `>`, `<`, `!` or `=` at the beginning, e.g. `> K`",
            file=file, line=number, column=indent + 1, code=rules.NO_ACT.code, width=max(1, len(line.strip())),
        )  # fmt: skip
    if found["mark"] != ";":
        refuse(line if found["mark"] in "<>" else line.partition(";")[0], file, number)
    rest = found["rest"].strip()
    column = indent + len(found[0]) - len(found["rest"].lstrip())
    try:
        return _act(found["mark"], rest, codec, {"line": number, "controller": found["name"] or ""})
    except ProgramError as error:
        raise error.at(file=file, line=number, column=column + (error.column or 1)) from None


def _act(mark: str, text: str, codec: Codec, place: dict[str, Any]) -> Act:
    match mark:
        case ";":
            return Comment(text, **place)
        case "+":
            return Wait(_time_ns(_without_comment(text)), **place)
        case ">":
            return Say(codec.read(text), **place)
        case "<":
            return Hear(codec.hear(text), **place)
        case "!":
            return Do(*_name_and_value(text, "power off"), **place)
    return Expect(*_name_and_value(text, "X.position 1000"), **place)


def _time_ns(given_time: str) -> int:
    try:
        ns = round(decimal(given_time) * S) if _SECONDS.fullmatch(given_time) else None
    except NumberError:
        ns = None
    if ns is None:
        raise ProgramError(
            f"invalid time {shortened(given_time)}: expected seconds, e.g. +0.25",
            code=rules.NO_TIME.code,
            width=max(1, len(given_time)),
        )
    if ns >= MOST_NS:
        raise ProgramError(
            f"{shortened(given_time)} s is too long: expected less than 9.2e9 s (292 years)",
            code=rules.NO_TIME.code,
            width=len(given_time),
        )
    return ns


def _name_and_value(text: str, example: str) -> tuple[str, str]:
    name, _, value = _without_comment(text).partition(" ")
    if not value.strip():
        raise ProgramError(
            f"the value is missing: expected a name and a value, e.g. {example!r}",
            column=len(name) + 1,
            code=rules.NO_VALUE.code,
        )
    return name, value.strip()


def _without_comment(text: str) -> str:
    """Remove the comment after a time, a level or a value; data can contain semicolons and are not changed."""
    return text.partition(";")[0].strip()


def _written(act: Act, codec: Codec) -> str:
    name = f"{act.controller}: " if act.controller else ""
    match act:
        case Comment():
            return f"{name}; {act.text}".rstrip()
        case Wait():
            return f"{name}+{seconds(act.ns)}"
        case Say():
            return f"{name}> {codec.show(act.data)}"
        case Hear():
            return f"{name}< {codec.show(act.data)}".rstrip()
        case Do():
            return f"{name}! {act.target} {act.value}"
        case Expect():
            return f"{name}= {act.subject} {act.value}"
    raise AssertionError(f"unknown action {act!r}: expected an object of a class in the module axistwin.bench.acts")
