"""The checker's rules for program flow: labels, calls, returns, the return stack, unreachable code.

The rules follow the code from the top, from each called label, and from C1 and C2 if an F= enables their calls.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

from axistwin.controllers.diagnostics import fixing, replaced
from axistwin.controllers.smartmotor import rules
from axistwin.controllers.smartmotor.chapters.functions import CALL_C1
from axistwin.controllers.smartmotor.checker.findings import Findings, constant_value
from axistwin.controllers.smartmotor.kernel import interpreter as ops
from axistwin.controllers.smartmotor.kernel.interpreter import HEAD
from axistwin.controllers.smartmotor.kernel.state import DEPTH_MOST, SWITCH_MOST
from axistwin.controllers.smartmotor.language.program import digits

FAULT, INPUT = 1, 2  # Numbers of the labels that faults (C1) and pin G (C2) call.
WITH_ARGUMENT = frozenset({ops.CONSTANT, ops.SLOT, ops.VARIABLE, ops.COMPUTED, ops.PIN, ops.TAKEN_PIN})
ENDS = frozenset({ops.S_RETURN, ops.S_RETURNI, ops.S_END})
NO_RETURN = frozenset({"RUN", "Z"})


@dataclass
class Routine:
    """The code that runs from a label, or from the top (label None), without the subroutines that it calls."""

    label: int | None
    pcs: set[int] = field(default_factory=set)
    calls: dict[int, int] = field(default_factory=dict)  # Label that each GOSUB calls, by number of the statement.
    returns: dict[int, str] = field(default_factory=dict)  # Keyword of each return command, by number of the statement.


class Flow:
    """The routines of a program."""

    def __init__(self, findings: Findings) -> None:
        self.findings, self.program = findings, findings.program
        self._labels = {pc: label for label, pc in self.program.labels.items()}

    @cached_property
    def main(self) -> Routine:
        return self.routine(None)

    @cached_property
    def interrupts(self) -> dict[int, Routine]:
        """The interrupt routines C1 and C2 that the program contains and enables by F=."""
        wanted = {FAULT: CALL_C1, INPUT: ops.CALL_C2}
        return {
            label: self.routine(label)
            for label, bit in wanted.items()
            if label in self.program.labels and self.findings.sets_function(bit)
        }

    @cached_property
    def routines(self) -> dict[int | None, Routine]:
        """All routines of the program, by label.  A host may call any label that the program does not call."""
        return {None: self.main, **{label: self.routine(label) for label in self.program.labels}}

    def routine(self, label: int | None) -> Routine:
        made = Routine(label)
        waiting = [0 if label is None else self.program.labels[label]]
        while waiting:
            pc = waiting.pop()
            if pc not in made.pcs:
                made.pcs.add(pc)
                self._note(made, pc)
                waiting += self._next(pc)
        return made

    def order(self) -> list[int]:
        """Return the statements that the program executes from its top, in the order in which it first reaches them.

        A subroutine comes where it is first called, and the first branch of a condition before the others.
        """
        numbers: dict[int, int] = {}
        waiting = [0]
        while waiting:
            pc = waiting.pop()
            if pc not in numbers:
                numbers[pc] = self.program.code[pc + 1]
                waiting += reversed(list(self._next(pc)))
                if self.program.code[pc] == ops.S_GOSUB:
                    waiting.append(self.program.code[pc + HEAD])
        return [number for number in numbers.values() if number < len(self.findings.statements)]

    def _note(self, made: Routine, pc: int) -> None:
        operation, number = self.program.code[pc], self.program.code[pc + 1]
        if operation == ops.S_GOSUB:
            made.calls[number] = self._labels[self.program.code[pc + HEAD]]
        elif operation in (ops.S_RETURN, ops.S_RETURNI):
            made.returns[number] = self.findings.words[number]

    def _next(self, pc: int) -> Iterator[int]:
        code = self.program.code
        operation, number, target = code[pc], code[pc + 1], code[pc + 2]
        if operation == ops.S_IF:
            yield from self._branches(pc, target)
        elif operation == ops.S_SWITCH:
            yield from (target, self._after(pc + HEAD))
        elif operation == ops.S_CASE:
            yield from (target, code[pc + HEAD + 1])
        elif operation not in ENDS and self.findings.words[number] not in NO_RETURN:
            yield target

    def _branches(self, pc: int, otherwise: int) -> Iterator[int]:
        """Yield both branches of a condition; for a constant condition, only the branch that is taken."""
        code = self.program.code
        constant = code[pc + HEAD] == ops.CONSTANT and code[pc + HEAD + 2] == ops.RESULT
        if not constant or code[pc + HEAD + 1]:
            yield self._after(pc + HEAD)
        if not constant or not code[pc + HEAD + 1]:
            yield otherwise

    def _after(self, at: int) -> int:
        code = self.program.code
        while code[at] != ops.RESULT:
            at += 2 if code[at] in WITH_ARGUMENT else 1
        return at + 1


def check(findings: Findings) -> None:
    """Report all problems of program flow: labels, returns, stack, interrupts, unreachable code."""
    flow = Flow(findings)
    _labels(findings)
    _returns(findings, flow)
    _stack(findings, flow)
    _interrupts(findings, flow)
    _unreachable(findings, flow)
    _switches(findings)


def _labels(findings: Findings) -> None:
    first: dict[int, int] = {}
    for number, statement in findings.all("Cn"):
        label = digits(statement)
        if label in first:
            message = f"label C{label} is already defined in line {findings.line(first[label])}"
            findings.report(rules.LABEL_TWICE, number, message)
        first.setdefault(label, number)
    for number, statement in findings.all("GOTOn", "GOSUBn"):
        label = digits(statement)
        if label not in first:
            findings.report(rules.NO_LABEL, number, f"there is no label C{label}")


RETURNS = {FAULT: "RETURNF", INPUT: "RETURNI"}
CALLED_BY = {FAULT: "a fault (F=32)", INPUT: "pin G (F=64)"}


def _returns(findings: Findings, flow: Flow) -> None:
    """Report wrong return commands, e.g. RETURN instead of RETURNF at the end of the fault routine."""
    called = {label for routine in flow.routines.values() for label in routine.calls.values()}
    for number, keyword in flow.main.returns.items():
        findings.report(rules.RETURN, number, f"{keyword} is reached without a GOSUB: it sets Bs and ends the program")
    for label, routine in flow.interrupts.items():
        for number, keyword in routine.returns.items():
            if keyword != RETURNS[label] and label not in called:
                note = ": C2 would not be called again" if label == INPUT else ""
                message = f"C{label} is called by {CALLED_BY[label]} and returns with {RETURNS[label]}{note}"
                fix = fixing(f"write {RETURNS[label]}", replaced(findings.text(number), RETURNS[label]))
                findings.report(rules.OTHER_RETURN, number, message, fix)
    for label, keyword in RETURNS.items():
        own = flow.routines[label].returns if label in flow.routines else {}
        for number, _ in findings.all(keyword):
            if number not in own and number not in flow.main.returns:
                message = f"{keyword} belongs to C{label}, but C{label} does not reach this statement"
                findings.report(rules.STRAY_RETURN, number, message)


def _stack(findings: Findings, flow: Flow) -> None:
    """Report calls that need more than ten return addresses, including those of C1 and C2."""
    depths = _Depths(findings, flow)
    deepest = depths.of(None) + sum(1 + depths.of(label) for label in flow.interrupts)
    calls = flow.main.calls
    if deepest > DEPTH_MOST and calls:
        number = max(calls, key=lambda at: depths.of(calls[at]))
        findings.report(rules.DEEP, number, f"this may need {deepest} return addresses: the stack holds {DEPTH_MOST}")


class _Depths:
    """The number of return addresses that each routine needs, without recursive calls."""

    def __init__(self, findings: Findings, flow: Flow) -> None:
        self._findings, self._flow = findings, flow
        self._known: dict[int | None, int] = {}
        for label in flow.routines:
            self._measure(label)

    def of(self, label: int | None) -> int:
        return self._known[label]

    def _measure(self, start: int | None) -> None:
        """Compute a routine's depth with an explicit stack, because a program may have a thousand routines."""
        path = [(start, self._calls(start))] if start not in self._known else []
        while path:
            label, calls = path[-1]
            if not calls:
                path.pop()
                inner = self._flow.routines[label].calls.values()
                self._known[label] = max((1 + self._known.get(called, 0) for called in inner), default=0)
                continue
            number, called = calls.pop()
            if any(called == upper for upper, _ in path):
                message = f"C{called} calls itself: each call uses one of {DEPTH_MOST} return addresses"
                self._findings.report(rules.RECURSION, number, message)
            elif called not in self._known:
                path.append((called, self._calls(called)))

    def _calls(self, label: int | None) -> list[tuple[int, int]]:
        return list(self._flow.routines[label].calls.items())


def _interrupts(findings: Findings, flow: Flow) -> None:
    """Report each F=32 without C1 and F=64 without C2, and each STACK that GOTO does not follow at once."""
    for label, bit in ((FAULT, CALL_C1), (INPUT, ops.CALL_C2)):
        for number, statement in findings.all("F="):
            if (constant_value(statement) or 0) & bit and label not in flow.program.labels:
                findings.report(rules.CALLS_NOTHING, number, f"F={bit} calls C{label}, which does not exist")
    for number, _ in findings.all("STACK"):
        if "GOTOn" not in findings.words[number + 1 : number + 2]:
            findings.report(rules.STACK, number, "STACK should be followed by GOTO at once")


def _unreachable(findings: Findings, flow: Flow) -> None:
    reached = {flow.program.code[pc + 1] for routine in flow.routines.values() for pc in routine.pcs}
    quiet = {"Cn", "ENDIF", "ENDS", "CASE", "DEFAULT", "ELSE", "ELSEIF", "LOOP", "BREAK", "END", ""}
    before = True
    for number, keyword in enumerate(findings.words):
        here = number in reached
        if not here and before and keyword not in quiet:
            findings.report(rules.UNREACHED, number, "this is never reached")
        before = here or (before and keyword in quiet)


def _switches(findings: Findings) -> None:
    deep = 0
    for number, keyword in enumerate(findings.words):
        deep += (keyword == "SWITCH") - (keyword == "ENDS")
        if keyword == "SWITCH" and deep == SWITCH_MOST + 1:
            findings.report(rules.SWITCHES, number, f"more than {SWITCH_MOST} nested SWITCH")
