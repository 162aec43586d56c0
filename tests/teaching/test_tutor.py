"""The tutor: comments, reasons and explanations, compared with the behaviour of the controller."""

import pytest

from axistwin import Bench
from axistwin.bench import host_of
from axistwin.ui.teaching.tutor import Tutor


class Learner:
    def __init__(self, model: str, **options) -> None:
        self.bench = Bench()
        self.controller = self.bench.add(model, **options)
        self.tutor = Tutor(self.controller)
        self.bench.run(1.5)

    def initialise(self) -> "Learner":
        with host_of(self.controller) as host:
            for act in self.tutor.initialisation():
                if hasattr(act, "data"):
                    host.write(act.data)
                else:
                    self.bench.clock.run_to(self.bench.now + act.ns)
        return self

    def type(self, line: str) -> tuple[list[str], list[str]]:
        """Send a line; return the tutor's comments on the line and on the answers."""
        language, answers = self.controller.product.language, []
        data = language.read(line) if language is not None else f"{line}\r".encode()
        with host_of(self.controller) as host:
            unsubscribe = host.subscribe_received(lambda reply: answers.extend(self.tutor.received(reply)))
            comments = self.tutor.sending(data)
            host.write(data)
            self.bench.run(3)
            unsubscribe()
        return comments, answers


@pytest.mark.parametrize(("model", "line", "comment"), [
    ("if1", "x100", "refused: unknown character 'x'"), ("if1", "X100", "nothing moves without $"),
    ("if1", "S2", "note: without $ at its end this message starts nothing"),
    ("1811", "33 00 00 61 A8", "refused: ignored: 31"), ("smartmotor", "FOO", "refused: unknown command FOO")
])  # fmt: skip
def test_comments_about_a_line(model, line, comment):
    learner = Learner(model).initialise()
    comments, _ = learner.type(line)
    assert comments[0].startswith(comment)
    assert learner.controller.axes[learner.controller.product.axes[0]].position == 0
    assert len(learner.type(line)[0]) == 1, "the explanation of a code is given once"


@pytest.mark.parametrize(("model", "lines", "answer"), [
    ("if1", ["x", "F"], "8 data fault"), ("if1", ["K"], "at rest, no fault"), ("if1", ["Q"], "0: at rest"),
    ("if1", ["E"], "clear for new commands"), ("if1", ["I"], "no current flows in 8 input1, 64 input2, 128 input3"),
    ("if1", ["X40$", "N"], "steps since the last index or run began: 40 steps"),
    ("1811", ["88"], "HOME home switch active"), ("smartmotor", ["RP"], "position: 0 counts"),
    ("smartmotor", ["RBo"], "motor off: yes"), ("smartmotor", ["RTEMP"], "temperature: 25 °C"),
    ("smartmotor", ["RCLK"], "sample counter")])  # fmt: skip
def test_comments_about_an_answer(model, lines, answer):
    learner = Learner(model).initialise()
    assert [learner.type(line) for line in lines][-1][1][0].startswith(answer)


def first_reason(learner: Learner) -> str:
    return learner.tutor.why()[0]


def test_why_nothing_moves_in_an_if1():
    learner = Learner("if1")
    assert first_reason(learner).startswith("the baud rate is not known yet")
    assert learner.type("X100$")[0] == [first_reason(learner)]
    learner = Learner("if1").initialise()
    assert first_reason(learner).startswith("a move is possible")
    learner.controller.pins["limit_plus"].drive(False)
    learner.type("X-100$")
    assert first_reason(learner).startswith("the plus limit is open")
    learner.controller.pins["limit_plus"].release()
    assert "has not been read (64 limit" in first_reason(learner)
    learner.type("K")
    learner.type("[")
    assert first_reason(learner) == "communication is locked by [: type  ]"
    learner.controller.pins["estop"].drive(False)
    assert [reason.partition(" (")[0] for reason in learner.tutor.why()] == [
        "the emergency stop is open", "communication is locked by [: type  ]",
    ]  # fmt: skip
    learner.controller.power(False)
    assert first_reason(learner).startswith("the power is off")


@pytest.mark.parametrize(("line", "driven", "reason"), [
    ("H13X300$", (), "the move waits for input1 high"), ("H13X300$", ("input1",), "the move waits for input3 high"),
    (":X10:H2L1X20:=0,1:$", ("input1",), "step 2 of the sequence waits for input2 high"),
    (":X10:H2L1X20:=0,1:$", ("input1", "input2"), "step 2 of the sequence waits for input1 low")])  # fmt: skip
def test_an_if1_tells_the_input_for_which_it_waits(line, driven, reason):
    learner = Learner("if1").initialise()
    for name in driven:
        learner.controller.pins[name].drive(True)
    learner.type(line)
    learner.bench.run(1.0)
    pin, level = reason.split()[-2:]
    assert learner.tutor.why() == [f"{reason}: type  :drive {pin} {level}"]
    assert learner.controller.hint.startswith(f"{reason}: ! {pin} {level} in a program")
    learner.controller.pins[pin].drive(level == "high")
    learner.bench.run(0.02)
    assert not learner.controller.hint.startswith(reason)


def a_locked_if2() -> Learner:
    """Return an IF2 with a stored sequence that begins at power-up and waits for input 1, and a 20 mm slide."""
    learner = Learner("if2", wiring="3-wire", X={"limits": (-50, 2000)}).initialise()
    for line in (":H1X1500@1000:X-@1000:=0,1:$", "["):
        learner.type(line)
    return learner


def test_a_locked_if2_that_waits_for_an_input_is_not_unlocked():
    assert a_locked_if2().tutor.why() == ["step 1 of the sequence waits for input1 high: type  :drive input1 high"]


@pytest.mark.parametrize("again", [(), ("[",)])
def test_the_unlocked_sequence_is_lost_unless_it_is_locked_again(again):
    learner = a_locked_if2()
    for line in ("]", *again):
        learner.type(line)
    for on in (False, True):
        learner.controller.power(on)
        learner.bench.run(2)
    assert bool(learner.controller.programs["sequence"].lines) is bool(again)


def test_why_nothing_moves_in_a_smartmotor():
    learner = Learner("smartmotor")
    reasons = learner.tutor.why()
    assert [reason.partition("type  ")[2] for reason in reasons] == ["UCI UDI ZS", "A=100", "V=100000"]
    for reason in reasons:
        learner.type(reason.partition("type  ")[2])
    assert first_reason(learner).startswith("a move is possible")
    learner.type("P=500 G")
    assert learner.controller.axes["shaft"].position == 500


def test_a_motor_that_is_asleep():
    learner = Learner("smartmotor")
    learner.type("SLEEP")
    asleep = "asleep, so that it ignores all commands but WAKE: type  WAKE"
    assert learner.type("RP") == ([asleep], []) and learner.tutor.why() == learner.tutor.next() == [asleep]
    assert learner.type("WAKE") == ([], []) and learner.type("RP") == ([], ["position: 0 counts"])
    learner.type("SLEEP")
    learner.initialise()
    assert learner.type("RP") == ([], ["position: 0 counts"])


@pytest.mark.parametrize("model", ["if1", "1811", "smartmotor"])
def test_every_suggestion_is_accepted(model):
    learner = Learner(model).initialise()
    for line, _ in learner.tutor.guide.suggestions:
        assert learner.type(line)[0] == [], line


@pytest.mark.parametrize(("model", "words", "meaning"), [
    ("smartmotor", "1670", "    512  Bp  plus limit"), ("if1", "8", "answer to F: 8 data fault"),
    ("if1", "X100@300$", "@  speed data"),
    ("if1", "K", "answer: 0 at rest, no fault; or the sum of 1 in motion; 2 at programmed speed"),
    ("if1", "F", "answer: 0 no communication fault; or the sum of 1 parity fault"),
    ("if1", "I", "without current: 1 estop"), ("if1", "E", "answer: C clear"),
    ("if1", "U61", "U61: 8 data bits, no parity, 2 stop bits"),
    ("if1", "U16", "U16: 7 data bits, even parity, 1 stop bit, echo"), ("if1", ":X400:=2,1:$", "0: endlessly"),
    ("if1", "dp301", "The highest speeds of the speed ranges"), ("if1", "estop", "estop: emergency stop, now high"),
    ("if1", "12345678", "no meaning known for '12345678'"),
    ("1811", "83 00 00 00 00 61 A8", "  00 00 00 00 61 A8: position 25000 pulses"),
    ("1811", "go_relatve", "did you mean go_relative"), ("1811", "31", "31  default velocity and acceleration"),
    ("smartmotor", "GOSUB5", "GOSUBn  call subroutine"), ("smartmotor", "A=100 G", "G  go")])  # fmt: skip
def test_explanations(model, words, meaning):
    assert any(meaning in line for line in Learner(model).initialise().tutor.explain(words))
