"""Names of control characters as in the manuals: `<CR>`."""

NAMES = {
    0x00: "NUL", 0x07: "BEL", 0x08: "BS", 0x09: "TAB", 0x0A: "LF", 0x0D: "CR", 0x11: "XON", 0x13: "XOFF", 0x1B: "ESC",
    0x7F: "DEL",
}  # fmt: skip


def word(byte: int) -> str:
    """Return a readable text for a byte: the character, its name such as `<CR>`, or its code such as `<9F>`."""
    return chr(byte) if 0x20 <= byte < 0x7F else f"<{NAMES.get(byte) or f'{byte:02X}'}>"


def show_controls(text: str) -> str:
    """Replace the control characters in a text by their names; a text of one space becomes `<SP>`."""
    return "<SP>" if text == " " else "".join(word(ord(c)) if ord(c) < 0x80 else c for c in text)
