"""The screen of a terminal: notes stand below the line that they explain."""

import io

from axistwin.ui.terminal.screen import Screen

NOTE = "the plus limit is open: only moves in the minus direction begin (PL3 terminal 2): type  :drive limit_plus high"


def test_a_note_is_wrapped_at_blanks_with_a_hanging_indent_below_its_line(monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    screen = Screen(out := io.StringIO(), person=True, colours=False, editor=True)
    screen.typed("X1000$")
    screen.aside(NOTE)
    screen.tell(NOTE)
    assert out.getvalue().splitlines() == [
        "> X1000$",
        "  the plus limit is open: only moves in the minus direction",
        "    begin (PL3 terminal 2): type  :drive limit_plus high",
        "the plus limit is open: only moves in the minus direction",
        "  begin (PL3 terminal 2): type  :drive limit_plus high",
    ]


def test_a_pipe_gets_each_note_as_one_line(monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    screen = Screen(out := io.StringIO(), person=False, colours=False)
    screen.aside(NOTE)
    assert out.getvalue() == f"  {NOTE}\n"
