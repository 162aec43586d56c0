"""Hover, completion and symbols for every kind of text."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.bench import codec_of, product
from axistwin.controllers.compumotor.checker.program import acceptable
from axistwin.controllers.smartmotor.language.program import OPENS, digits, word
from axistwin.scenes.diagnostics.checking import read_acts, sessions
from axistwin.ui.editor.compumotor import Commands
from axistwin.ui.editor.digiplan import CommandLines
from axistwin.ui.editor.scene import Scenes
from axistwin.ui.editor.smartmotor import SourceEditing, outline, parsed
from axistwin.ui.editor.talk import Conversations

IF1, BOARD, MOTOR, TALK, SCENE = CommandLines(), Commands(product("1811")), SourceEditing(), Conversations(), Scenes()
BOARD_CODEC = codec_of(BOARD.made)
ALL = {"if1": IF1, "181x": BOARD, "sms": MOTOR, "talk": TALK, "toml": SCENE}


def place(text):
    """Return the lines of a text, and the line and index of the `|` in the text."""
    before, _, behind = text.partition("|")
    line = before.count("\n") + 1
    return (before + behind).split("\n"), line, len(before) - before.rfind("\n") - 1


def offered(editing, text):
    return [item.label for item in editing.complete(*place(text))]


def told(editing, text):
    found = editing.hover(*place(text))
    return None if found is None else found.text.split("\n\n")


# Command lines of an IF1


@pytest.mark.parametrize(("text", "there", "not_there"), [
    ("|", "XYZ:@$#KE[", "=(U"), ("X100|", "@YGBSRP$", "EK+=A:"), ("X|", "+-@GB", "XE"), ("X100S1|", "$R#", "XPH%"),
    (":X100|", ":@SR", "A=<>^"), (":H1|", "XA=:", ">"), ("P4|", ",$", "XS"), ("E|", "", "X$")])  # fmt: skip
def test_the_characters_that_may_follow(text, there, not_there):
    found = offered(IF1, text)
    assert set(there) <= set(found) and not set(not_there) & set(found)


def test_no_completions_in_comments_and_times():
    assert offered(IF1, "X100$ ; the |") == [] and offered(IF1, "+1|") == []


def test_a_number_has_the_meaning_of_its_command():
    assert told(IF1, "X100 @ 5|00$")[:2] == ["**@** speed data", "`@ speed`"] and told(IF1, "; X|") is None


def test_the_steps_of_a_sequence():
    (sequence,) = IF1.symbols(["; one", ":X100:Y@50G:$"])
    assert (sequence.name, sequence.begin, sequence.end) == ("sequence", (2, 1), (2, 14))
    assert [(step.name, step.detail, step.begin) for step in sequence.children] == [
        ("step 1", "X100", (2, 2)), ("step 2", "Y@50G", (2, 7)),
    ]  # fmt: skip


# Commands of an 1811


def test_only_valid_commands_are_completed():
    assert "go_relative" in offered(BOARD, "|") and "wait_seconds" not in offered(BOARD, "|")
    assert "wait_seconds" in offered(BOARD, "D9 01\n|") and "stop" not in offered(BOARD, "D9 01\nst|")
    assert "distance_time_data" in offered(BOARD, "53 01 04 00 00 00 00 00 02\n|")
    assert "perform_move" not in offered(BOARD, "53 01 04 00 00 00 00 00 02\n|")


COMMAND = st.sampled_from(
    ("D9 01", "define_sequence 2", "D8", "51 01 01", "53 01 04 00 00 00 00 00 02", "50", "33 00 00 00 05", "stop",
     "E3 01 00 05", "! power off", "+1", "; D9 01", "D9", "FE", "go_relative x", "40 01", "41 01")
)  # fmt: skip


@settings(max_examples=50)
@given(st.lists(COMMAND, max_size=12))
def test_modal_commands_decide_which_commands_the_board_accepts(lines):
    acts, _ = read_acts(lines, ".181x", BOARD_CODEC)
    listed = [session for host in sessions(acts, lines, ".181x", BOARD_CODEC) for session in host]
    wanted = [command.opcode for command in acceptable(BOARD.made.commands, listed[-1])]
    found = [BOARD.names[item.label].opcode for item in BOARD.complete([*lines, ""], len(lines) + 1, 0)]
    assert found == wanted


def test_completion_reads_only_modal_commands_of_a_long_program():
    read = []

    class Counted:
        def placed(self, text):
            read.append(text)
            return BOARD.made.language.placed(text)

        def read(self, text):
            return bytes(each.byte for each in self.placed(text))

    made = BOARD.made._replace(language=Counted())
    Commands(made).complete(["33 00 00 00 05", "go_relative 5"] * 1000 + ["D9 01", ""], 2002, 0)
    assert set(read) == {"D9 01"}


def test_a_board_in_a_conversation_accepts_commands_by_its_own_mode():
    lines = "; model: 1811\nleft: > D9 01\nright: > 33 00 00 00 05\n"
    assert "wait_seconds" in offered(TALK, f"{lines}left: > |")
    assert "wait_seconds" not in offered(TALK, f"{lines}right: > |")


def test_values_of_a_parameter():
    assert {"on", "off"} <= set(offered(BOARD, "go_on |"))
    assert offered(BOARD, "default_velocity_and_acceleration |")[:2] == ["00", "01"]
    assert offered(BOARD, "go_relative |") == []


def test_the_parameter_at_the_cursor_is_emphasised():
    assert "- **distance" in told(BOARD, "go_relative 25|000")[2]
    assert "- **distance" in told(BOARD, "33 00 00 61 A|8")[2]
    assert told(BOARD, "go_r|elative 25000")[0] == "**33** go relative" and told(BOARD, "nonsense|") is None


def test_sequences_and_moves():
    found = BOARD.symbols(["define_relative_move 1 00 1 1 5", "D9 02", "40 01", "83", "D8", "D9 03"])
    assert [(symbol.name, len(symbol.children)) for symbol in found] == [
        ("move 1", 0), ("sequence 02", 2), ("sequence 03", 0),
    ]  # fmt: skip


# A SmartMotor's source


def test_parts_of_a_block_are_completed_only_inside_the_block():
    assert {"ELSE", "ENDIF", "ELSEIF"} <= set(offered(MOTOR, "IF a b=1 |"))
    assert not {"ELSE", "ENDIF", "LOOP", "BREAK"} & set(offered(MOTOR, "IF a b=1 ENDIF |"))
    assert {"LOOP", "BREAK"} <= set(offered(MOTOR, "WHILE 1\n  |"))
    assert "ENDIF" not in offered(MOTOR, "IF a\nWHILE 1\n|")


def test_commands_that_a_program_cannot_contain_are_not_completed():
    found = offered(MOTOR, "|")
    assert "GOSUBn" in found and not {"LOAD", "KGON", "MD50"} & set(found)


def test_labels_variables_and_values():
    assert offered(MOTOR, "C5 RETURN C12 RETURN\nGOSUB|") == ["GOSUB5", "GOSUB12"]
    found = offered(MOTOR, "aa=1\nb=aa+|")
    assert {"@P", "CLK", "aa", "b", "ab["} <= set(found) and "MP" not in found
    assert {"UAI", "@P"} <= set(offered(MOTOR, "IF |")) and offered(MOTOR, "a=1 'not |") == []


STATEMENT = st.sampled_from(
    ("a=1", "aa=bb+ccc", "C5", "C007", "C1000", "C5'x", "IF a==b", "ENDIF", "ELSE", "WHILE @P>z", "LOOP",
     "SWITCH a", "CASE 3", "ENDS", "'IF a C5", 'PRINT("IF a C6 q",b,#13)', "aw[a]=7", "al[0] 1 2 3.", "b=Ba|UAI", "RB",
     "GOSUB5", "END", "t=CTR", "x=(y*z)", "\t")
)  # fmt: skip


@given(st.lists(STATEMENT, max_size=8).map(" ".join))
def test_the_outline_of_a_line_agrees_with_its_statements(line):
    """The reference reads the statements.  Only IF, WHILE, SWITCH and their ends are parts."""
    statements, found = parsed(line), outline(line)
    assert found.labels == tuple((digits(each), begin + 1) for each, begin, _ in statements if word(each) == "Cn")
    words = [word(each) for each, _, _ in statements]
    assert list(found.parts) == [each for each in words if each in OPENS or each in OPENS.values()]
    computed = {name for each, _, _ in statements for part in each.computed for name in part.names}
    assert {name for name in computed if name.islower()} <= found.variables
    assert found.variables <= set("abtxyzq") | {"aa", "bb", "ccc"}


def test_completion_reads_no_statement_of_a_long_source_but_those_of_its_own_line():
    lines = [f"a=a+{number} IF a>{number} G ENDIF" for number in range(1000)]
    parsed.cache_clear()
    assert "ENDIF" not in [item.label for item in MOTOR.complete([*lines, "aa=1 "], 1001, 5)]
    assert parsed.cache_info().misses == 1
    outline.cache_clear()
    MOTOR.complete([*lines, "aa=1 "], 1001, 5)
    MOTOR.complete([*lines, "aa=12 "], 1001, 6)
    assert outline.cache_info().misses == len(lines) + 2


def test_hover_over_commands_values_and_labels():
    assert told(MOTOR, "A|=100")[0] == "**A=** acceleration"
    assert told(MOTOR, "a=@P|E+1")[0] == "**@PE** position error" and told(MOTOR, "a=@P|E+1")[1] == "in counts"
    assert told(MOTOR, "GOS|UB5\nEND\nC5 RETURN")[0] == "C5 is on line 3"
    assert told(MOTOR, "GOS|UB6")[0] == "There is no label C6" and told(MOTOR, "'A|=1") is None


def test_labels_with_their_comments():
    found = MOTOR.symbols(["a=1", "C1 'faults", "RETURNF", "C5 RETURN"])
    assert [(s.name, s.detail, s.begin, s.end) for s in found] == [
        ("C1", "faults", (2, 1), (4, 1)), ("C5", "", (4, 1), (4, 10)),
    ]  # fmt: skip


# Conversations

HEAD = "; model: {}\n"


def test_pins_and_axes_in_a_conversation():
    acts = offered(TALK, HEAD.format("if1") + "! |")
    assert {"input1", "estop", "power", "X.jam", "Z.load", "dtr"} <= set(acts) and "position" not in " ".join(acts)
    assert {"X.position", "clock", "output5"} <= set(offered(TALK, HEAD.format("if1") + "left: = X|"))
    assert {"A", "shaft.position", "ambient"} <= set(offered(TALK, HEAD.format("smartmotor") + "= |"))
    assert offered(TALK, HEAD.format("if1") + "! input1 |") == ["high", "on", "low", "off", "release"]


def test_data_of_the_host_are_in_the_language_of_the_family():
    assert "@" in offered(TALK, HEAD.format("if1") + "> U61\\rX100|")
    assert "U" not in offered(TALK, HEAD.format("if1") + "> U61\\rX100|")
    assert "go_relative" in offered(TALK, HEAD.format("1811") + "> |")
    assert "LOAD" in offered(TALK, HEAD.format("smartmotor") + "> |")
    assert "IF" not in offered(TALK, HEAD.format("smartmotor") + "> |")
    assert told(TALK, HEAD.format("if1") + "> K\\r@5|00\\r")[0] == "**@** speed data"
    assert told(TALK, HEAD.format("smartmotor") + "> ZS V=1|0\\r")[0] == "**V=** velocity"
    assert told(TALK, HEAD.format("1811") + "> 3|3 00 00 61 A8")[0] == "**33** go relative"


def test_marks_and_headers_are_completed_and_explained():
    assert offered(TALK, "|") == [">", "<", "+", "!", "=", ";"]
    assert offered(TALK, "; |") == ["model: ", "options: ", "line: ", "patience: "]
    assert "1811" in offered(TALK, "; model: |") and told(TALK, "|> X\\r") == ["**>** the host transmits"]
    assert told(TALK, HEAD.format("if1") + "! inp|ut1 high")[0].startswith("**input1** terminal")


def test_sequences_in_a_conversation():
    (sequence,) = TALK.symbols([HEAD.format("if1").strip(), "> (U61\\r:X1:Y2:$\\r"])
    assert [step.begin for step in sequence.children] == [(2, 10), (2, 13)]


# Scenes

FILE = '[[controller]]\nmodel = "if1"\nname = "left"\n'


def test_tables_and_keys_of_a_scene():
    assert {"controller", "wire", "chain"} <= set(offered(SCENE, "[[|"))
    assert {"model", "name", "options", "axes"} <= set(offered(SCENE, "[[controller]]\n|"))
    assert {"from", "to", "invert"} <= set(offered(SCENE, FILE + "[[wire]]\n|"))
    assert {"wiring", "busy"} <= set(offered(SCENE, FILE + "options.|"))
    assert offered(SCENE, FILE + "axes.|") == ["X", "Y", "Z"]
    assert {"limits", "encoder"} <= set(offered(SCENE, FILE + "axes.X.|"))
    assert {"limits", "encoder"} <= set(offered(SCENE, FILE + "[controller.axes.X]\n|"))
    assert offered(SCENE, FILE + "# |") == []


def test_keys_of_a_servo_axis():
    """The keys differ from those of an axis with a stepper motor."""
    motor = '[[controller]]\nmodel = "smartmotor"\n'
    assert offered(SCENE, motor + "axes.shaft.|") == ["limits", "motor", "load", "units"]
    assert {"model", "kp", "supply_voltage_v"} <= set(offered(SCENE, motor + "[controller.axes.shaft.motor]\n|"))
    assert "inertia_kg_m2" in offered(SCENE, motor + "axes.shaft.load.|")


def test_values_of_a_scene():
    assert '"1811"' in offered(SCENE, "[[controller]]\nmodel = |")
    assert "smartmotor" in offered(SCENE, '[[controller]]\nmodel = "|')
    assert '"left.output1"' in offered(SCENE, FILE + "[[wire]]\nfrom = |")
    assert offered(SCENE, FILE + "[[wire]]\ninvert = |") == ["true", "false"]


def test_words_of_a_fault_a_master_and_a_motor():
    assert '"jam"' in offered(SCENE, FILE + "[[fault]]\nkind = |")
    assert offered(SCENE, FILE + '[[fault]]\nkind = "jam"\non = |') == ['"left.X"', '"left.Y"', '"left.Z"']
    assert offered(SCENE, FILE + '[[fault]]\non = |\nkind = "lose"\n') == ['"left.serial"']
    assert {"left", "left.X", "left.input1"} <= set(offered(SCENE, FILE + '[[fault]]\non = "|'))
    assert offered(SCENE, FILE + "[[fault]]\nway = |") == ['"to"', '"from"', '"both"']
    assert offered(SCENE, FILE + "[[fault]]\nside = |") == ['"minus"', '"plus"', '"both"']
    assert offered(SCENE, FILE + "[[script]]\non = |") == ['"left"']
    motor = '[[controller]]\nmodel = "smartmotor"\n'
    assert '"left.X"' in offered(SCENE, motor + "master = |\n" + FILE)
    assert '"frame23"' in offered(SCENE, motor + "axes.shaft.motor = |")
    assert '"frame23"' in offered(SCENE, motor + "axes.shaft.motor.model = |")


def test_hover_over_keys_of_a_scene():
    assert told(SCENE, "[[controller]]\nmo|del = 1")[0].startswith("**model** ")
    assert "beyond which" in told(SCENE, FILE + "axes.X.limi|ts = [0, 1]")[0]
    assert "host's DTR" in told(SCENE, FILE + 'options.wir|ing = "3-wire"')[0]
    assert "Controllers" in told(SCENE, "[[contr|oller]]")[0]


def test_the_tables_of_a_scene_are_its_symbols():
    found = SCENE.symbols([*FILE.splitlines(), "[[wire]]", 'from = "left.output1"'])
    assert [(s.name, s.detail, s.begin, s.end) for s in found] == [
        ("left", "controller", (1, 1), (3, 14)), ("wire", "wire", (4, 1), (5, 22)),
    ]  # fmt: skip


@pytest.mark.parametrize("kind", ALL)
@settings(max_examples=50)
@given(
    text=st.text(st.sampled_from("XYG$:;>!=+<[]\"'. \\nr{}()?@#0123456789abcCIFé\n\t"), max_size=40),
    where=st.integers(0, 40),
    head=st.sampled_from(["", "; model: if1\n", "; model: 1811\n", "; model: smartmotor\n", FILE]),
)
def test_any_text_can_be_edited(kind, text, where, head):
    at = min(where, len(text))
    here = place(head + text[:at] + "|" + text[at:].replace("|", ""))
    ALL[kind].hover(*here)
    ALL[kind].complete(*here)
    ALL[kind].symbols(here[0])
