r"""A conversation: one text format for recordings, golden tests and replay.  One line, one act.

    ; comment                     + 0.25   time passes, in seconds
    > U61\r                       the host says
    < U\r                         the controller says
    ! input1 high                 somebody at the machine does something
    = X.position 1000             something must be so

With several controllers on the bench a line begins with the name of the one that is meant: `left: > X100$\r`.
What each act means when it is played is told in `docs/conversations.md`; `conversations/player.py` does it.
"""

import re
import shlex
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path

from axistwin.bench import FAMILIES, product, rules
from axistwin.bench.acts import Act, Comment, Do, Expect, Hear, Say, Wait
from axistwin.bench.codec import CHARACTERS, Codec, codec_of
from axistwin.errors import PlacedError, ProgramError, UsageError
from axistwin.numbers import NumberError, decimal, real, shortened
from axistwin.units import MOST_NS, S

MOST_BYTES = 4 << 20
MOST_S = 1e9
"""The longest time in a header, some thirty years; more is a slip of the pen."""
_LINE = re.compile(r"(?:(?P<name>[\w.-]+):\s+)?(?P<mark>[;+><!=])(?P<rest>.*)")
_SECONDS = re.compile(r"\d+(\.\d*)?|\.\d+", re.ASCII)
_HEADER = re.compile(r"(?P<key>model|options|line|patience|on-for|host):\s*(?P<value>.*)")


@dataclass(frozen=True)
class Conversation:
    """Acts in order; `file` is where they stand, for messages."""

    acts: tuple[Act, ...]
    file: str = ""
    codec: Codec = CHARACTERS
    """How what is said is written in it."""

    @property
    def headers(self) -> dict[str, str]:
        """What its first comments say about the bench it is for: `; model: if1`, `; options: …`, `; line: …`."""
        return {key: value for key, (_, value) in self._heads.items()}

    @property
    def _heads(self) -> dict[str, tuple[Comment, str]]:
        """The same, each with the comment that says so."""
        found: dict[str, tuple[Comment, str]] = {}
        for act in self.acts:
            if not isinstance(act, Comment):
                break
            if header := _HEADER.fullmatch(act.text):
                found[header["key"]] = act, header["value"].strip()
        return found

    def seconds_in(self, key: str, usual: float) -> float:
        """The number of seconds in this header, or else the usual one.  Raises ProgramError with the line."""
        if key not in self.headers:
            return usual
        text = self.headers[key]
        with self.blaming_header(key):
            try:
                seconds = real(text)
            except NumberError:
                seconds = -1.0
            if not 0 <= seconds <= MOST_S:
                raise UsageError(f"{key} {shortened(text)} is no number of seconds: write it like ; {key}: 2.5")
        return seconds

    @property
    def words(self) -> list[str]:
        """The words in its `; options:` header.  Raises ProgramError with the line if a quotation mark is missing."""
        with self.blaming_header("options"):
            try:
                return shlex.split(self.headers.get("options", ""))
            except ValueError:
                raise UsageError("options: a quotation mark is missing") from None

    @contextmanager
    def blaming_header(self, key: str) -> Iterator[None]:
        """What a user has done wrong meanwhile stands in the line of this header, if it is there."""
        if key not in self.headers:
            yield
            return
        with self.blaming(self._heads[key][0]):
            yield

    @contextmanager
    def blaming(self, act: Act) -> Iterator[None]:
        """What a user has done wrong meanwhile stands in the line of this act."""
        try:
            yield
        except (PlacedError, UsageError) as error:
            raise ProgramError(str(error), file=self.file, line=act.line) from None


def load(path: Path, codec: Codec | None = None) -> Conversation:
    """Read a conversation from a file."""
    return parse(load_text(path), str(path), codec)


def load_text(path: Path) -> str:
    """A text file that the user has named.  Raises UsageError if it is not there, ProgramError if it is no text."""
    try:
        if path.exists() and not path.is_file():
            raise UsageError(f"{path} cannot be read: it is no file")
        if path.stat().st_size > MOST_BYTES:
            raise UsageError(f"{path} cannot be read: no program is larger than {MOST_BYTES >> 20} MiB")
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ProgramError("is not a text file in UTF-8", file=str(path)) from None


def parse(text: str, file: str = "", codec: Codec | None = None, model: str = "") -> Conversation:
    """Read a conversation.  Raises ProgramError with file, line and column.

    `codec` None: what is said is written as its `; model:` has it, or else as `model` has it.
    """
    lines = text.splitlines()
    codec = codec or _codec(named_model(lines) or model)
    acts = (parse_line(line, number, file, codec) for number, line in enumerate(lines, start=1) if line.strip())
    return Conversation(tuple(acts), file, codec)


def named_model(lines: Iterable[str]) -> str:
    """The model that the first comments name, if they name one."""
    for line in lines:
        if line.strip() and not line.lstrip().startswith(";"):
            break
        header = _HEADER.fullmatch(line.strip("; \t"))
        if header and header["key"] == "model":
            return header["value"].strip()
    return ""


def _codec(model: str) -> Codec:
    return codec_of(product(model)) if model.lower() in FAMILIES else CHARACTERS


def write(conversation: Conversation | Iterable[Act], codec: Codec | None = None) -> str:
    """The acts as text, one line each; of mere acts, what is said is characters unless `codec` says otherwise."""
    whole = conversation if isinstance(conversation, Conversation) else Conversation(tuple(conversation))
    return "".join(f"{_written(act, codec or whole.codec)}\n" for act in whole.acts)


def seconds(ns: int) -> str:
    """Nanoseconds as seconds in plain decimals, without losing any."""
    return f"{Decimal(ns) / S:f}"


def parse_line(line: str, number: int, file: str, codec: Codec = CHARACTERS) -> Act:
    """Read one line that is not blank."""
    found = _LINE.fullmatch(line.strip())
    indent = len(line) - len(line.lstrip())
    if not found:
        raise ProgramError(
            "a line begins with ; + > < ! or =, or with a controller's name and a colon before that",
            file=file, line=number, column=indent + 1, code=rules.NO_ACT.code, width=max(1, len(line.strip())),
        )  # fmt: skip
    rest = found["rest"].strip()
    column = indent + len(found[0]) - len(found["rest"].lstrip())
    try:
        return _READERS[found["mark"]](rest, codec, number, found["name"] or "")
    except ProgramError as error:
        raise error.at(file, number, column + (error.column or 1)) from None


def _comment(text: str, _codec: Codec, line: int, controller: str) -> Act:
    return Comment(text, line=line, controller=controller)


def _wait(text: str, _codec: Codec, line: int, controller: str) -> Act:
    number = _without_comment(text)
    try:
        if not _SECONDS.fullmatch(number):
            raise NumberError(f"{shortened(number)} is no time")
        ns = round(decimal(number) * S)
    except NumberError as error:
        message = f"{error}: write seconds, like +0.25"
        raise ProgramError(message, code=rules.NO_TIME.code, width=max(1, len(number))) from None
    if ns >= MOST_NS:
        message = f"{shortened(number)} s is too long: give less than 292 years, 9.2e9 s"
        raise ProgramError(message, code=rules.NO_TIME.code, width=len(number))
    return Wait(ns, line=line, controller=controller)


def _say(text: str, codec: Codec, line: int, controller: str) -> Act:
    return Say(codec.read(text), line=line, controller=controller)


def _hear(text: str, codec: Codec, line: int, controller: str) -> Act:
    return Hear(codec.hear(text), line=line, controller=controller)


def _do(text: str, _codec: Codec, line: int, controller: str) -> Act:
    target, value = _name_and_value(text, "! input1 high")
    return Do(target, value, line=line, controller=controller)


def _expect(text: str, _codec: Codec, line: int, controller: str) -> Act:
    subject, value = _name_and_value(text, "= X.position 1000")
    return Expect(subject, value, line=line, controller=controller)


_READERS = {";": _comment, "+": _wait, ">": _say, "<": _hear, "!": _do, "=": _expect}


def _name_and_value(text: str, example: str) -> tuple[str, str]:
    name, _, value = _without_comment(text).partition(" ")
    if not value.strip():
        message = f"a name and a value are wanted, like {example!r}"
        raise ProgramError(message, column=len(name) + 1, code=rules.NO_VALUE.code)
    return name, value.strip()


def _without_comment(text: str) -> str:
    """Behind times, levels and values there may be a comment; behind characters not, they could be meant."""
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
    raise AssertionError(act)
