"""Reading and writing conversations."""

import pytest

from axistwin.bench import Comment, Do, Expect, Hear, Say, Wait
from axistwin.bench.talk.conversation import load, parse, seconds, write
from axistwin.core.errors import ProgramError, UsageError
from axistwin.core.units import MS

from ..told import raises

EVERY_ACT = r"""; model: if1
; options: wiring=3-wire
+0.25
> U61\r
< U\r
<
! input1 high
= X.position 1000
left: > X100$\r
"""


def test_every_act():
    acts = parse(EVERY_ACT).acts
    assert acts == (
        Comment("model: if1"), Comment("options: wiring=3-wire"), Wait(250 * MS), Say(b"U61\r"), Hear(b"U\r"),
        Hear(b""), Do("input1", "high"), Expect("X.position", "1000"), Say(b"X100$\r", controller="left"),
    )  # fmt: skip
    assert [act.line for act in acts] == list(range(1, 10))


def test_what_is_written_is_what_was_read():
    assert write(parse(EVERY_ACT).acts) == EVERY_ACT


def test_headers_are_the_first_comments():
    conversation = parse("; A title\n; model: if2\n; line: 2400 8N2\n+1\n; model: if1\n")
    assert conversation.headers == {"model": "if2", "line": "2400 8N2"}


def test_blank_lines_and_blanks_around_do_not_count():
    assert parse("\n  > A B \n\n+1\n").acts == (Say(b"A B"), Wait(1_000_000_000))


def test_a_semicolon_is_a_comment_behind_times_and_levels_but_a_character_behind_words():
    acts = parse("+1 ; a second\n! estop low ; pressed\n> a;b").acts
    assert acts == (Wait(1_000_000_000), Do("estop", "low"), Say(b"a;b"))


@pytest.mark.parametrize("ns", [0, 1, 999_999_999, 1_000_000_000, 86_400_000_000_001, 250 * MS])
def test_times_are_written_to_the_nanosecond(ns):
    assert parse(f"+{seconds(ns)}").acts == (Wait(ns),)


@pytest.mark.parametrize(("text", "place", "words"), [
    ("+1\nhello\n", "a.talk:2:1", "unknown kind of line"), ("+soon", "a.talk:1:2", "expected seconds"),
    ("+-1", "a.talk:1:2", "expected seconds"), (r"> U\y", "a.talk:1:4", r"\y"),
    ("! input1", "a.talk:1:9", "power off"), ("  = X.position", "a.talk:1:15", "X.position 1000"),
    ("left: ?", "a.talk:1:1", "unknown kind of line")])  # fmt: skip
def test_mistakes_have_a_place(text, place, words):
    with pytest.raises(ProgramError) as caught:
        parse(text, "a.talk")
    assert str(caught.value).startswith(place + ": ") and words in str(caught.value)


def test_a_file_that_is_not_there(tmp_path):
    raises(UsageError, "no.talk cannot be read: No such file", load, tmp_path / "no.talk")


def test_a_file_that_is_no_text(tmp_path):
    (tmp_path / "a.talk").write_bytes(b"\xff\xfe")
    raises(ProgramError, "UTF-8", load, tmp_path / "a.talk")
