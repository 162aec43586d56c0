"""Perform the actions of a conversation on a bench: data from a host, and manual actions (`!`).

On a bus, `>` sends whole commands through an attendant: a host that does the handshakes and takes the messages.  The
attendant stops when an action accesses the registers directly (`! write 0 33 00`), because a board can have only one
host at a time.
"""

from collections.abc import Callable
from functools import partial

from axistwin.bench.actions import BUS_ACTS, act_at
from axistwin.bench.acts import Do, Say
from axistwin.bench.bench import Bench
from axistwin.core.errors import UsageError
from axistwin.sim.manual_actions import by_itself

LOAD = "load"
Load = Callable[[str, str], Callable[[], object]]  # Prepares to load a program; controller's name and file.


def no_programs(controller: str, file: str) -> Callable[[], object]:
    """Raise UsageError: the default of `ActionRunner`, for a bench that cannot load programs."""
    raise UsageError(
        f"an FMU cannot load the program {file} into the controller {controller}: "
        f'name the program in the scene file instead, e.g. program = "{file}"'
    )


class ActionRunner:
    """Performs actions on one bench.  `load`: function for programs.  `own`: True for actions of a scene's script."""

    def __init__(self, bench: Bench, load: Load = no_programs, *, own: bool = False) -> None:
        self.bench, self._load, self._own = bench, load, own

    def prepare(self, act: Say | Do) -> Callable[[], object]:
        """Check an action, and return a function that performs it.  Raises AxistwinError for an invalid action."""
        do = self._prepared(act)
        return partial(self._do_by_itself, do) if self._own else do

    def _do_by_itself(self, do: Callable[[], object]) -> None:
        with by_itself(self.bench.clock):
            do()

    def _prepared(self, act: Say | Do) -> Callable[[], object]:
        match act:
            case Say():
                return partial(self._say, act.controller, act.data)
            case Do() if act.target == LOAD:
                return self._load(act.controller, act.value)
        do = act_at(self.bench, act.controller, act.target, act.value)
        return partial(self._by_hand, act.controller, do) if act.target in BUS_ACTS else do

    def leave(self, name: str) -> None:
        """Disconnect the simulated host from a board on a bus.  An action can then access the registers directly."""
        if name in self.bench.attendants:
            self.bench.attendants.pop(name).close()

    def _say(self, name: str, data: bytes) -> None:
        attend = self.bench[name].product.attend if name in self.bench.controllers else None
        if attend is None:
            self.bench.port(name).write(data)
            return
        if name not in self.bench.attendants:
            self.bench.attendants[name] = attend(self.bench[name].bus)
            # Read every message of the board, because an unread message blocks the next message.
            self.bench.attendants[name].subscribe_received(lambda _: None)
        self.bench.attendants[name].write(data)

    def _by_hand(self, name: str, do: Callable[[], object]) -> None:
        self.leave(name)
        do()
