"""The context of a user's page: the session, the user, and the user's actions."""

from collections.abc import Awaitable, Callable
from logging import getLogger
from typing import TypeVar, cast

from nicegui import ui

from axistwin.bench import Bench
from axistwin.core.errors import AxistwinError
from axistwin.scenes.sessions.session import Session
from axistwin.ui.panel.actions import ActionQueue, State
from axistwin.ui.panel.comparison import Comparison
from axistwin.ui.panel.people import People, Person

log = getLogger("axistwin")

Thing = TypeVar("Thing")
Refresh = Callable[[], None]


def careful(view: Refresh) -> Refresh:
    failing = False

    def refresh() -> None:
        nonlocal failing
        try:
            view()
        except Exception:
            if not failing:
                log.exception("a view of the panel cannot be updated")
            failing = True
        else:
            failing = False

    return refresh


def together(*views: Refresh) -> Refresh:
    def refresh() -> None:
        for each in views:
            each()

    return refresh


def seldom(context: "Context", every: int, view: Refresh) -> Refresh:
    """Return a view that is updated in every n-th frame (`every`) while virtual time passes, else in each frame."""
    frame = 0

    def refresh() -> None:
        nonlocal frame
        frame += 1
        if frame % every == 0 or context.actions.state is not State.RUNNING:
            view()

    return refresh


class Common:
    """Objects that all open web pages of a simulation share, e.g. the oscilloscope's recorder."""

    def __init__(self, session: Session, comparison: Comparison | None = None) -> None:
        self.session, self.comparison = session, comparison
        self._made: dict[object, object] = {}

    def __call__(self, make: Callable[[Session], Thing]) -> Thing:
        """Return the object that `make(session)` creates; all calls return the same object."""
        if make not in self._made:
            self._made[make] = make(self.session)
        return cast("Thing", self._made[make])


class Context:
    """Context of a view: the session, the objects that all pages share, and the page's user."""

    def __init__(self, common: Common, people: People, person: Person) -> None:
        self.session, self.common, self.people, self.person = common.session, common, people, person
        self.comparison = common.comparison  # A machine beside the bench; the page can then only be looked at.
        self.unbuilt: list[Refresh] = []  # Functions that build newly opened tabs, once each, before the next frame.
        self.actions = common(ActionQueue)

    @property
    def bench(self) -> Bench:
        return self.session.bench

    @property
    def drives(self) -> bool:
        return self.comparison is None and self.people.driver is self.person

    def touch(self, action: Callable[[], object], *, now: bool = False) -> bool:
        """Perform an action on the session if the user of this page may control the session.

        During a step or a `go_to`, the action waits in the queue, unless `now`.  Errors are shown on the page.  Returns
        False if the user is not the driver, or if the action has failed at once.
        """
        if not self._may():
            return False
        client, accepted = ui.context.client, True

        def attempt() -> None:
            nonlocal accepted
            try:
                with client:
                    action()
            except AxistwinError as error:
                accepted = False
                with client:
                    complain(error)

        if now:
            attempt()
        else:
            self.actions.do(attempt)
        return accepted

    def move(
        self, begin: Callable[[], Awaitable[object]], done: Callable[[object], None] = lambda _: None
    ) -> Awaitable[None] | None:
        """Begin a step or `go_to` if this user drives; `done` gets the result.  Errors appear on the page."""
        return self._move(self.actions.move(begin), done) if self._may() else None

    async def _move(self, move: Awaitable[object], done: Callable[[object], None]) -> None:
        try:
            done(await move)
        except AxistwinError as error:
            complain(error)

    def _may(self) -> bool:
        if self.comparison is not None:
            ui.notify("this page only shows: neither the twin nor the machine can be acted on", type="warning")
        elif not self.drives:
            ui.notify(f"{self.people.driver_name} drives: press Drive to take over", type="warning")
        return self.drives


def complain(error: AxistwinError) -> None:
    ui.notify(str(error), type="negative", multi_line=True)
