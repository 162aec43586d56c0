"""Errors that a user of axistwin can correct: each message is one line with its place and its remedy.

Errors of a *host* raise no exception: the device ignores the data, sets a flag, or lights its LED.
Any other exception is a bug and is not caught.
"""

import os
import re
from collections.abc import Collection, Iterable
from importlib.util import find_spec
from typing import Self

MOST_WORD, MOST_MESSAGE = 240, 480
"""Largest number of characters in a word of a message, and in a whole message; longer texts are shortened."""
_BEGIN = 60
_long_word = re.compile(rf"\S{{{MOST_WORD + 1},}}")


def one_line(message: str) -> str:
    """Return a message as one printable line; the middle of a long message is left out."""
    if len(message) <= MOST_WORD and message.isprintable():
        return message
    shown = printable(message.strip())
    shown = _long_word.sub(lambda word: f"{word[0][:_BEGIN]}…", shown)
    return shown if len(shown) <= MOST_MESSAGE else f"{shown[: MOST_MESSAGE // 2]} … {shown[-MOST_MESSAGE // 2 :]}"


def printable(text: str) -> str:
    """Return a text in which each character that cannot be printed is an escape sequence, e.g. \\n."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def instead(word: str, known: Collection[str]) -> str:
    """Return a suggestion for an unknown word: the most similar known word, or all known words."""
    similar = most_similar(word, known)
    return f"did you mean {similar!r}?" if similar else f"expected one of {', '.join(known)}"


def most_similar(word: str, known: Iterable[str]) -> str:
    """Return the known word that is most similar to a misspelt word; "" if no known word is similar."""
    from difflib import get_close_matches  # lazy import: only a misspelt word needs the module

    return next(iter(get_close_matches(word, list(known), n=1)), "")


def one_letter_off(word: str, other: str) -> bool:
    """Return True if a letter is missing, more, wrong, or two are exchanged."""
    pairs = enumerate(zip(word, other, strict=False))
    same = next((at for at, (a, b) in pairs if a != b), min(len(word), len(other)))
    word, other = word[same:], other[same:]
    return other in (word[1:], word[1::-1] + word[2:]) or other[1:] in (word, word[1:])


def with_article(noun: str) -> str:
    return f"{'an' if noun.lower().startswith((*'aeiou', '18')) else 'a'} {noun}"


def reason(error: BaseException) -> str:
    """Return the system's words for an error, e.g. "no such file or directory"; pyserial's has it as its context."""
    for one in filter(None, (error, error.__context__)):
        number = getattr(one, "errno", None) or next(iter(one.args), None)
        if isinstance(number, int):
            words = os.strerror(number) if number > 0 else getattr(one, "strerror", None) or str(one)
            return words.lower()
    return str(error)


def cannot_open(port: object, error: Exception) -> str:
    """Return the message, with the remedy, about a port that a host or a server cannot open."""
    known, words = isinstance(error.__context__ or error, OSError), reason(error)
    if words == str(error) or not known:
        words = "no port number" if isinstance(error.__context__, TypeError | KeyError) else words
        remedy = "expected a port, e.g. socket://127.0.0.1:5001"
    elif "://" in f"{port}".removeprefix("serial://"):
        remedy = "start the server, and check the address"
    else:
        remedy = "check the name of the port, the cable and your permissions, and close other programs on it"
    return f"cannot open {port} ({words}): {remedy}"


class AxistwinError(Exception):
    """An error that the user can correct.  The message is one line and contains the remedy."""


class UsageError(AxistwinError):
    """Raised for an option, a name or a value that is not valid."""


class MissingExtraError(UsageError):
    """Raised if the library for an optional feature is not installed."""

    def __init__(self, library: str, extra: str) -> None:
        super().__init__(f"needs {library}: {installation(extra, library)}")


def installed(library: str) -> bool:
    return find_spec(library) is not None or find_spec(library.lower()) is not None


def require(library: str, extra: str) -> None:
    """Raise MissingExtraError if the library of an extra is not installed."""
    if not installed(library):
        raise MissingExtraError(library=library, extra=extra)


def installation(extra: str, library: str) -> str:
    """Return the pip commands that install the libraries of an optional extra."""
    from importlib.metadata import PackageNotFoundError, requires  # lazy import: `importlib.metadata` loads slowly

    try:
        wanted = requires("axistwin") or []
    except PackageNotFoundError:
        # axistwin is not installed with pip, and runs from its source directory.
        wanted = []
    markers = {f"extra == {quote}{extra}{quote}" for quote in "'\""}
    parts = [one.partition(";") for one in wanted]
    named = [name.strip() for name, _, marker in parts if marker.strip() in markers] or [library.lower()]
    words = " ".join(f'"{name}"' for name in named)
    return f'pip install {words}, or in a clone pip install ".[{extra}]"'


class PlacedError(AxistwinError):
    """Raised for an error in a user's file: `file:line:column: message`.

    For checkers: `code` of the violated rule; `width` in columns; `instead`: a possible replacement, or, if `sure`, the
    only possible one.
    """

    def __init__(
        self, message: str, *, file: str = "", line: int = 0, column: int = 0, code: str = "", width: int = 1,
        instead: str = "", sure: bool = False,
    ) -> None:  # fmt: skip
        message = one_line(message)
        self.message, self.file, self.line, self.column = message, file, line, column
        self.code, self.width, self.instead, self.sure = code, width, instead, sure
        place = ":".join(str(part) for part in (file, line, column) if part)
        super().__init__(f"{place}: {message}" if place else message)

    def at(self, file: str, line: int, column: int) -> Self:
        return type(self)(
            self.message, file=file, line=line, column=column, code=self.code, width=self.width, instead=self.instead,
            sure=self.sure,
        )  # fmt: skip


class SceneError(PlacedError):
    """Raised if a scene file is invalid."""


class NoSceneError(SceneError, UsageError):
    """Raised if a scene file does not exist or cannot be opened."""


class DeviceError(PlacedError, UsageError):
    """Raised if the file of a device cannot be loaded."""


class ProgramError(PlacedError):
    """Raised for an error in a program or in the file of a conversation."""


class TraceError(AxistwinError):
    """Raised for a file that is not a trace of axistwin."""


class LinkError(AxistwinError):
    """Raised if a port cannot be opened, or if the controller at the port does not answer."""


def unknown(kind: str, name: str, names: Collection[str]) -> UsageError:
    """Return the error for a mistyped name."""
    near = most_similar(name.lower(), names)
    return UsageError(f"no {kind} {name!r}: {f'did you mean {near}?' if near else 'expected ' + ', '.join(names)}")
