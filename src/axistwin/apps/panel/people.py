"""Who looks at the bench, and who drives it."""

from dataclasses import dataclass, field


@dataclass(eq=False)
class Person:
    """One browser, which is known again after it has been reloaded."""

    key: str
    name: str
    pages: int = 0
    """How many pages it has open."""
    settings: dict[str, object] = field(default_factory=dict)
    """How its views are set, by view."""


class People:
    """Everybody who has come; the first drives until another takes over."""

    def __init__(self) -> None:
        self._all: dict[str, Person] = {}
        self.driver: Person | None = None

    def __getitem__(self, key: str) -> Person:
        """Whoever has this key; somebody who is new is welcome."""
        if key not in self._all:
            self._all[key] = Person(key, f"visitor {len(self._all) + 1}")
        person = self._all[key]
        self.driver = self.driver or person
        return person

    @property
    def there(self) -> list[Person]:
        """Those who look on now."""
        return [person for person in self._all.values() if person.pages]

    @property
    def driver_name(self) -> str:
        """Who drives."""
        return self.driver.name if self.driver else "nobody"
