"""A user's page: the session, its user, and acts of the user."""

from collections.abc import Awaitable, Callable
from logging import getLogger
from typing import TypeVar, cast

from nicegui import ui

from axistwin.bench import Bench
from axistwin.errors import AxistwinError
from axistwin.panel.actions import ActionQueue, State
from axistwin.panel.people import People, Person
from axistwin.sessions.session import Session

log = getLogger("axistwin")

Thing = TypeVar("Thing")
Refresh = Callable[[], None]


def careful(view: Refresh) -> Refresh:
    """Return a view whose defects are logged, once until the view works again; other views of the page continue."""
    failing = False

    def refresh() -> None:
        nonlocal failing
        try:
            view()
        except Exception:
            if not failing:
                log.exception("a view of the panel cannot be brought up to date")
            failing = True
        else:
            failing = False

    return refresh


def together(*views: Refresh) -> Refresh:
    """Return one view of several."""

    def refresh() -> None:
        for each in views:
            each()

    return refresh


def seldom(context: "Context", every: int, view: Refresh) -> Refresh:
    """Return a view that is updated in one frame of `every` while virtual time passes, else in all frames."""
    frame = 0

    def refresh() -> None:
        nonlocal frame
        frame += 1
        if frame % every == 0 or context.actions.state is not State.RUNNING:
            view()

    return refresh


class Common:
    """Objects that all pages of one session share."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self._made: dict[object, object] = {}

    def __call__(self, make: Callable[[Session], Thing]) -> Thing:
        """Return `make(session)`, created at the first call."""
        if make not in self._made:
            self._made[make] = make(self.session)
        return cast("Thing", self._made[make])


class Context:
    """Context of a view: the session, the objects that all pages share, and the page's user."""

    def __init__(self, common: Common, people: People, person: Person) -> None:
        self.session, self.common, self.people, self.person = common.session, common, people, person
        self.unbuilt: list[Refresh] = []
        """Functions that build parts of the page that have become visible; called once, before the next frame."""
        self.actions = common(ActionQueue)

    @property
    def bench(self) -> Bench:
        """The present bench."""
        return self.session.bench

    @property
    def drives(self) -> bool:
        """True if this user is the driver."""
        return self.people.driver is self.person

    def touch(self, act: Callable[[], object], *, now: bool = False) -> bool:
        """Perform an act on the session if this user drives; an error is shown.

        During a step or a `go_to`, the act waits for its end, unless `now`.  Returns True if the act is accepted.
        """
        if not self._may():
            return False
        client, accepted = ui.context.client, True

        def attempt() -> None:
            nonlocal accepted
            try:
                with client:
                    act()
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
        """Begin a step or a `go_to` if this user drives, and call `done` with the result; an error is shown."""
        return self._move(self.actions.move(begin), done) if self._may() else None

    async def _move(self, move: Awaitable[object], done: Callable[[object], None]) -> None:
        try:
            done(await move)
        except AxistwinError as error:
            complain(error)

    def _may(self) -> bool:
        if not self.drives:
            ui.notify(f"{self.people.driver_name} drives: press Drive to take over", type="warning")
        return self.drives


def complain(error: AxistwinError) -> None:
    """Show an error to the user."""
    ui.notify(str(error), type="negative", multi_line=True)
