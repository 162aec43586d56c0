"""The users of a panel, and the driver among them."""

from collections.abc import Callable
from dataclasses import dataclass, field
from time import monotonic

from axistwin.sim.signal import Signal

GONE_S = 10.0  # Seconds of absence after which the driver can be replaced by the next user who opens a page.
FORGOTTEN_S, REMEMBERED = 600.0, 100  # Absent users are deleted after so many seconds; largest number of absent users.
LONGEST_NAME = 30


@dataclass(eq=False)
class Person:
    """One user of the panel.  A cookie in the user's browser contains the key that identifies the user."""

    key: str
    name: str
    pages: int = 0  # Number of connected pages.
    left_s: float = field(default_factory=monotonic)  # Time at which a page was last disconnected.
    lines: dict[str, list[str]] = field(default_factory=dict)  # Lines that the user has typed, by terminal.
    ending: str = "usual"  # Terminator of typed lines; usual: that of the model.
    settings: dict[str, object] = field(default_factory=dict)

    def came(self) -> None:
        self.pages += 1

    def left(self) -> None:
        self.pages -= 1
        self.left_s = monotonic()

    @property
    def gone(self) -> bool:
        return not self.pages and monotonic() - self.left_s > GONE_S


class People:
    """All users of a panel; the first user is the driver until another user becomes the driver."""

    def __init__(self) -> None:
        self._all: dict[str, Person] = {}
        self._came = 0
        self._messages: Signal[str] = Signal()
        self.driver: Person | None = None

    def __getitem__(self, key: str) -> Person:
        """Return the user with this key, or a new user; the user becomes the driver if the driver is absent."""
        self._forget()
        if key not in self._all:
            self._came += 1
            self._all[key] = Person(key, f"visitor {self._came}")
        person = self._all[key]
        if self.driver is None or (self.driver is not person and self.driver.gone):
            self.driver = person
        return person

    def _forget(self) -> None:
        away = sorted((each for each in self._all.values() if each.gone), key=lambda each: each.left_s)
        surplus = len(away) - REMEMBERED
        for number, person in enumerate(away):
            if number < surplus or monotonic() - person.left_s > FORGOTTEN_S:
                del self._all[person.key]
                if self.driver is person:
                    self.driver = None

    @property
    def there(self) -> list[Person]:
        return [person for person in self._all.values() if person.pages]

    @property
    def driver_name(self) -> str:
        """Name of the user who controls the session; "nobody" if no user controls the session."""
        return self.driver.name if self.driver else "nobody"

    def take_over(self, person: Person) -> None:
        if self.driver is not person:
            self.driver = person
            self.notify(f"{person.name} drives now")

    def rename(self, person: Person, name: str) -> None:
        """Rename a user; an empty name has no effect."""
        person.name = " ".join(name.split())[:LONGEST_NAME] or person.name

    def subscribe(self, observer: Callable[[str], None]) -> Callable[[], None]:
        """Call `observer` with each message that is sent to all users; return an unsubscribe function."""
        return self._messages.subscribe(observer)

    def notify(self, text: str) -> None:
        self._messages.emit(text)
