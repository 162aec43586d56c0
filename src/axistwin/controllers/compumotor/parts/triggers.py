"""Trigger inputs 1 and 6, which interrupt the processor on a rising edge."""

from collections.abc import Callable
from functools import partial

from axistwin.core.units import MS
from axistwin.sim.clock import Clock, Event
from axistwin.sim.pins import Pin

LOW_BEFORE_NS = 2 * MS  # Time for which a trigger must have been low before a rising edge has an effect.


class Triggers:
    """The functions of triggers 1 and 6."""

    def __init__(self, clock: Clock, pins: dict[int, Pin], response_ns: dict[int, int]) -> None:
        """Observe the inputs `pins`.  `response_ns`: time in ns for which an input must stay high."""
        self.clock, self._response_ns = clock, response_ns
        self._functions: dict[int, tuple[int, Callable[[], None]]] = {}
        """Actions that the host has assigned to trigger inputs.

        Key: number of the trigger input.  Value: opcode of the command that assigned the action, and a function that
        performs the action.
        """
        self._fell_ns = dict.fromkeys(pins, -LOW_BEFORE_NS)
        self._edges: dict[int, Event] = {}
        self._unsubscribe = [pin.subscribe(partial(self._changed, number)) for number, pin in pins.items()]

    def close(self) -> None:
        for unsubscribe in self._unsubscribe:
            unsubscribe()
        self.clear()

    def clear(self) -> None:
        self._functions.clear()
        self._edges.clear()

    def assign(self, trigger: int, opcode: int, action: Callable[[], None], on: bool) -> int | None:
        """Assign `action` to a trigger input for the command `opcode`, or remove it if `on` is False.

        No effect while the trigger has an action of a different opcode; then that opcode is returned.
        """
        assigned = self._functions.get(trigger, (opcode,))[0]
        if assigned != opcode:
            return assigned
        if on:
            self._functions[trigger] = opcode, action
        else:
            self._functions.pop(trigger, None)
        return None

    def drop(self, opcode: int) -> None:
        self._functions = {t: f for t, f in self._functions.items() if f[0] != opcode}

    def edge(self, trigger: int) -> Event:
        """Return the event that happens at the trigger's next valid edge."""
        if trigger not in self._edges:
            self._edges[trigger] = self.clock.event()
        return self._edges[trigger]

    def _changed(self, trigger: int, pin: Pin) -> None:
        now_ns = self.clock.now
        if not pin.level:
            self._fell_ns[trigger] = now_ns
        elif now_ns - self._fell_ns[trigger] >= LOW_BEFORE_NS:
            self.clock.call_later(self._response_ns[trigger], partial(self._respond, trigger, self._fell_ns[trigger]))

    def _respond(self, trigger: int, fell_ns: int) -> None:
        if self._fell_ns[trigger] != fell_ns:  # The trigger pulse was too short to have an effect.
            return
        if (waiting := self._edges.pop(trigger, None)) is not None:
            waiting.succeed()
        if trigger in self._functions:
            self._functions[trigger][1]()
