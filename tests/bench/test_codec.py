"""Characters as text and back."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from axistwin.bench import CHARACTERS
from axistwin.core.errors import ProgramError


@pytest.mark.parametrize(("data", "text"), [
    (b"U61\r", r"U61\r"), (b"\r\n", r"\r\n"), (b"\\", r"\\"), (b"\x00\x13\xff", r"\x00\x13\xFF"),
    (b"X 1000", "X 1000"), (b" X ", r"\x20X\x20"), (b"  ", r"\x20\x20"), (b"", "")])  # fmt: skip
def test_characters_are_shown(data, text):
    assert CHARACTERS.show(data) == text and CHARACTERS.read(text) == data


@given(st.binary(max_size=40))
def test_whatever_is_shown_reads_back(data):
    shown = CHARACTERS.show(data)
    assert CHARACTERS.read(shown) == data
    assert shown.isprintable() and shown == shown.strip()


@pytest.mark.parametrize(("text", "column", "words"), [
    (r"ab\q", 3, r"\q"), ("a\\", 2, "not an escape sequence"), (r"\x4", 1, "hex"), ("aé", 2, "é")])  # fmt: skip
def test_what_means_nothing_is_told_with_its_column(text, column, words):
    with pytest.raises(ProgramError) as caught:
        CHARACTERS.read(text)
    assert caught.value.column == column and words in str(caught.value)
