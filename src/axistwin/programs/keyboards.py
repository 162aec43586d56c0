"""National keyboards (IF1 manual, appendix 1): the keys for the codes of `# $ @ [ ] ^`."""

US = "#$@[\\]^"
KEYBOARDS = {
    "us": US,
    "uk": "£$@[\\]^",
    "france": "#$à°ç§^",
    "germany": "#$§ÄÖÜ^",
    "denmark": "#¤@ÆØÅ^",
    "sweden": "#¤ÉÄÖÅÜ",
    "norway": "#¤ÉÆØÅÜ",
    "italy": "#$@°\\é^",
    "spain": "£$@¡Ñ¿^",
}
"""Characters shown for the codes 23, 24, 40, 5B, 5C, 5D and 5E (hex), by country."""
NATIONAL = {glyph for keys in KEYBOARDS.values() for glyph in keys} - set(US)
"""Characters of these keyboards that are not ASCII."""


def to_codes(keyboard: str, text: str) -> str:
    """Convert letters of a national keyboard to the ASCII characters with the same codes, e.g. `Ä` to `[`.

    National keyboards with 7-bit codes use some codes of ASCII characters for letters.

    The example is for a German keyboard, which also sends `[` for `ä`.
    """
    keys = {key: code for glyph, code in zip(KEYBOARDS[keyboard], US, strict=True) for key in (glyph, glyph.swapcase())}
    return "".join(keys.get(character, character) for character in text)


def to_glyphs(keyboard: str, text: str) -> str:
    """Convert ASCII characters to the letters that a national terminal shows for their codes, e.g. `[` to `Ä`.

    The example is for a German terminal.
    """
    return text.translate(str.maketrans(US, KEYBOARDS[keyboard]))
