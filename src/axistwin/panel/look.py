"""Somebody who looks at the bench: one page in one browser."""

from collections.abc import Awaitable, Callable
from logging import getLogger
from typing import TypeVar, cast

from nicegui import ui

from axistwin.bench import Bench
from axistwin.errors import AxistwinError
from axistwin.panel.acts import Acts, State
from axistwin.panel.people import People, Person
from axistwin.sessions.session import Session

log = getLogger("axistwin")

Thing = TypeVar("Thing")
Refresh = Callable[[], None]
"""Brings a view up to date."""


def careful(view: Refresh) -> Refresh:
    """The same view; a defect in it is reported, once until it is mended, and the page's other views go on."""
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
    """One view of several."""

    def refresh() -> None:
        for each in views:
            each()

    return refresh


def seldom(look: "Look", every: int, view: Refresh) -> Refresh:
    """The same view, updated in one frame of `every` while virtual time passes, else in all frames."""
    frame = 0

    def refresh() -> None:
        nonlocal frame
        frame += 1
        if frame % every == 0 or look.acts.state is not State.RUNNING:
            view()

    return refresh


class Common:
    """What all who look at one session have in common."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self._made: dict[object, object] = {}

    def __call__(self, make: Callable[[Session], Thing]) -> Thing:
        """What `make` makes of the session, made for whoever is the first to ask."""
        if make not in self._made:
            self._made[make] = make(self.session)
        return cast("Thing", self._made[make])


class Look:
    """What a view is given: the session, what all who look at it have in common, and who looks at it."""

    def __init__(self, common: Common, people: People, person: Person) -> None:
        self.session, self.common, self.people, self.person = common.session, common, people, person
        self.unbuilt: list[Refresh] = []
        """What builds parts of the page that have come into view; the page calls each once, before its next frame."""
        self.acts = common(Acts)

    @property
    def bench(self) -> Bench:
        """The bench as it is now."""
        return self.session.bench

    @property
    def drives(self) -> bool:
        """Whether this person may touch things."""
        return self.people.driver is self.person

    def touch(self, act: Callable[[], object], *, now: bool = False) -> bool:
        """Perform an act on the session if this person drives; an error is shown.

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
                    _complain(error)

        if now:
            attempt()
        else:
            self.acts.do(attempt)
        return accepted

    def move(
        self, begin: Callable[[], Awaitable[object]], done: Callable[[object], None] = lambda _: None
    ) -> Awaitable[None] | None:
        """Begin a step or a `go_to` if this person drives, and call `done` with its result; an error is shown."""
        return self._move(self.acts.move(begin), done) if self._may() else None

    async def _move(self, move: Awaitable[object], done: Callable[[object], None]) -> None:
        try:
            done(await move)
        except AxistwinError as error:
            _complain(error)

    def _may(self) -> bool:
        if not self.drives:
            ui.notify(f"{self.people.driver_name} drives: press Drive to take over", type="warning")
        return self.drives


def _complain(error: AxistwinError) -> None:
    ui.notify(str(error), type="negative", multi_line=True)
