"""The two forms of a program (section 15 of the base language): text, and the image that a host's compiler makes
(.smx).

The motor keeps the text without comments and needless blanks, each line ended by LF.  In the image a word of program
flow contains the place where the program continues: `$`, the word's first letter, four hexadecimal digits, and the rest
from its fourth letter on, so that WHILE becomes $W003CLE, LOOP $L0000P and IF $I003F.  A place is a number of
characters from the beginning of the text.

    $4 LLL SSSSSS NNNNNN HHHHHH 0000   labels, sum and length of the text, sum of the label addresses (hexadecimal)
    llllaaaa ...                       for each label Cn its number and its place
    text with jumps                    up to FF, after which a compiler may leave a note

The form of the words is known from reports of users; the sums and the length in the header from later firmware.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

JUMPING = ("IF", "ELSEIF", "ELSE", "WHILE", "LOOP", "SWITCH", "CASE", "DEFAULT", "BREAK")
WORDS = {(word[0], word[3:]): word for word in JUMPING}
END_OF_TEXT = b"\xff"

HEADER = 28  # Number of characters of a header with its line end; the label table follows.

_code = re.compile(r"""(?:"[^"]*(?:"|$)|[^"'])*""")
_word = re.compile(r'(?:"[^"\n]*(?:"|(?=\n)|$)|[^ \t\n"])+')
_line_end = re.compile(r"[\r\n\0]+")
_flow = re.compile(rf'"[^"\n]*"?|(?<![^ \t\n])(?:C\d{{1,3}}|ENDIF|ENDS|{"|".join(JUMPING)})(?![^ \t\n])', re.ASCII)
"""A label or a word of program flow; or quoted text, which contains neither."""
_label = re.compile(r"C(\d{1,3})", re.ASCII)
_jump = re.compile(r"\$([A-Z])[0-9A-F]{4}(.*)")
_header = re.compile(r"\$[0-9A-F]([0-9A-F]{3})([0-9A-F]{6})([0-9A-F]{6})[0-9A-F]{10}\n?")


def strip(source: str) -> str:
    """Return source text without comments and needless blanks, as the motor stores it."""
    lines = (_word.findall(_code.match(line)[0]) for line in _line_end.split(source))  # type: ignore[index]
    return "".join(" ".join(words) + "\n" for words in lines if words)


def labels(text: str) -> dict[int, int]:
    """Return the index in the text at which each label begins.  For a repeated label, the first index is returned."""
    places: dict[int, int] = {}
    for place, word, _ in _words(text):
        match = _label.fullmatch(word)
        if match:
            places.setdefault(int(match[1]), place)
    return places


def sums(text: str) -> tuple[int, int]:
    """Return both checksums of RCKS: sums of 24 bits over the label addresses and over the text."""
    return sum((place >> 8) + (place & 0xFF) for place in labels(text).values()) & 0xFFFFFF, _sum(text)


def _sum(text: str) -> int:
    return sum(text.encode("latin-1")) & 0xFFFFFF


@dataclass
class _Block:
    word: str
    place: int
    waiting: int | None  # Place of the word that will jump to the next branch; None if there is no such word.
    leaving: list[int] = field(default_factory=list)  # Places of the words that jump to the end of the block.


def encode(text: str) -> bytes:
    """Convert a program text to the bytes that the motor sends after the command UP."""
    targets = dict(_targets(text))
    program = _flow.sub(lambda match: _with_target(match, targets), text)
    table = "".join(f"{number:04X}{place:04X}" for number, place in labels(text).items())
    header, body = sums(text)
    head = f"$4{len(table) // 8:03X}{body:06X}{len(text):06X}{header:06X}0000"
    return (head + table + program).encode("latin-1")


class Decoder:
    """Decodes a program line by line while the program is received.  Little work is left at the end of the program."""

    def __init__(self) -> None:
        self._lines: list[str] = []
        self._rest = ""  # Received text that is not a complete line yet, or may belong to the header.
        self._header: tuple[int, int] | None = None
        self._begun = self._ended = False

    def feed(self, data: bytes) -> None:
        """Receive the next bytes of a program.  Bytes after the end marker FF are ignored."""
        if self._ended:
            return
        text, ended, _ = data.partition(END_OF_TEXT)
        self._ended = bool(ended)
        self._rest += text.decode("latin-1")
        if self._begin(whole=self._ended):
            self._decode(max(self._rest.rfind(end) for end in "\n\r\0") + 1)

    def result(self) -> tuple[str, bool]:
        self._begin(whole=True)
        self._decode(len(self._rest))
        text = "".join(self._lines)
        return text, self._header is None or self._header == (_sum(text), len(text))

    def _begin(self, *, whole: bool) -> bool:
        if self._begun or (len(self._rest) < HEADER and not whole):
            return self._begun
        match = _header.match(self._rest)
        if match is None:
            self._begun = True
            return True
        count, body, length = (int(digits, 16) for digits in match.groups())
        begin = match.end() + 8 * count
        if len(self._rest) >= begin or whole:
            self._begun, self._header, self._rest = True, (body, length), self._rest[begin:]
        return self._begun

    def _decode(self, end: int) -> None:
        lines, self._rest = self._rest[:end], self._rest[end:]
        self._lines.append(_readable(strip(lines)))


def _readable(text: str) -> str:
    return _word.sub(lambda match: _without_target(match[0]), text) if "$" in text else text


def _without_target(word: str) -> str:
    match = _jump.fullmatch(word)
    return WORDS.get((match[1], match[2]), word) if match else word


def _with_target(match: re.Match[str], targets: dict[int, int]) -> str:
    word, target = match[0], targets.get(match.start())
    return word if target is None else f"${word[0]}{target:04X}{word[3:]}"


def _words(text: str) -> Iterator[tuple[int, str, int]]:
    for match in _flow.finditer(text):
        yield match.start(), match[0], match.end() + 1


def _targets(text: str) -> Iterator[tuple[int, int]]:
    blocks: list[_Block] = []
    breakable: list[_Block] = []
    for place, word, behind in _words(text):
        if word in ("IF", "WHILE", "SWITCH"):
            blocks.append(_Block(word, place, place))
            if word != "IF":
                breakable.append(blocks[-1])
        elif word == "BREAK":
            if breakable:
                breakable[-1].leaving.append(place)
        elif blocks and word in PARTS[blocks[-1].word]:
            yield from _part(blocks[-1], place, word, behind)
            if word in ENDS and blocks.pop().word != "IF":
                breakable.pop()


PARTS = {"IF": ("ELSEIF", "ELSE", "ENDIF"), "WHILE": ("LOOP",), "SWITCH": ("CASE", "DEFAULT", "ENDS")}
ENDS = ("ENDIF", "LOOP", "ENDS")


def _part(block: _Block, place: int, word: str, behind: int) -> Iterator[tuple[int, int]]:
    if block.waiting is not None:
        yield block.waiting, behind if word in (*ENDS, "ELSE") else place
    block.waiting = None if word == "ELSE" else place
    if word == "ELSE":
        block.leaving.append(place)
    elif word == "LOOP":
        yield place, block.place
    if word in ENDS:
        yield from ((leaver, behind) for leaver in block.leaving)
