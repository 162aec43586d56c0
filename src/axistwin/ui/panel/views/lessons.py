"""Lessons in a terminal of the panel: a menu, the present task, and buttons for help."""

from collections.abc import Awaitable
from functools import partial

from nicegui import ui

from axistwin.scenes.sessions.buttons import follow
from axistwin.ui.conversation.conversation import Conversation, by_hand
from axistwin.ui.panel.context import Context
from axistwin.ui.panel.turns import breathe
from axistwin.ui.panel.views.asides import FLAT, Asides
from axistwin.ui.teaching.lessons import course


class LessonCard:
    """The menu of lessons, and a card with the present task."""

    def __init__(self, context: Context, name: str, asides: Asides) -> None:
        self._context, self._name, self._asides = context, name, asides
        self._all = context.common(Conversation).lessons
        self._model = context.bench[name].product.model
        self._course = course(self._model)
        self._shown: tuple[int, int] | None = None
        self._titles: list[ui.item_label] = []
        self._menu()

    def card(self) -> None:
        """Build the card, which is hidden without a lesson."""
        with ui.element("div").classes("lesson") as self._card:
            self._card.props["role"], self._card.props["aria-label"] = "group", f"lesson for {self._name}"
            self._title = ui.label().classes("quiet").mark(f"lesson-title-{self._name}")
            self._task = ui.label().classes("task").props("role=status aria-live=polite").mark(f"task-{self._name}")
            breathe()
            self._show = ui.button("Show solution", on_click=partial(self._asides.obey, "show", ""))
            self._show.props(FLAT).mark(f"show-{self._name}").tooltip("lines that solve this task")
            self._next = ui.button(on_click=lambda: self.begin(self._done + 1)).props("dense no-caps")
            self._next.mark(f"next-lesson-{self._name}")
            end = ui.button("End lesson", on_click=self._end).props(FLAT).mark(f"end-lesson-{self._name}")
            end.tooltip("the controller stays as it is")
        self._card.set_visibility(False)

    def _menu(self) -> None:
        button = ui.button("Lessons", icon="school").props(FLAT).classes("lessons-button").mark(f"lessons-{self._name}")
        button.tooltip("six short lessons, from the first command to a repeating sequence")
        with button, ui.menu().classes("lesson-menu"):
            for number in range(1, len(self._course) + 1):
                item = ui.menu_item(on_click=partial(self.begin, number)).props("role=menuitem")
                with item.mark(f"lesson-{self._name}-{number}"):
                    self._titles.append(ui.item_label().mark(f"lesson-name-{self._name}-{number}"))
        self._list()

    @property
    def _setting(self) -> str:
        return f"lessons {self._model}"

    @property
    def _done(self) -> int:
        text = str(self._context.person.settings.get(self._setting, ""))
        return min(int(text), len(self._course)) if text.isascii() and text.isdigit() else 0

    def _list(self) -> None:
        for number, (title, lesson) in enumerate(zip(self._titles, self._course, strict=True), start=1):
            title.text = f"{'✓ ' if number <= self._done else ''}{number}  {lesson.title}"

    def begin(self, number: int) -> Awaitable[None] | None:
        return self._context.move(partial(self._start, number))

    async def _start(self, number: int) -> None:
        session = self._context.session
        await follow(session, self._name, self._all.begin(self._name, number))
        if not session.running:
            session.run()

    def _end(self) -> None:
        self._context.touch(lambda: self._all.end(self._name))

    def refresh(self) -> None:
        found = self._all.of(self._name)
        now = None if found is None else (found[0], found[1].step)
        if now == self._shown:
            return
        self._shown = now
        self._card.set_visibility(found is not None)
        if found is None:
            return
        number, pupil = found
        steps = len(pupil.lesson.steps)
        step = "done" if pupil.finished else f"step {pupil.step + 1} of {steps}"
        self._title.text = f"lesson {number} of {len(self._course)}: {pupil.lesson.title}, {step}"
        if pupil.finished and self._context.drives:
            self._context.person.settings[self._setting] = str(max(self._done, number))
            self._list()
        last = number == len(self._course)
        self._task.text = by_hand(pupil.task) or ("This was the last lesson." if last else "The lesson is done.")
        self._show.set_visibility(not pupil.finished)
        self._next.set_visibility(pupil.finished and not last)
        self._next.text = f"Lesson {number + 1}"
