"""The lessons of `axistwin learn` on the controllers of a session; all pages share them."""

from collections.abc import Iterator

from axistwin.bench import Bench, Do, Wait
from axistwin.bench.acts import Act
from axistwin.core.units import to_ns
from axistwin.scenes.reasons.families import reasons_of
from axistwin.scenes.reasons.remedies import Remedies
from axistwin.scenes.sessions.session import Session
from axistwin.ui.teaching.lessons import STARTED_S, course
from axistwin.ui.teaching.pupil import Pupil


class Lessons:
    """The present lesson of each controller."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._pupils: dict[str, tuple[int, Pupil]] = {}
        session.each_bench(self._attach)

    def _attach(self, bench: Bench) -> None:
        for name, (number, pupil) in self._pupils.items():
            pupil.close()
            self._pupils[name] = number, Pupil(pupil.lesson, bench, pupil.step, name)

    def of(self, name: str) -> tuple[int, Pupil] | None:
        """Return a controller's lesson, from 1, and the progress in it after a check; None without a lesson."""
        found = self._pupils.get(name)
        if found is not None:
            found[1].check()
        return found

    def begin(self, name: str, number: int) -> Iterator[Act]:
        """Yield the acts that switch a controller off and on and make it ready, and begin the lesson after them."""
        self.end(name)
        lesson = course(self._session.bench[name].product.model)[number - 1]
        for level in ("off", "on"):
            yield Do("power", level, controller=name)
        yield Wait(to_ns(STARTED_S))
        if lesson.initialised:
            yield from reasons_of(self._session.bench[name], Remedies()).initialisation()
        self._pupils[name] = number, Pupil(lesson, self._session.bench, name=name)

    def end(self, name: str) -> None:
        _, pupil = self._pupils.pop(name, (0, None))
        if pupil is not None:
            pupil.close()
