"""The progress of a user in a lesson."""

from contextlib import ExitStack

from axistwin.bench import Bench
from axistwin.bench.codec import codec_of
from axistwin.bench.events import Event, Received, Sent, observing
from axistwin.ui.teaching.lessons import Evidence, Lesson

HUNTING = 4  # Distance in encoder counts by which a servo motor may move while it holds its position.


class Pupil:
    """Progress in a lesson.  `step`: the first step; `name` may be left out with one controller."""

    def __init__(self, lesson: Lesson, bench: Bench, step: int = 0, name: str | None = None) -> None:
        self.lesson, self.step = lesson, step
        if name is None:
            (name,) = bench.controllers
        self._controller = bench[name]
        self._codec = codec_of(self._controller.product)
        self._stack = ExitStack()
        self._stack.enter_context(observing(bench, self._note))
        self._begin()

    def _begin(self) -> None:
        self._said: list[bytes] = []
        self._heard: list[bytes] = []
        self._origin = self._rest = self._positions()
        self._acted = False

    def _positions(self) -> dict[str, int]:
        return {name: axis.position for name, axis in self._controller.axes.items()}

    def _note(self, event: Event) -> None:
        if isinstance(event, Sent | Received) and event.controller == self._controller.name:
            (self._said if isinstance(event, Sent) else self._heard).append(event.data)
        self._acted = True

    @property
    def finished(self) -> bool:
        return self.step == len(self.lesson.steps)

    @property
    def task(self) -> str:
        """Task of the current step, or "" after the last step."""
        return "" if self.finished else f"{self.step + 1}. {self.lesson.steps[self.step].task}"

    @property
    def solution(self) -> tuple[str, ...]:
        return () if self.finished else self.lesson.steps[self.step].solution

    def check(self) -> bool:
        """Go to the next step of the lesson if the current step is done.  Return True if the current step is done."""
        if self.finished or not self._acted:
            return False
        shown = (self._show(self._said), self._show(self._heard))
        done = self.lesson.steps[self.step].done(Evidence(self._controller, *shown, self._origin, self._rest))
        if done:
            self.step += 1
            self._begin()
        return done

    def remark(self) -> str:
        """Return how far an axis has moved in a move that does not solve the task, once after the move; else ""."""
        if self.finished or any(axis.moving for axis in self._controller.axes.values()):
            return ""
        before, self._rest = self._rest, self._positions()
        moved = {name: at - before[name] for name, at in self._rest.items()}
        moves = [f"{name} has moved by {by}" for name, by in moved.items() if abs(by) > HUNTING]
        return f"{', '.join(moves)}: the task is not done yet" if moves else ""

    def _show(self, data: list[bytes]) -> str:
        if self._controller.product.language is None:
            return b"".join(data).decode("latin-1")
        return "\n".join(self._codec.show(each) for each in data)

    def close(self) -> None:
        self._stack.close()
