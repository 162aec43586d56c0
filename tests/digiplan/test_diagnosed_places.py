"""The checker names the manual's chapter for each mistake, and marks the characters concerned, no more and no fewer."""

import pytest

from .test_check import check

SEQUENCES = "Programming a sequence"
COMBINING = "Combining inputs and outputs with move instructions"
INDEX, RUN, SWITCHING = "Index mode instructions", "Run mode instructions", "Output switching commands"

WRONG = {
    # line: (chapter in which the command is described, the marked characters)
    "X10?$": ("Full command list", "?"),
    "X10mm$": ("Full command list", "mm"),
    "X5 x1000$": ("Full command list", "x"),
    "X5 ? 10$": ("Full command list", "?"),
    "B20": ("Full command list", "20"),
    "S1 20$": (SWITCHING, "1 20"),
    "X100 E": ("Busy status", "E"),
    "K5": ("Motion status", "5"),
    "#X5$": (INDEX, "X5$"),
    "U61": ("Initialisation", "U"),
    "*": ("Breaking into a locked interface", "*"),
    "X$Y$": (INDEX, "$"),
    "X+-5$": (INDEX, "-"),
    "X5+$": (INDEX, "+"),
    ":X5:,:$": (SWITCHING, ","),
    "=2,1$": ("Repeating parts of a sequence", "="),
    "A$": ("Aborting a run-mode move in a sequence", "A"),
    ":^5X100:$": ("Acceleration rate", "^"),
    ":X100:>2:$": ("Speed", ">"),
    ":X100:<2:$": ("Start/stop speed", "<"),
    ":X100:D2:$": ("Inter-character delay", "D"),
    "S1X100$": (COMBINING, "X"),
    "R1S2$": (COMBINING, "S"),
    "S1P2$": (COMBINING, "P"),
    "L1H2X5$": (COMBINING, "H"),
    "@X5$": ("Speed", "X"),
    "HX5$": (COMBINING, "X"),
    ":X100:=2:$": ("Repeating parts of a sequence", "2"),
    ">5": ("Speed", "5"),
    "<41": ("Start/stop speed", "41"),
    "^501": ("Acceleration rate", "501"),
    "D26": ("Inter-character delay", "26"),
    "@100000": ("Speed", "100000"),
    "B+256": ("Backlash correction", "+256"),
    "P4,100$": (SWITCHING, "100"),
    "P6$": (SWITCHING, "6"),
    "S16$": (SWITCHING, "16"),
    "H4X5$": (COMBINING, "4"),
    "X1000000000$": (INDEX, "1000000000"),
    "Y1 X5 Y2$": (INDEX, "Y2"),
    "X5GG$": (RUN, "G"),
    "G$": (RUN, "G"),
    "BX5$": ("Backlash correction", "B"),
    "/Y5$": ("Linear interpolation mode", "/"),
    "H1S1$": (COMBINING, "H"),
    "X5/$": ("Linear interpolation mode", "X5/"),
    ":Y5:X5/:$": ("Linear interpolation mode", "X5/"),
    "X5GB$": ("Backlash correction", "X5GB"),
    ":X5%:$": ("Controller intervention in a sequence", "X5%"),
    ":X5::Y:$": (SEQUENCES, ":"),
    ":X5:::$": (SEQUENCES, ":"),
    ":::$": (SEQUENCES, ":"),
    ":X5:=2,3:$": ("Repeating parts of a sequence", "=2,3"),
    ":" + "X:" * 63 + "Y5:$": (SEQUENCES, "Y5:"),
    "@25001": ("Speed", "@"),
    ":X100@26000:$": ("Speed", "@"),
    "X5 >4@4001$": ("Speed", "@"),
    "X70000/Y5$": ("Constraints in linear interpolation mode", "X"),
}


@pytest.mark.parametrize("line", WRONG)
def test_the_chapter_and_the_characters_concerned(line):
    (said,) = check(line)
    marked = line[said.column - 1 : said.end[1] - 1]
    assert (said.chapter, marked) == WRONG[line] and said.line == said.end[0] == 1


@pytest.mark.parametrize("line", [":X100", ":X5:", ":X5:Y"])
def test_the_end_that_a_sequence_lacks_is_missing_behind_it(line):
    (said,) = check(line)
    assert (said.chapter, said.column, said.end) == (SEQUENCES, len(line) + 1, (1, len(line) + 2))


@pytest.mark.parametrize(("line", "columns"), [
    ("X1?Y2!$", [3, 6]), ("@X5 ^Y5$", [2, 6]), (">5<0^501", [2, 4, 6]), ("X5E Y3 K$", [3, 8]), (":E5:X?:$", [2, 6])
])  # fmt: skip
def test_each_mistake_is_reported_once(line, columns):
    """The number after a wrong command is not a second problem."""
    assert [said.column for said in check(line)] == columns


@pytest.mark.parametrize(("line", "message"), [
    ("5X$", "5 belongs to no command"),
    (":X5:7Y:$", "7 belongs to no command"),
    ("G20$", "20 belongs to no command: G (run mode) takes no number"),
    ("mm10", "unknown characters 'mm'"),
    ("x10$", "unknown character 'x': commands are upper case"),
    ("xq$", "unknown characters 'xq': commands are upper case"),
    (":X5:>2:$", "> (select speed range) is not allowed in a sequence"),
    ("=1,1$", "= (repeat) is not allowed in a direct message"),
    ("K5", "K (motion status) must be the only command in its message"),
    ("X5:$", ": (sequence divider) is not valid here")])  # fmt: skip
def test_messages_about_lost_numbers(line, message):
    """The message names the parameters of the command before the number, if there is one."""
    assert check(line)[0].message == message
