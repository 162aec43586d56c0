"""Somebody who looks at the bench: one page in one browser."""

from collections.abc import Callable
from typing import TypeVar, cast

from nicegui import ui

from axistwin.apps.panel.people import People, Person
from axistwin.apps.sessions.session import Session
from axistwin.bench import Bench
from axistwin.errors import AxistwinError

Thing = TypeVar("Thing")
Refresh = Callable[[], None]
"""Brings a view up to date."""


class Look:
    """What a view is given: the session, and who looks at it."""

    def __init__(self, session: Session, people: People, person: Person) -> None:
        self.session, self.people, self.person = session, people, person

    @property
    def bench(self) -> Bench:
        """The bench as it is now."""
        return self.session.bench

    def common(self, make: Callable[[Session], Thing]) -> Thing:
        """What all who look at this session have in common, made for the first of them."""
        if make not in self.people.common:
            self.people.common[make] = make(self.session)
        return cast("Thing", self.people.common[make])

    @property
    def drives(self) -> bool:
        """Whether this person may touch things."""
        return self.people.driver is self.person

    def touch(self, act: Callable[[], object]) -> bool:
        """Do something to the bench if this person drives; what is wrong is told.  Returns whether it was done."""
        if not self.drives:
            ui.notify(f"{self.people.driver_name} drives: press Drive to take over", type="warning")
            return False
        try:
            act()
        except AxistwinError as error:
            ui.notify(str(error), type="negative", multi_line=True)
            return False
        return True
