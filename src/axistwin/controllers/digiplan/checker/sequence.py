"""Follows a sequence along all possible paths, with the parameters on each path."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from axistwin.controllers.diagnostics import Severity
from axistwin.controllers.digiplan.chapters.interpolation import out_of_range
from axistwin.controllers.digiplan.rules import NEVER_REACHED, NO_DISTANCE, RUN_CONTINUES
from axistwin.controllers.digiplan.step import Fault, Parameters, Problem, Step


@dataclass(frozen=True)
class Finding:
    """A problem of a sequence, with the number of the step that has the problem.  The first step has number 1."""

    number: int
    problem: Problem


@dataclass(frozen=True)
class _Arrival:
    """A possible state at the start of a step: the parameters, and the step whose run continues (0: no run)."""

    number: int
    parameters: Parameters
    running: int


def follow(steps: Sequence[Step], parameters: Parameters) -> Iterator[Finding]:
    """Follow all paths through a sequence; in a repeat, a later step's value applies to earlier steps."""
    yield from _never_reached(steps)
    todo, seen = [_Arrival(1, parameters, 0)], set[_Arrival]()
    while todo:
        arrival = todo.pop()
        if arrival in seen or arrival.number > len(steps):
            continue
        seen.add(arrival)
        step = steps[arrival.number - 1]
        here = arrival.parameters.after(step)
        running = 0 if step.abort else arrival.running
        if step.major:
            finding = _move(step, arrival.number, here, running)
            if finding is not None:
                yield finding
                if finding.problem.rule.severity is Severity.ERROR or running:
                    continue
            running = arrival.number if step.run else running
        todo += [_Arrival(number, arrival.parameters.left_by(step), running) for number in _next(step, arrival.number)]


def _move(step: Step, number: int, parameters: Parameters, running: int) -> Finding | None:
    if running:
        message = f"the run of step {running} continues, and the move of this step waits for its end: A stops the run"
        return Finding(number, Problem(RUN_CONTINUES, Fault.DATA, 0, message, RUN_CONTINUES.chapter))
    problem = out_of_range(parameters, step)
    if problem is not None:
        return Finding(number, problem)
    if parameters.distance == 0 and not step.run:
        message = "nothing moves: the distance is 0"
        return Finding(number, Problem(NO_DISTANCE, Fault.DATA, 0, message, NO_DISTANCE.chapter, ("distance",)))
    return None


def _next(step: Step, number: int) -> tuple[int, ...]:
    if step.repeat is None:
        return (number + 1,)
    times, first = step.repeat
    return (first,) if times == 0 else (first, number + 1)


def _never_reached(steps: Sequence[Step]) -> Iterator[Finding]:
    for number, step in enumerate(steps[:-1], start=1):
        if step.repeat and step.repeat[0] == 0:
            message = f"never reached: step {number} repeats for ever"
            yield Finding(number + 1, Problem(NEVER_REACHED, Fault.DATA, 0, message, NEVER_REACHED.chapter))
            return
