"""Who looks at the bench, and who drives it."""

from collections.abc import Callable
from dataclasses import dataclass, field
from time import monotonic

GONE_S = 10.0
"""Whoever drives and has been away for so long may be replaced without a word."""
FORGOTTEN_S, REMEMBERED = 600.0, 100
"""Whoever has been away for so long is forgotten; and of more than so many who are away, those who left first."""
LONGEST_NAME = 30


@dataclass(eq=False)
class Person:
    """One browser, which is known again when it comes back."""

    key: str
    name: str
    pages: int = 0
    """How many pages it has open, as far as they are connected."""
    left_s: float = field(default_factory=monotonic)
    """When it was last seen: it closed its last page, or has lost its connection."""
    lines: dict[str, list[str]] = field(default_factory=dict)
    """What was typed at each terminal."""
    ending: str = "CR"
    """What ends a line that is typed."""
    settings: dict[str, object] = field(default_factory=dict)
    """How its views are set, by view."""

    def came(self) -> None:
        """Opened a page, or is connected again."""
        self.pages += 1

    def left(self) -> None:
        """Closed one, or has lost the connection to it."""
        self.pages -= 1
        self.left_s = monotonic()

    @property
    def gone(self) -> bool:
        """Whether it is not coming back, as far as one can tell."""
        return not self.pages and monotonic() - self.left_s > GONE_S


class People:
    """Everybody who has come; the first drives until another takes over."""

    def __init__(self) -> None:
        self._all: dict[str, Person] = {}
        self._came = 0
        self._listeners: list[Callable[[str], None]] = []
        self.driver: Person | None = None

    def __getitem__(self, key: str) -> Person:
        """Whoever has this key; somebody who is new is welcome, and the first to come drives."""
        self._forget()
        if key not in self._all:
            self._came += 1
            self._all[key] = Person(key, f"visitor {self._came}")
        person = self._all[key]
        if self.driver is None or (self.driver is not person and self.driver.gone):
            self.driver = person
        return person

    def _forget(self) -> None:
        """Those who are not coming back."""
        away = sorted((each for each in self._all.values() if each.gone), key=lambda each: each.left_s)
        surplus = len(away) - REMEMBERED
        for number, person in enumerate(away):
            if number < surplus or monotonic() - person.left_s > FORGOTTEN_S:
                del self._all[person.key]
                if self.driver is person:
                    self.driver = None

    @property
    def there(self) -> list[Person]:
        """Those who look on now."""
        return [person for person in self._all.values() if person.pages]

    @property
    def driver_name(self) -> str:
        """Who drives."""
        return self.driver.name if self.driver else "nobody"

    def take_over(self, person: Person) -> None:
        """From now on this person drives; everybody is told."""
        if self.driver is not person:
            self.driver = person
            self.tell(f"{person.name} drives now")

    def rename(self, person: Person, name: str) -> None:
        """Call a person so; an empty name changes nothing."""
        person.name = " ".join(name.split())[:LONGEST_NAME] or person.name

    def listen(self, listener: Callable[[str], None]) -> Callable[[], None]:
        """Call `listener` with what everybody is told.  Returns what ends it."""
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener)

    def tell(self, words: str) -> None:
        """Tell everybody."""
        for listener in tuple(self._listeners):
            listener(words)
