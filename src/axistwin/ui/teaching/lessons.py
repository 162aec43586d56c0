"""The lessons: six for each family, from the first command to a repeating sequence with inputs.

A step is done when the bench shows its effect.  The user may type other lines than those of the solution.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from axistwin.bench import Controller, is_model, product
from axistwin.controllers.registry import OURS
from axistwin.core.errors import UsageError

STARTED_S = 1.5  # Virtual time in seconds from power-up until every model is ready for the first command of a lesson.


@dataclass(frozen=True)
class Evidence:
    """The data from which a lesson decides if the user has completed a step."""

    controller: Controller
    said: str
    heard: str
    origin: Mapping[str, int]  # Position of each axis at the beginning of the step.
    rest: Mapping[str, int]  # Position of each axis before its last move.


Check = Callable[[Evidence], bool]


@dataclass(frozen=True)
class Step:
    """One step of a lesson: a task, its solution, and a check of the result."""

    task: str
    solution: tuple[str, ...]
    done: Check


@dataclass(frozen=True)
class Lesson:
    """A lesson: steps for a controller that has just been switched on."""

    title: str
    steps: tuple[Step, ...]
    initialised: bool = True


def answered(pattern: str, to: str = "") -> Check:
    """Return a check: the controller has answered the request `to` with an answer that matches `pattern`."""
    return lambda it: re.search(pattern, it.heard) is not None and to in it.said


def is_clear(mask: int) -> Check:
    """Return a check: these bits of the status word, which request RW reports, are 0."""
    return lambda it: "RW" in it.said and any(not int(word) & mask for word in re.findall(r"\d+", it.heard))


def moved(axis: str, by: int) -> Check:
    """Return a check for an axis that has moved by this distance, in this step or in its last move, and has stopped."""

    def check(it: Evidence) -> bool:
        found = it.controller.axes[axis]
        return not found.moving and by in (found.position - it.origin[axis], found.position - it.rest[axis])

    return check


def moving(axis: str) -> Check:
    return lambda it: it.controller.axes[axis].moving


def stopped(axis: str) -> Check:
    return lambda it: not it.controller.axes[axis].moving


def runs_moves(it: Evidence) -> bool:
    """True while a stored program that contains moves is running.  The condition is also true between two moves."""
    return any("G" in each.lines and each.running is not None for each in it.controller.programs.values())


def level(pin: str, high: bool) -> Check:
    return lambda it: it.controller.pins[pin].level is high


def both(first: Check, second: Check) -> Check:
    return lambda it: first(it) and second(it)


def register(name: str, value: int | str) -> Check:
    return lambda it: it.controller.registers[name].read() == value


IF1 = (
    Lesson("The first command", (
        Step("The interface measures the baud rate by an open bracket: type  (", ("(",), answered("U")),
        Step("Choose 8 data bits, no parity, 2 stop bits: type  U61", ("U61", ":wait 1.5"), register("state", "ready")),
        Step("Ask whether the interface is busy: type  E  (C: clear for commands)", ("E",), answered("C", "E")),
    ), initialised=False),
    Lesson("A move", (
        Step("Index X by 1000 steps; $ starts the move: type  X1000$", ("X1000$", ":wait 5"), moved("X", 1000)),
        Step("Ask for the steps of this move: type  N", ("N",), answered("1000", "N")),
        Step("Move back: type  X-1000$", ("X-1000$", ":wait 5"), moved("X", -1000)),
    )),
    Lesson("Speed", (
        Step("Move X by 2000 steps at 2000 steps/s: @ sets the speed", ("X2000@2000$", ":wait 5"), moved("X", 2000)),
        Step("Run X continuously: G instead of a distance", ("XG$", ":wait 1"), moving("X")),
        Step("Stop the run with deceleration: type  #", ("#", ":wait 3"), stopped("X")),
    )),
    Lesson("Outputs and two axes", (
        Step("Switch output 2 on: S, the number, $", ("S2$", ":wait 1"), level("output2", True)),
        Step("Switch output 2 off: R, the number, $", ("R2$", ":wait 1"), level("output2", False)),
        Step("Move Y by 500 steps", ("Y500$", ":wait 5"), moved("Y", 500)),
    )),
    Lesson("Inputs and limits", (
        Step("Wait for input 1, then move: type  H1X300$  and then  :drive input1 high",
             ("H1X300$", ":wait 1", ":drive input1 high", ":wait 5"), moved("X", 300)),
        Step("Open the plus limit: type  :drive limit_plus low", (":drive limit_plus low", ":wait 1"),
             register("K", 64)),
        Step("Close it, and read the fault: type  :drive limit_plus high  and  K",
             (":drive limit_plus high", "K", ":wait 1"), both(level("limit_plus", True), register("K", 0))),
    )),
    Lesson("A repeating sequence", (
        Step("Move forth and back three times: type  :X400:X-400:=2,1:$", (":X400:X-400:=2,1:$", ":wait 15"),
             lambda it: len(it.controller.programs["sequence"].lines) >= 3 and not it.controller.axes["X"].moving),
        Step("Move each time input 1 rises, endlessly: type  :H1X100:L1:=0,1:$  and  :drive input1 high",
             (":H1X100:L1:=0,1:$", ":wait 1", ":drive input1 high", ":wait 5"), moved("X", 100)),
        Step("End the sequence: type  #", ("#", ":wait 1"), register("step", 0)),
    )),
)  # fmt: skip

DEFAULTS = "default_velocity_and_acceleration 00 25000 250000"
BOARD = (
    Lesson("The first command", (
        Step("Ask for the position: type  83  or  position_from_absolute_zero", ("83",), answered("83")),
        Step("Ask for limits, home and motion: type  move_status", ("move_status",), answered("88")),
    )),
    Lesson("A move", (
        Step(f"Give velocity and acceleration: type  {DEFAULTS}", (DEFAULTS,), lambda it: "31" in it.said[:2]),
        Step("Move by 25000 pulses: type  go_relative 25000", ("go_relative 25000", ":wait 4"), moved("motor", 25000)),
        Step("Ask for the position: type  83", ("83",), answered("83 00 00 00 00 61 A8")),
    )),
    Lesson("Run and stop", (
        Step(f"Give velocity and acceleration, and run: type  {DEFAULTS}  and  go_on +",
             (DEFAULTS, "go_on +", ":wait 1"), moving("motor")),
        Step("Stop: type  stop", ("stop", ":wait 2"), stopped("motor")),
    )),
    Lesson("Outputs", (
        Step("Switch programmable output 1 off: type  clear_output 1", ("clear_output 1", ":wait 1"),
             level("output1", False)),
        Step("Switch it on again: type  set_output 1", ("set_output 1", ":wait 1"), level("output1", True)),
    )),
    Lesson("Triggers", (
        Step("Ask for the trigger inputs: type  94", ("94",), answered("94")),
        Step("Hold trigger 1 low: type  :drive trigger1 low", (":drive trigger1 low", ":wait 1"),
             level("trigger1", False)),
    )),
    Lesson("A repeating sequence", (
        Step(f"Begin sequence 1: type  {DEFAULTS}  and  D9 01", (DEFAULTS, "D9 01", ":wait 1"),
             lambda it: "D9 01" in it.said),
        Step("Three moves while trigger 2 is low: type  repeat 2 3,  wait_for_trigger 2 low,  go_relative 100,  D8",
             ("repeat 2 3", "wait_for_trigger 2 low", "go_relative 100", "D8", ":wait 1"), lambda it: "D8" in it.said),
        Step("Perform it, with trigger 2 low: type  perform_sequence 1  and  :drive trigger2 low",
             ("perform_sequence 1", ":drive trigger2 low", ":wait 8"), moved("motor", 300)),
    )),
)  # fmt: skip

LIMITS = 0x606  # The four limit bits of a SmartMotor's status word.
CLEAR = Step("Make pins C and D inputs, and clear the limit fault: type  UCI UDI ZS", ("UCI UDI ZS", ":wait 1"),
             lambda it: not int(it.controller.registers["RW"].read()) & LIMITS)  # fmt: skip
START = Step("Give acceleration and velocity, and go to 4000: type  A=100 V=200000 P=4000 G",
             ("A=100 V=200000 P=4000 G", ":wait 5"), moved("shaft", 4000))  # fmt: skip
MOTOR = (
    Lesson("The first command", (
        Step("Ask for the position: type  RP", ("RP",), answered("0", "RP")),
        Step("Ask for the status word: type  RW  (the tutor explains its bits)", ("RW",), answered("1670", "RW")),
    )),
    Lesson("Clear the limit fault", (
        CLEAR,
        Step("Ask for the status word again: type  RW", ("RW",), is_clear(LIMITS)),
    )),
    Lesson("A move", (
        CLEAR,
        START,
        Step("Ask for the position: type  RP", ("RP",), answered("4000", "RP")),
    )),
    Lesson("Velocity", (
        CLEAR,
        Step("Run: type  MV A=100 V=200000 G", ("MV A=100 V=200000 G", ":wait 1"), moving("shaft")),
        Step("Decelerate to a stop: type  X", ("X", ":wait 3"), stopped("shaft")),
    )),
    Lesson("Variables and inputs", (
        Step("Keep 42 in the variable a, and report it: type  a=42  and  Ra", ("a=42", "Ra"), answered("42", "Ra")),
        Step("Ground pin A and report it: type  :drive A low  and  RUA", (":drive A low", "UAI", "RUA"),
             answered("0", "RUA")),
    )),
    Lesson("A repeating sequence", (
        Step("Store a program that moves forth and back while pin A is low: type  :drive A low  and  :store"
             " UCI UDI ZS A=100 V=200000 WHILE 1 WHILE UAI LOOP P=2000 G TWAIT P=0 G TWAIT LOOP END",
             (":drive A low",
              ":store UCI UDI ZS A=100 V=200000 WHILE 1 WHILE UAI LOOP P=2000 G TWAIT P=0 G TWAIT LOOP END",
              ":wait 1.5"), runs_moves),
        Step("Release pin A: type  :drive A high,  and wait until the shaft has stopped", (":drive A high", ":wait 6"),
             both(level("A", True), stopped("shaft"))),
    )),
)  # fmt: skip
COURSES = {"digiplan": IF1, "compumotor": BOARD, "smartmotor": MOTOR}


def course(model: str) -> tuple[Lesson, ...]:
    """Return the lessons for a controller model.  Raises UsageError if there are none."""
    found = COURSES.get(product(model).family, ()) if is_model(model) else ()
    if not found:
        raise UsageError(f"no lessons for {model!r}: expected one of {', '.join(OURS)}")
    return found
