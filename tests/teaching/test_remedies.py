"""Each remedy leads out: whoever does literally what a text of the tutor or a hint says is then out of trouble.

A scene gets a controller into trouble, finds the text, takes the commands out of it, and does them and nothing else.
"""

import ast
import inspect
import re
from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import pytest

from axistwin.bench import action
from axistwin.scenes.reasons import compumotor, digiplan, remedies, smartmotor
from axistwin.scenes.reasons.reasons import Reasons
from axistwin.ui.teaching.lessons import course
from axistwin.ui.teaching.pupil import Pupil

from .test_lessons import solve
from .test_tutor import Learner

COMMAND = re.compile(r"(?P<word>type|send|and|then|or|,)  (?P<line>\S.*?)(?=  |, |: |$)")
"""A line to type, which a text marks by two blanks."""
SENT_FIRST = re.compile(r"send (?P<line>\S+(?: \d\d)?) first")
"""The line that a controller needs before one that it has ignored."""
BY_HAND = (
    (r"\bwait$", (":wait 1.5",)),
    ("free the shaft", (":drive shaft.jam off",)),
    (r"let it cool (from \d+ to \d+ °C|to 5 °C below TH)", (":drive ambient 25", ":wait 900")),
)
"""Work at the machine, which no command does: a piece of the text, and what the user does."""
WIRED = re.compile(r"(?P<pin>\w+) is wired: find what sets it (?P<level>high|low)")
MOST_STEPS = 12
SLIDE = {"limits": (-300, 2000)}


class Scene(NamedTuple):
    """A way into trouble, and a piece of the text that leads out."""

    model: str
    says: str
    lines: tuple[str, ...] = ()
    options: dict[str, object] = {}  # noqa: RUF012  # never changed
    initialised: bool = True


def choices(text: str) -> list[list[str]]:
    """Return the lines that a text tells the user to type; another list after each `or`."""
    found: list[list[str]] = [[]]
    for each in COMMAND.finditer(text):
        if each["word"] == "or":
            found.append([])
        found[-1].append(each["line"])
    return found if found != [[]] else [SENT_FIRST.findall(text)]


def by_hand(text: str, learner: Learner) -> Iterator[str]:
    for piece, lines in BY_HAND:
        if re.search(piece, text):
            yield from lines
    for found in WIRED.finditer(text):
        learner.controller.pins[found["pin"]].set(found["level"] == "low")


def perform(learner: Learner, line: str) -> list[str]:
    """Perform a line as the terminal does; return the tutor's comments on it."""
    if line == ":init":
        learner.initialise()
    elif line.startswith(":wired"):
        _, name, level = line.split()
        learner.controller.pins[name].set(level == "high")
        learner.controller.pins[name].wired = True
    elif line.startswith(":drive"):
        action(learner.controller, *line.split(" ", 2)[1:])()
        learner.bench.run(0.1)
    elif line.startswith(":"):
        solve(learner, line)
        learner.bench.run(0.1)
    else:
        return learner.type(line)[0]
    return []


def obey(learner: Learner, text: str, choice: int = 0) -> None:
    """Do literally what a text says.  Where it offers several ways, `choice` selects one."""
    lines = [*by_hand(text, learner), *choices(text)[choice]]
    assert lines or WIRED.search(text), f"nothing to do in: {text}"
    for line in lines:
        comments = perform(learner, line)
        assert not any(comment.startswith("refused") for comment in comments), (text, line, comments)


def arranged(scene: Scene) -> Learner:
    learner = Learner(scene.model, **scene.options)
    if scene.initialised and scene.model in ("if1", "if2"):
        learner.initialise()
    for line in scene.lines:
        perform(learner, line)
    return learner


def positions(learner: Learner) -> list[int]:
    return [axis.position for axis in learner.controller.axes.values()]


@cache
def followed(number: int, choice: int = 0) -> tuple[str, ...]:
    """Obey the tutor until a move is possible, and move; return everything that the tutor has said."""
    scene = SCENES[number]
    learner = arranged(scene)
    before, said = positions(learner), []
    for _ in range(MOST_STEPS):
        reason, *others = learner.tutor.why()
        said += [reason, *others]
        if reason.startswith("a move is possible") or reason.endswith("moving"):
            break
        assert learner.tutor.next() == [reason]
        obey(learner, reason, min(choice, len(choices(reason)) - 1))
    else:
        pytest.fail(f"{scene.says} does not lead out: {said}")
    learner.bench.run(1)
    for line in learner.tutor.next():
        if positions(learner) == before:
            obey(learner, line.partition("   ")[0])
    assert positions(learner) != before, (scene.says, said)
    return tuple(said)


DEFAULTS = "default_velocity_and_acceleration 00 25000 250000"
MOTOR = "UCI UDI ZS A=100 V=100000 MP"
AT_SWITCH = "ZS A=100 V=100000 MP"
FRAME23 = {"motor": "frame23"}
STORED = (":H1X1500@1000:X-@1000:=0,1:$", "[")
LIMITED = (*STORED, ":drive input1 high", ":wait 0.3", ":drive limit_plus low", ":wait 0.5",
           ":drive limit_plus release",
           ":drive input1 low", "K")  # fmt: skip
IF2 = {"wiring": "3-wire", "X": {"limits": (-50, 2000)}}

SCENES = (
    # Any family
    Scene("if1", "the power is off: type  :drive power on", (":drive power off",)),
    Scene("1811", "the power is off: type  :drive power on", (":drive fault power_cut",)),
    Scene("smartmotor", "the power is off: type  :drive power on", (":drive power off",)),
    # IF1 and IF2
    Scene("if1", "the self-test takes about a second: wait",
          (":drive power off", ":drive power on"), initialised=False),
    Scene("if1", "the baud rate is not known yet: type  (  and then  U61  (the data format), or  :init",
          initialised=False),
    Scene("if1", "the data format is not known yet: type  U61  (8 data bits, no parity), or  :init", ("(",),
          initialised=False),
    Scene("if1", "the emergency stop is open (PL3 terminal 1): type  :drive estop release  and then  K",
          (":drive estop low", "X100$")),
    Scene("if1", "only moves in the minus direction begin (PL3 terminal 2): type  :drive limit_plus release",
          (":drive limit_plus low", "X100$")),
    Scene("if1", "only moves in the plus direction begin (PL3 terminal 3): type  :drive limit_minus release",
          (":drive limit_minus low", ":drive limit_plus low", "X-100$")),
    Scene("if1", "X stands on the switch: move away in minus: type  K  and then  X-", ("X5000@2000$",), {"X": SLIDE}),
    Scene("if1", "Y stands on the switch: move away in plus: type  K  and then  Y", ("Y-5000@2000$",), {"Y": SLIDE}),
    Scene("if1", "limit_plus is wired: find what sets it low", (":wired limit_plus low", "X100$")),
    Scene("if1", "X stands on the switch: move away in minus: type  ]  and then  K  and then  X-",
          ("X2500@2000$", "["), {"X": SLIDE}),
    Scene("if1", "the drive of X reports a fault (PL4, or link 3): an injected fault holds x_fault: "
          "type  :drive mend all",
          (":drive fault drive_fault X", "X100$")),
    Scene("if1", "the drive of Y reports a fault (PL5, or link 4): type  :drive y_fault release",
          (":drive y_fault low", "Y100$")),
    Scene("if1", "a fault has not been read (32 emergency stop", (":drive estop low", ":drive estop release")),
    Scene("if1", "a message was refused, and F has not been read since (8 data fault", ("Q1!",)),
    Scene("if1", "the move waits for input1 high: type  :drive input1 high", ("H1X300$",)),
    Scene("if1", "an injected fault holds input1: type  :drive mend all",
          (":drive fault stuck input1 high", "L1X300$")),
    Scene("if1", "step 2 of the sequence waits for input2 low: type  :drive input2 low",
          (":drive input2 high", ":X10:L2X20:$")),
    Scene("if1", "communication is locked by [: type  ]", ("[",)),
    Scene("if1", "a locked interface is reset only by its power, not by K: "
          "type  :drive power off  and  :drive power on",
          ("[", ":drive estop low", ":drive estop release")),
    Scene("if1", "DSR or CTS is off, so the interface does not answer: type  :drive dtr on  and  :drive rts on",
          (":drive dtr off",)),
    Scene("if1", "DSR or CTS is off, so the interface does not answer: an injected fault holds cts",
          (":drive fault handshake cts low",)),
    Scene("if2", "and only a power-up starts it: type  :drive power off  and  :drive power on: "
          "it begins again, and waits:",
          LIMITED, IF2),
    Scene("if2", "on: send  (  and  U61,  and it begins again", LIMITED, {"X": {"limits": (-50, 2000)}}),
    Scene("if2", "communication is locked by [, which keeps the sequence without power: type  ]  to give up the stored",
          LIMITED, IF2),
    Scene("if2", "its last step has ended the stored sequence at step 1, and only a power-up starts it",
          (":X300:$", "["), IF2),
    Scene("if1", "the host sends at 1200 baud, not at 9600: type  :drive line 9600 8N2",
          (":drive line 1200 8N2", "X9$")),
    # 1810 and 1811
    Scene("1811", "the board has failed (status bit 5): type  :drive power off  and  :drive power on",
          ("FF", ":wait 60")),
    Scene("1811", "31h has not been given: type  default_velocity_and_acceleration"),
    Scene("1811", "the motor is shut down (12h): type  remote_power_shutdown off",
          (DEFAULTS, "remote_power_shutdown on")),
    Scene("1811", "the motor is shut down by its input (13h): type  :drive shutdown_in release",
          (DEFAULTS, "13 01", ":drive shutdown_in low")),
    Scene("1811", "the plus limit is active: only moves away from it begin: type  :drive cw_limit release",
          (DEFAULTS, ":drive cw_limit high", ":drive ccw_limit high")),
    Scene("1811", "the slide stands on the switch: move away in minus: type  go_relative -",
          (DEFAULTS, "go_relative 5000"), {"motor": SLIDE}),
    Scene("1811", "the slide stands on the switch: move away in plus: type  go_relative ",
          (DEFAULTS, "go_relative -5000"), {"motor": SLIDE}),
    Scene("1811", "the slide stands on the switch: move away in minus: type  go_relative -",
          (DEFAULTS, "14 01", "go_relative 5000"), {"motor": SLIDE}),
    Scene("1811", "the joystick controls the motor (11h): type  disable_joystick", (DEFAULTS, "enable_joystick")),
    Scene("1811", "the board is in streaming mode 51h: type  indexer_mode", (DEFAULTS, "51 01 01 00 00 00 00")),
    Scene("1811", "the board stores commands in a sequence (D9h): type  end_sequence_definition",
          (DEFAULTS, "remote_power_shutdown on", "D9 01")),
    Scene("1811", "sequence 1 is being performed, and stands at its command 2: type  kill_sequence",
          (DEFAULTS, "D9 01", "29 00 00 00 01", "2C 02 00", "33 00 00 01 00", "D8", "perform_sequence 1")),
    Scene("1811", "the last line was ignored: position maintenance is on: send 18 00 first",
          (DEFAULTS, "18 01", "go_relative 500")),
    # SmartMotor
    Scene("smartmotor", "the host sends at 9600 baud, not at 19200: type  :drive line 19200 8N1",
          (MOTOR, "BAUD19200", "P=300 G")),
    Scene("smartmotor", "both limit inputs are active (Bp, Bm): "
          "wire pins C and D to ground, or make them inputs, and clear the fault: type  UCI UDI ZS", ("G",)),
    Scene("smartmotor", "the plus limit is active (Bp): "
          "wire pin C to ground, or make it an input, and clear the fault: type  UCI ZS", ("UDI ZS", "G")),
    Scene("smartmotor", "the plus limit is active (Bp): "
          "wire pin C to ground, or make it an input, and clear the fault: type  UCI ZS",
          ("SLN=-900 SLP=900 SLE", "G")),
    Scene("smartmotor", "the minus limit is active (Bm): wire pin D to ground", ("UCI ZS", "G")),
    Scene("smartmotor", "the plus limit is active (Bp): type  :drive C low  and then  ZS",
          ("UDI ZS A=100 V=100000 MP", ":drive C high", "P=300 G")),
    Scene("smartmotor", "the plus limit is active (Bp): type  :drive C release  and then  ZS",
          (AT_SWITCH, ":drive C high", "P=300 G"), {"shaft": SLIDE}),
    Scene("smartmotor", "the load is on the switch: move away in minus: type  ZS MP P=", (AT_SWITCH, "P=5000 G"),
          {"shaft": SLIDE}),
    Scene("smartmotor", "the load is on the switch: move away in plus: type  ZS MP P=",
          (f"{AT_SWITCH} O=77777", "P=-9999 G", "G"), {"shaft": SLIDE}),
    Scene("smartmotor", "the load is on the switch: move away in minus: type  ZS A=100 V=100000 MP P=",
          (AT_SWITCH, "P=5000 G", ":drive power off", ":drive power on", ":wait 0.5"), {"shaft": SLIDE}),
    Scene("smartmotor", "F=2 reverses the shaft, but not the switches: move away in minus: type  UDI ZS MP P=",
          (f"{AT_SWITCH} F=2", "P=5000 G"), {"shaft": SLIDE}),
    Scene("smartmotor", "an injected fault holds C: type  :drive mend all", (AT_SWITCH, ":drive fault stuck C high"),
          {"shaft": SLIDE}),
    Scene("smartmotor", "the software limit SLP is reached (Bp): move away in minus: type  ZS MP P=400 G",
          (MOTOR, "SLN=-100 SLP=500 SLE", "P=3000 G", "G")),
    Scene("smartmotor", "the software limit SLN is reached (Bm): move away in plus: type  ZS MP P=0 G",
          (MOTOR, "SLN=-100 SLP=500 SLE", "P=-3000 G")),
    Scene("smartmotor", "the software limits SLN and SLP leave no room: type  SLD ZS", (MOTOR, "SLE", "P=300 G")),
    Scene("smartmotor", "a limit fault has not been cleared (Br, Bl): type  ZS",
          (MOTOR, "SLN=-100 SLP=500 SLE", "P=3000 G", "SLD", "G")),
    Scene("smartmotor", "the position error has exceeded E (Be): free the shaft, or raise E, and then type  ZS",
          (MOTOR, "E=10", ":drive shaft.jam on", "P=3000 G")),
    Scene("smartmotor", "the motor has been too hot (Bh): let it cool from 95 to 65 °C, and then type  ZS",
          (MOTOR, ":drive ambient 95", ":wait 600", "P=3000 G")),
    Scene("smartmotor", "the motor has been too hot (Bh): type  ZS",
          (MOTOR, ":drive ambient 95", ":wait 600", ":drive ambient 25", ":wait 600")),
    Scene("smartmotor", "the PWM limit AMPS is 0: type  AMPS=1023", (MOTOR, "AMPS=0"), {"shaft": FRAME23}),
    Scene("smartmotor", "no acceleration has been given: type  A=100", ("UCI UDI ZS V=100000",)),
    Scene("smartmotor", "no acceleration has been given: type  A=100 G", ("UCI UDI ZS", "P=300 G")),
    Scene("smartmotor", "no velocity has been given: type  V=100000 G", (MOTOR, "V=0 P=300 G")),
    Scene("smartmotor", "asleep, so that it ignores all commands but WAKE: type  WAKE", (MOTOR, "SLEEP", "P=300 G")),
    Scene("smartmotor", "the last address byte was that of another motor: type  :drive power off  and  :drive power on",
          (MOTOR, "SADDR3", "\x81", "P=300 G")),
    *(Scene("smartmotor", "its channel 0 is closed, or receives data, so that nothing is a command: "
            "type  :drive power off",
            (MOTOR, line)) for line in ("CCHN(RS2,0)", "LOAD", "OCHN(RS2,0,N,9600,1,8,D)")),
    Scene("smartmotor", "the stored program is corrupt, and does not run (Bk): store it again, or type  :store END",
          (MOTOR, "LOAD", ":drive power off", ":drive power on", ":wait 0.5")),
    Scene("smartmotor", "its supply is below 18 V: an injected fault holds the supply: type  :drive mend all",
          (MOTOR, ":drive fault supply_dip 0.2"), {"shaft": FRAME23}),
)  # fmt: skip


@pytest.mark.parametrize("number", range(len(SCENES)), ids=lambda number: f"{SCENES[number].model}-{number}")
def test_what_the_tutor_says_leads_out(number):
    said = followed(number)
    (text, *_) = [each for each in said if SCENES[number].says in each] or pytest.fail(f"not said: {said}")
    for choice in range(1, len(choices(text))):
        followed(number, choice)


GUIDES = (digiplan.DigiplanReasons, compumotor.CompumotorReasons, smartmotor.SmartMotorReasons)


def spoken(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes of a statement but those of `short`, which the state of the machine says, not the tutor."""
    yield node
    for each in ast.iter_child_nodes(node):
        if not (isinstance(each, ast.keyword) and each.arg == "short"):
            yield from spoken(each)


def texts(family: type[Reasons]) -> Iterator[str]:
    """Yield all pieces of text in the methods of a guide that `reasons` calls."""
    methods = {}
    for each in (remedies.Remedies, Reasons, family):
        (made,) = ast.parse(inspect.getsource(each)).body
        methods |= {method.name: method for method in made.body if isinstance(method, ast.FunctionDef)}
    waiting, done = ["reasons"], set()
    while waiting:
        name = waiting.pop()
        if name in done:
            continue
        done.add(name)
        for node in (node for statement in methods[name].body[1:] for node in spoken(statement)):
            if isinstance(node, ast.Attribute) and node.attr in methods:
                waiting.append(node.attr)
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and len(node.value.split()) > 1:
                yield node.value
    yield from getattr(inspect.getmodule(family), "DRIVEN", {}).values()


def test_every_text_of_the_tutor_has_a_scene():
    said = "\n".join(text for number in range(len(SCENES)) for text in followed(number))
    assert [text for family in GUIDES for text in texts(family) if text.rstrip(": ") not in said] == []


def test_a_position_error_of_a_small_limit_is_cleared_when_the_limit_is_raised():
    learner = Learner("smartmotor", shaft=FRAME23)
    for line in (MOTOR, "E=1 A=2000", "P=3000 G"):
        perform(learner, line)
    reason = learner.tutor.why()[0]
    assert "raise E, and then type  ZS" in reason
    for line in ("E=1000", *choices(reason)[0], "P=50 G"):
        perform(learner, line)
    assert learner.tutor.why()[0].startswith("a move is possible") and abs(positions(learner)[0] - 50) < 5


HINTS = (
    # lines that lead into trouble, a piece of the hint, and a move that is then possible
    ((), "as pins C and D are not held low: give the shaft limits, or UCI UDI ZS at the top of the program",
     "P=50", {}),
    ((AT_SWITCH, "P=5000 G", "P=9000"), "at a limit switch: ZS, a move away from it, and ZS again",
     "P=0", {"shaft": SLIDE}),
    ((MOTOR, "SLN=-100 SLP=500 SLE", "P=3000 G"), "at or beyond a software limit: SLD ZS", "P=900", {}),
    ((MOTOR, "SLN=-100 SLP=500 SLE", "P=3000 G", "SLD"), "a limit fault has not been cleared: ZS or Zr", "P=900", {}),
    ((MOTOR, "SLN=-100 SLP=500 SLE", "P=-999 G", "SLD"), "a limit fault has not been cleared: ZS or Zl", "P=900", {}),
    ((MOTOR, "SLE", "G", "SLD"), "a limit fault has not been cleared: ZS", "P=900", {}),
    ((MOTOR, "E=10", ":drive shaft.jam on",
     "P=900 G"), "a position error has not been cleared: free the shaft, then ZS or Ze",
     "P=900", {}),
    ((MOTOR, ":drive ambient 95", ":wait 600", "P=900"), "let it cool to 5 °C below TH, then ZS or Zh", "P=900", {}),
    ((MOTOR, "SLEEP"), "asleep, so that it ignores all commands but WAKE: WAKE", "P=900", {}),
)  # fmt: skip
WAY = re.compile(r"UCI UDI ZS|SLD ZS|(?<!and )Z[Srleh]|WAKE$")
"""What a hint of a SmartMotor tells to send; each is a way of its own."""


@pytest.mark.parametrize(("lines", "says", "target", "options"), HINTS)
def test_each_way_of_a_hint_leads_out(lines, says, target, options):
    def in_trouble() -> Learner:
        learner = Learner("smartmotor", **options)
        for line in (*lines, "G"):
            perform(learner, line)
        assert says in learner.controller.hint
        return learner

    for way in WAY.findall(in_trouble().controller.hint):
        learner = in_trouble()
        for line in (*by_hand(learner.controller.hint, learner), way, f"A=100 V=100000 MP {target} G"):
            perform(learner, line)
        if "ZS again" in says:
            perform(learner, "ZS")
        assert (learner.controller.hint, positions(learner)) == ("", [int(target[2:])]), way


def test_a_motor_whose_shaft_is_given_limits_moves():
    learner = Learner("smartmotor", shaft=SLIDE)
    perform(learner, "A=100 V=100000 MP P=50 G")
    assert (learner.controller.hint, positions(learner)) == ("", [50])


def test_a_supply_that_is_too_low():
    learner = Learner("smartmotor", shaft=FRAME23)
    perform(learner, ":drive fault supply_dip 0.2")
    assert learner.controller.hint.endswith("below 18 V: raise it, or lower the option reset_below_v")
    lower = Learner("smartmotor", shaft=FRAME23, reset_below_v=5.0)
    perform(lower, ":drive fault supply_dip 0.2")
    perform(learner, ":drive mend all")
    for each in (learner, lower):
        assert each.controller.hint == ""
        perform(each, f"{MOTOR} P=50 G")
        assert abs(positions(each)[0] - 50) < 5


def test_characters_that_an_if1_drops():
    learner = Learner("if1")
    learner.type("X100$")
    for command in (r"send (\S) first", r"e\.g\. (\w+) <CR>"):
        learner.type(re.search(command, learner.controller.hint)[1])
        assert learner.controller.hint == ""
        learner.type("X100$")
    assert positions(learner) == [100, 0, 0]


@pytest.mark.parametrize("trouble", [(), (":drive fault stuck input1 low",)])
@pytest.mark.parametrize("way", [r"! (\S+ \S+) in a program", r":drive (\S+ \S+) in a terminal"])
def test_an_input_for_which_an_if1_waits(trouble, way):
    learner = Learner("if1").initialise()
    for line in (*trouble, "H1X100$"):
        perform(learner, line)
    for _ in range(2):  # a fault that has ended, and then the input
        if hint := learner.controller.hint:
            perform(learner, f":drive {re.search(way, hint)[1]}")
    learner.bench.run(3)
    assert (learner.controller.hint, positions(learner)) == ("", [100, 0, 0])


def test_an_if1_that_does_not_answer_an_opening_bracket():
    learner, told = Learner("if1").initialise(), []
    learner.controller.subscribe_hint(told.append)
    learner.type("(")
    assert "switch its power off and on" in told[0]
    for line in (":drive power off", ":drive power on", ":wait 1.5"):
        perform(learner, line)
    assert "the baud rate has been measured" in learner.type("(")[1][0]


@pytest.mark.parametrize("line", ["X100", "X100Y100@400", "Z300"])
def test_a_message_without_a_dollar_is_completed(line):
    learner = Learner("if1").initialise()
    (note, *_) = learner.type(line)[0]
    obey(learner, note)
    assert positions(learner) != [0, 0, 0]


TASKS = [
    (model, number, step)
    for model in ("if1", "1811", "smartmotor")
    for number, lesson in enumerate(course(model))
    for step, each in enumerate(lesson.steps)
    if choices(each.task) != [[]]
]


@pytest.mark.parametrize(("model", "number", "step"), TASKS)
def test_a_task_of_a_lesson_is_done_by_what_it_says(model, number, step):
    learner, lesson = Learner(model), course(model)[number]
    if lesson.initialised and model == "if1":
        learner.initialise()
    pupil = Pupil(lesson, learner.bench)
    for before in lesson.steps[:step]:
        for line in before.solution:
            solve(learner, line)
        assert pupil.check()
    for line in choices(lesson.steps[step].task)[0]:
        perform(learner, line)
    assert pupil.check() or learner.bench.run(8) or pupil.check()
    pupil.close()
