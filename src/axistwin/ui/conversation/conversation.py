"""A conversation with the tutor: typed lines and answers get notes, and questions are answered in the list."""

import re

from axistwin.bench import Bench
from axistwin.bench.events import Received
from axistwin.core.errors import PlacedError
from axistwin.core.units import S
from axistwin.scenes.reasons.remedies import ByHand
from axistwin.scenes.sessions.session import Session
from axistwin.ui.conversation.lessons import Lessons
from axistwin.ui.conversation.log import Entry, Log
from axistwin.ui.teaching.tutor import Tutor

ANSWERS_NS = 2 * S  # Virtual time after a typed line during which received data count as its answer.
READY = "the controller is ready: no initialisation is needed"
NO_LESSON = "no lesson has begun: select one with the button Lessons"
QUESTIONS = {"why": "Why does nothing move?", "next": "What next?", "task": "The task?", "show": "The solution?"}


class Conversation:
    """The list of a session's messages, with the tutor of each controller and the lessons."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self.log, self.lessons = Log(session), Lessons(session)
        self._tutors: dict[str, Tutor] = {}
        self._until_ns: dict[str, int] = {}  # End of the time in which messages answer the last typed line.
        self._steps: dict[str, tuple[int, int]] = {}  # Lesson and step that the list has told last.
        self.log.on_said = self._explain
        session.each_bench(self._attach)

    def _attach(self, bench: Bench) -> None:
        self._until_ns.clear()
        self._tutors = {name: Tutor(bench[name], ByHand(self._session.operator, name)) for name in bench.controllers}

    def knows(self, name: str) -> bool:
        """True if an endpoint is a controller, which has a tutor; a shared line has none."""
        return name in self._tutors

    def tutor(self, name: str) -> Tutor:
        return self._tutors[name]

    def say(self, name: str, data: bytes, *, explained: bool = True) -> None:
        """Send a typed line, and explain it and its answer in the list.  Raises AxistwinError."""
        notes: list[str] = []
        if explained and self.knows(name):
            notes = self._session.inspect(lambda: self._tutors[name].sending(data))
            self._until_ns[name] = self._session.bench.now + ANSWERS_NS
        self.log.close_line(name)
        self._session.say(name, data)
        self.log.typed(name, data, notes)

    def refused(self, name: str, line: str, error: PlacedError) -> None:
        """Tell in the list why a typed line is no command, the first time for each rule."""
        if notes := self._tutors[name].unreadable(error):
            self.log.ask(name, line, notes)

    def ask(self, name: str, question: str, words: str = "", typed: str = "") -> bool:
        """Answer a question in the list: why, next, explain, task or show.  Return False for any other word."""
        tutor = self._tutors[name]
        match question:
            case "why" | "next":
                answer = self._session.inspect(getattr(tutor, question))
            case "explain":
                answer = self._session.inspect(lambda: tutor.explain(words))
            case "task" | "show":
                answer = self._about_lesson(name, question)
            case _:
                return False
        self.log.ask(name, typed or QUESTIONS.get(question) or f"Explain {words}".rstrip(), answer)
        return True

    def look_at_lesson(self, name: str) -> None:
        """Tell in the list that a step of a lesson is done, with the next task."""
        found = self.lessons.of(name)
        now = None if found is None else (found[0], found[1].step)
        before = self._steps.get(name)
        if now == before:
            return
        self._steps.pop(name, None)
        if found is None or now is None:
            return
        self._steps[name] = now
        pupil = found[1]
        if before is not None and before[0] == now[0] and now[1] > before[1]:
            self.log.ask(name, "Done", [] if pupil.finished else [by_hand(pupil.task)])

    def _about_lesson(self, name: str, question: str) -> list[str]:
        found = self.lessons.of(name)
        if found is None:
            return [NO_LESSON]
        return [by_hand(found[1].task)] if question == "task" else [f"type  {line}" for line in found[1].solution]

    def _explain(self, name: str, entry: Entry, event: Received) -> None:
        if name in self._tutors and event.time_ns <= self._until_ns.get(name, -1):
            entry.notes += self._tutors[name].received(event.data)


_DRIVE = re.compile(r"(type  )?:drive (\w+) (?:high|low)")


def by_hand(task: str) -> str:
    """Adapt a lesson to a page: `:drive input1 high` becomes `click the switch input1`."""
    return _DRIVE.sub(r"click the switch \2", task)
