"""A setting of a machine, and the defects that override the setting while they are active."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

T = TypeVar("T")


@dataclass(eq=False)
class _Value(Generic[T]):
    value: T


class Override(Generic[T]):
    """`values`: first the setting, then the values of the present defects, the latest at the end.

    `before_change` is called before each change, `on_change` after it.
    """

    def __init__(
        self, first: T, on_change: Callable[[], None], before_change: Callable[[], None] = lambda: None
    ) -> None:
        self._on_change, self._before_change = on_change, before_change
        self._values = [_Value(first)]

    @property
    def values(self) -> list[T]:
        """The setting, followed by the values of all active defects."""
        return [added.value for added in self._values]

    def set(self, value: T) -> None:
        """Change the setting; an active defect still overrides it."""
        self._before_change()
        self._values[0].value = value
        self._on_change()

    def add(self, value: T) -> Callable[[], None]:
        """Add the value of a defect.  Return a function that ends the defect."""
        added = _Value(value)
        self._before_change()
        self._values.append(added)
        self._on_change()
        return lambda: self._end(added)

    def _end(self, added: _Value[T]) -> None:
        self._before_change()
        self._values.remove(added)
        self._on_change()
