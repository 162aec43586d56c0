"""Control characters in words, as the manuals write them: `<CR>`."""

NAMES = {
    0x00: "NUL", 0x07: "BEL", 0x08: "BS", 0x09: "TAB", 0x0A: "LF", 0x0D: "CR", 0x11: "XON", 0x13: "XOFF", 0x1B: "ESC",
    0x7F: "DEL",
}  # fmt: skip


def word(byte: int) -> str:
    """A character as people can read it: itself, `<CR>`, or its number as `<9F>`."""
    if 0x20 <= byte < 0x7F:
        return chr(byte)
    return f"<{NAMES.get(byte) or f'{byte:02X}'}>"


def in_words(text: str) -> str:
    """A text with its control characters in words; a single space is `<SP>`."""
    return "<SP>" if text == " " else "".join(word(ord(c)) if ord(c) < 0x80 else c for c in text)
