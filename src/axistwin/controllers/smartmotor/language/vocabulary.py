"""Reception of commands (sections 2 and 3 of the base language): terminators, quotes, lists of array values."""

import re
from collections.abc import Callable

from axistwin.controllers.smartmotor.language.lexer import begins_list

LONGEST = 64  # Largest number of characters in a command; a longer command is discarded.
LONGEST_LIST = 204  # Largest number of values in a list such as `ab[0] 1 2 3.`, which is the size of the array.

GLOBAL, LAST_ADDRESS = 0x80, 0x80 + 120  # Address bytes: that of all motors, and the last one.
SPACE, CR, QUOTE = ord(" "), ord("\r"), ord('"')
TERMINATORS = (SPACE, CR, ord("\n"), 0)
LIST_VALUE = re.compile(r"-?\d+\.?|\.", re.ASCII)


class Words:
    """Collects the characters of a command, and executes the command at its terminator."""

    def __init__(self, obey: Callable[[str], None], overflow: Callable[[], None]) -> None:
        self._obey, self._overflow = obey, overflow
        self._text, self._list = bytearray(), list[str]()
        self._quoted = self._dropping = False

    @property
    def begun(self) -> bool:
        return bool(self._text or self._list)

    @property
    def text(self) -> str:
        return " ".join([*self._list, self._text.decode("ascii")])

    def forget(self) -> str:
        """Discard an incomplete command; return its text, "" if no command had begun."""
        text = self.text if self.begun else ""
        self._text.clear()
        self._list.clear()
        self._quoted = self._dropping = False
        return text

    def drop(self) -> None:
        self._dropping = True

    def take(self, byte: int) -> None:
        """Receive a character below 80h; a terminator executes the command, but not a space between quotes."""
        if byte in TERMINATORS and not (byte == SPACE and self._quoted):
            self._end(byte)
            return
        self._quoted ^= byte == QUOTE
        if len(self._text) < LONGEST:
            if byte >= SPACE or self._text:  # Control characters (below 20h) before a command are ignored.
                self._text.append(byte)
        elif not self._dropping:
            self._dropping = True
            self._overflow()

    def _end(self, terminator: int) -> None:
        word, dropped = self._text.decode("ascii"), self._dropping
        self._text.clear()
        self._quoted = self._dropping = False
        if dropped:
            self._end_list()
        elif self._list:
            self._continue_list(word, terminator)
        elif terminator == SPACE and begins_list(word):
            self._list.append(word)
        elif word:
            self._obey(word)

    def _continue_list(self, word: str, terminator: int) -> None:
        listed = LIST_VALUE.fullmatch(word) is not None
        if listed:
            self._list.append(word)
        if terminator != SPACE or word.endswith(".") or (word and not listed) or len(self._list) > LONGEST_LIST:
            self._end_list()
            if word and not listed:
                self._obey(word)

    def _end_list(self) -> None:
        words = " ".join(self._list)
        self._list.clear()
        if words:
            self._obey(words)
