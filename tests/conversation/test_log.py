"""The list of a conversation: messages, acts and faults in order, with the notes below them."""

from pathlib import Path

from axistwin import Bench, Session
from axistwin.scenes.scene import Scene
from axistwin.ui.conversation import notes
from axistwin.ui.conversation.conversation import Conversation
from axistwin.ui.conversation.log import KEPT, MOST_ENTRIES, Log

EXAMPLES = Path(__file__).parents[2] / "examples"


def session_of(model, **options):
    bench = Bench()
    bench.add(model, **options)
    return Session(lambda: bench)


def said(log, name, last=1000):
    return [f"{each.who} {each.text}" for each in log.since(name, 0)[1][-last:]]


def test_a_serial_line_with_control_characters_by_name():
    session = session_of("if1")
    log = Log(session)
    session.bench.run(1.5)
    session.bench["if1"].serial.write(b"(")
    session.bench.run(0.1)
    assert said(log, "if1") == ["> (", "< U<CR>"]
    first = log.since("if1", 0)[1][0].shown()
    assert (first["time"], first["parts"]) == ("1.500000", [("(", "")])


def test_carriage_return_ends_a_message_and_line_feed_belongs_to_it():
    session = session_of("smartmotor")
    log = Log(session)
    session.bench.run(1.0)
    session.bench["smartmotor"].serial.write(b"a=1 Ra Ra ")
    session.bench.run(0.2)
    assert said(log, "smartmotor", 3) == ["> a=1 Ra Ra ", "< 1<CR>", "< 1<CR>"]


def test_a_break_of_the_host_is_a_word():
    session = session_of("if1")
    log = Log(session)
    session.bench.run(1.5)
    session.bench["if1"].serial.send_break(0.25)
    assert said(log, "if1") == ["> <BREAK 0.25 s>"]


def test_opcodes_of_a_board_in_words():
    session = session_of("1811")
    log = Log(session)
    session.bench.run(1.0)
    session.say("1811", b"\x83")
    session.bench.run(0.1)
    asked, answered = log.since("1811", 0)[1]
    assert asked.parts == [("83", ""), ("  position from absolute zero", "quiet")]
    assert answered.text == "83  position from absolute zero: position 0 pulses"


def test_a_page_gets_what_it_has_not_seen_and_memory_is_bounded():
    session = session_of("if1", line="instant")
    log, port = Log(session), session.bench["if1"].serial
    session.bench.run(1.5)
    port.write(b"(")
    count, new = log.since("if1", 0)
    assert [each.text for each in new] == ["("]
    session.bench.run(0.1)
    more, new = log.since("if1", count)
    assert [each.text for each in new] == ["U<CR>"]
    port.write(b"U")
    session.bench.run(0.01)
    port.write(b"6")
    last, new = log.since("if1", more)
    assert [(each.number, each.text) for each in new] == [(3, "U6")]
    assert log.since("if1", last) == (last, [])
    for _ in range(2 * KEPT):
        port.write(b"\r")
    assert len(log._events) == KEPT
    assert len(log.since("if1", last)[1]) == MOST_ENTRIES


def test_another_bench_begins_anew():
    session = session_of("if1")
    log = Log(session)
    session.bench["if1"].serial.write(b"(")
    assert said(log, "if1") == ["> ("]
    before, other = log.generation, Bench()
    other.add("if1")
    log._attach(other)
    assert log.generation == before + 1 and log.since("if1", 0) == (0, [])


def test_power_buttons_and_faults_are_in_the_list():
    scene = Scene.load(EXAMPLES / "drill" / "scene.toml")
    session = Session(scene.build, None, scene=scene)
    log = Log(session)
    session.bench.run(20.15)
    session.do("table", "estop", "low")
    session.do("table", "estop", "high")
    session.do("table", "fault", "stuck input3 high")
    session.do("table", "mend", "all")
    session.do("table", "power", "off")
    session.do("table", "power", "on")
    assert [(f"{each.time_ns / 1e9:.2f}", f"{each.who} {each.text}") for each in log.since("table", 0)[1][6:]] == [
        ("6.00", "· Power off"), ("8.00", "· Power on"), ("11.00", "· Start pressed"),
        ("11.40", "· Start released"), ("20.15", "! Emergency stop pressed"), ("20.15", "· Emergency stop released"),
        ("20.15", "! Fault: stuck table.input3 level=high name=stuck"),
        ("20.15", "· End of fault: stuck"), ("20.15", "· Power off"), ("20.15", "· Power on"),
    ]  # fmt: skip


def test_alarms_have_the_names_of_the_front_panel():
    for model, pin, words in (("if1", "limit_plus", "Limit fault"), ("1811", "cw_limit", "Plus limit")):
        session = session_of(model)
        log = Log(session)
        session.bench.run(1.5)
        if model == "if1":
            session.bench["if1"].pins[pin].drive(False)
        else:
            for command in ("31 00 00 00 61 A8 00 03 D0 90", "34 00"):
                session.say(model, session.bench[model].product.language.read(command))
            session.bench.run(0.5)
            session.bench["1811"].pins[pin].drive(True)
            session.bench.run(0.5)
        assert said(log, model)[-1] == f"! {words}"


def test_notes_stand_below_the_line_and_the_answer_that_they_explain():
    session = session_of("smartmotor")
    conversation = Conversation(session)
    session.bench.run(1.0)
    conversation.say("smartmotor", b"RXYZ\r")
    conversation.say("smartmotor", b"RMODE\r")  # at the same time, and yet a line of its own
    session.bench.run(0.1)
    conversation.ask("smartmotor", "next")
    refused, asked, answer, question = conversation.log.since("smartmotor", 0)[1][-4:]
    assert refused.text == "RXYZ<CR>" and refused.notes[0].startswith("refused: ")
    assert (asked.text, asked.notes) == ("RMODE<CR>", [])
    assert answer.text.endswith("<CR>") and len(answer.notes) == 1
    assert question.text == "What next?" and question.notes[0].startswith("both limit inputs are active (Bp, Bm)")


def test_a_typed_line_waits_in_the_list_until_a_board_has_received_it():
    session = session_of("1811")
    conversation = Conversation(session)
    session.do("1811", "power", "off")
    conversation.say("1811", b"\x83")
    (_, line) = conversation.log.since("1811", 0)[1]
    assert (line.text, line.held, line.notes[0][:16]) == ("83  position from absolute zero", True, "the power is off")
    session.do("1811", "power", "on")
    session.bench.run(2)
    assert [each.who for each in conversation.log.since("1811", 0)[1]] == ["·", ">", "·", "<"]
    assert not line.held and line.time_ns > 0


def test_lines_to_type_are_marked_in_a_note():
    assert notes.parts("the baud rate is not known yet: type  (  and then  U61  (the data format), or  :init") == [
        ("the baud rate is not known yet: type ", ""), ("(", "line"), (" and then ", ""), ("U61", "line"),
        (" (the data format), or ", ""), (":init", "line"),
    ]  # fmt: skip
    assert notes.parts("type  X1000$   index X by 1000 steps") == [
        ("type ", ""), ("X1000$", "line"), (": index X by 1000 steps", "")]  # fmt: skip
    assert notes.parts("Sends  (  and  U61,  so that it accepts commands.") == [
        ("Sends ", ""), ("(", "line"), (" and ", ""), ("U61", "line"), (", so that it accepts commands.", ""),
    ]  # fmt: skip
    assert notes.parts("type  repeat 2 3,  D8") == [
        ("type ", ""), ("repeat 2 3", "line"), (", ", ""), ("D8", "line")]  # fmt: skip
    assert notes.parts("no line") == [("no line", "")]
