"""A setting of a machine, and the defects that override the setting while they are active."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

T = TypeVar("T")


@dataclass(eq=False)
class _Value(Generic[T]):
    value: T


class Override(Generic[T]):
    """Setting of a machine, e.g. the motor torque.  A simulated defect can change the setting temporarily.

    `values` holds the normal value, followed by the values of the active defects, the latest at the end.

    `before_change` is called before each change of a value, `on_change` after each change.
    """

    def __init__(
        self, first: T, on_change: Callable[[], None], before_change: Callable[[], None] = lambda: None
    ) -> None:
        self._on_change, self._before_change = on_change, before_change
        self._values = [_Value(first)]

    @property
    def values(self) -> list[T]:
        """The normal value of this setting, followed by one value for each active simulated defect.

        E.g. [1.0, 0.5] for a motor torque of 1.0, which a defect reduces to 0.5.
        """
        return [added.value for added in self._values]

    def set(self, value: T) -> None:
        """Change a setting of the simulated machine, e.g. the ambient temperature from 25 °C to 30 °C.

        Only the normal value changes; the values of active defects stay the same.
        """
        self._before_change()
        self._values[0].value = value
        self._on_change()

    def add(self, value: T) -> Callable[[], None]:
        """Simulate a defect that changes the value of a machine setting, e.g. a defect that halves the motor torque.

        `value`: the value of the setting with this defect, e.g. 0.5.  Return a function that ends the defect.
        """
        added = _Value(value)
        self._before_change()
        self._values.append(added)
        self._on_change()
        return lambda: self._end(added)

    def _end(self, added: _Value[T]) -> None:
        self._before_change()
        self._values.remove(added)
        self._on_change()
