"""Reading numbers in texts: length and magnitude are limited, and an error is one short line."""

from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from axistwin.core.errors import MOST_MESSAGE, UsageError, one_line
from axistwin.core.numbers import MOST_CHARACTERS, NumberError, check_values, decimal, real, shortened, whole

from .told import raises


@pytest.mark.parametrize(("text", "value"), [
    ("0", 0), ("-5", -5), ("+7", 7), (str(2**63 - 1), 2**63 - 1), (str(-(2**63)), -(2**63)), ("0" * 99 + "1", 1)
])  # fmt: skip
def test_whole_numbers(text, value):
    assert whole(text) == value


def test_other_bases():
    assert whole("0x7F", base=0) == 127 and whole("FF", base=16) == 255
    assert whole("1" * 64, 0, 2**64 - 1, base=2) == 2**64 - 1


@pytest.mark.parametrize(("text", "message"), [
    ("", "'' is not a whole number: expected e.g. 12"), ("1.5", "'1.5' is not a whole number: expected e.g. 12"),
    (str(2**63), f"'{2**63}' is out of range: expected a whole number from {-(2**63)} to {2**63 - 1}"),
    ("٣", "'٣' is not a whole number: expected the digits 0 to 9"),
    ("9" * 101, f"'{'9' * 40}'… (101 characters) is too long for a whole number: expected at most 100 characters")
])  # fmt: skip
def test_what_is_no_whole_number(text, message):
    with pytest.raises(NumberError) as told:
        whole(text)
    assert str(told.value) == message


@pytest.mark.parametrize("read", [real, decimal])
@pytest.mark.parametrize("text", ["nan", "inf", "-Infinity", "1e400", "1e999999999", "9" * 5000, "", "x", "1,5", "²"])
def test_what_is_no_number(read, text):
    raises(NumberError, "", read, text)


def test_numbers():
    assert real("2.5e3") == 2500.0
    assert decimal("0.000000001") == Decimal(1).scaleb(-9) and decimal("9" * 30) == 10**30 - 1
    raises(NumberError, "out of range", decimal, "1" + 30 * "0")
    raises(NumberError, "out of range", decimal, "1e-999999999")


def test_it_is_a_usage_error_and_a_value_error():
    assert issubclass(NumberError, UsageError) and issubclass(NumberError, ValueError)


def test_what_a_library_has_read_is_looked_through():
    check_values({"a": [1, {"b": -(2**63)}], "c": "9" * 500, "d": True})
    with pytest.raises(NumberError) as told:
        check_values({"a": [1, {"b": 2**63}]})
    assert told.value.path == ("a", 1, "b")


@given(st.text(max_size=200))
def test_any_text_is_a_number_or_a_number_error(text):
    for read in (whole, real, decimal):
        try:
            value = read(text)
        except NumberError as error:
            told, value = str(error), 0
        else:
            told = ""
        assert len(told) < MOST_MESSAGE
        assert told or len(text) <= MOST_CHARACTERS
        assert abs(value) < float("inf")


def test_a_message_is_one_line_that_people_can_read():
    assert one_line("short: it stays, é too") == "short: it stays, é too"
    assert one_line("a\nb\0") == "a\\nb\\x00" and one_line(f"no {'9' * 5000} here") == f"no {'9' * 60}… here"
    shown = one_line("x " * 5000 + "remedy")
    assert len(shown) == MOST_MESSAGE + 3 and shown.endswith("remedy")
    assert shortened("9" * 41) == f"'{'9' * 40}'… (41 characters)"
