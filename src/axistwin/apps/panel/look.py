"""Somebody who looks at the bench: one page in one browser."""

from collections.abc import Awaitable, Callable

from nicegui import ui

from axistwin.apps.panel.people import People, Person
from axistwin.apps.panel.talk import Talk
from axistwin.apps.sessions.session import Session
from axistwin.bench import Bench
from axistwin.errors import AxistwinError

Refresh = Callable[[], None]
"""Brings a view up to date."""


class Look:
    """What a view is given: the session, and who looks at it."""

    def __init__(self, session: Session, people: People, talk: Talk, person: Person) -> None:
        self.session, self.people, self.talk, self.person = session, people, talk, person

    @property
    def bench(self) -> Bench:
        """The bench as it is now."""
        return self.session.bench

    @property
    def drives(self) -> bool:
        """Whether this person may touch things."""
        return self.people.driver is self.person

    def touch(self, act: Callable[[], object]) -> bool:
        """Do something to the bench if this person drives; what is wrong is told.  Returns whether it was done."""
        if not self._may():
            return False
        try:
            act()
        except AxistwinError as error:
            _complain(error)
            return False
        return True

    async def wait_for(self, act: Callable[[], Awaitable[object]]) -> object:
        """The same for what takes a while; returns what it returns, None if it was not done."""
        if not self._may():
            return None
        try:
            return await act()
        except AxistwinError as error:
            _complain(error)
            return None

    def _may(self) -> bool:
        if not self.drives:
            ui.notify(f"{self.people.driver_name} drives: press Drive to take over", type="warning")
        return self.drives


def _complain(error: AxistwinError) -> None:
    ui.notify(str(error), type="negative", multi_line=True)
