"""The lessons of `axistwin learn` on the controllers of a session; all pages share them."""

from axistwin.bench import Bench
from axistwin.scenes.sessions.buttons import initialise
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

    async def begin(self, name: str, number: int) -> None:
        """Switch a controller off and on, begin a lesson, and start virtual time.  Raises AxistwinError."""
        self.end(name)
        session = self._session
        lesson = course(session.bench[name].product.model)[number - 1]
        for level in ("off", "on"):
            session.do(name, "power", level)
        await session.advance_to(session.seconds + STARTED_S)
        if lesson.initialised:
            await initialise(session, name)
        self._pupils[name] = number, Pupil(lesson, session.bench, name=name)
        if not session.running:
            session.run()

    def end(self, name: str) -> None:
        _, pupil = self._pupils.pop(name, (0, None))
        if pupil is not None:
            pupil.close()
