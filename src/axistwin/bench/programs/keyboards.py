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
NATIONAL = {glyph for keys in KEYBOARDS.values() for glyph in keys} - set(US)  # Not in ASCII.


def to_codes(keyboard: str, text: str) -> str:
    """Return the characters that are sent when a text is typed on this keyboard; letters match in either case."""
    keys = {key: code for glyph, code in zip(KEYBOARDS[keyboard], US, strict=True) for key in (glyph, glyph.swapcase())}
    return "".join(keys.get(character, character) for character in text)


def to_glyphs(keyboard: str, text: str) -> str:
    return text.translate(str.maketrans(US, KEYBOARDS[keyboard]))
