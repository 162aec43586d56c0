"""Something that somebody sets, and that defects change as long as they are there: neither undoes the other."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

T = TypeVar("T")


@dataclass(eq=False)
class _Layer(Generic[T]):
    value: T


class Layers(Generic[T]):
    """What was set is `values[0]`; what each defect brings with it stands behind that, the latest at the end.

    `before_change` is called while all is still as it was, `on_change` when it has changed.
    """

    def __init__(
        self, first: T, on_change: Callable[[], None], before_change: Callable[[], None] = lambda: None
    ) -> None:
        self._on_change, self._before_change = on_change, before_change
        self._layers = [_Layer(first)]

    @property
    def values(self) -> list[T]:
        """All of them."""
        return [layer.value for layer in self._layers]

    def set(self, value: T) -> None:
        """Somebody sets it."""
        self._before_change()
        self._layers[0].value = value
        self._on_change()

    def add(self, value: T) -> Callable[[], None]:
        """A defect begins.  Returns what ends it."""
        layer = _Layer(value)
        self._before_change()
        self._layers.append(layer)
        self._on_change()
        return lambda: self._end(layer)

    def _end(self, layer: _Layer[T]) -> None:
        self._before_change()
        self._layers.remove(layer)
        self._on_change()
