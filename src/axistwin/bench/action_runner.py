"""Somebody who does acts on a bench as they come: a host that says things, people who do what stands behind `!`.

At a bus whole commands are said (`>`) by an attendant, who does the handshake and takes the messages from then on,
until somebody works the registers by hand (`! write 0 33 00`): a board has one host at a time.
"""

from collections.abc import Callable
from functools import partial

from axistwin.bench.actions import BUS_ACTS, act_at
from axistwin.bench.acts import Do, Say
from axistwin.bench.bench import Bench
from axistwin.errors import UsageError
from axistwin.sim.by_hand import by_itself

LOAD = "load"
Load = Callable[[str, str], Callable[[], object]]
"""Prepares that a program is loaded: into whom, and its file.  Raises AxistwinError."""


def no_programs(who: str, file: str) -> Callable[[], object]:
    """Where there are none to be loaded.  Raises UsageError."""
    raise UsageError(f"{file} cannot be loaded into {who} here: let a scene do it")


class Hands:
    """Does acts on one bench.  `load`: where programs come from.  `own`: the bench does them by itself, in a scene."""

    def __init__(self, bench: Bench, load: Load = no_programs, *, own: bool = False) -> None:
        self.bench, self._load, self._own = bench, load, own

    def prepare(self, act: Say | Do) -> Callable[[], object]:
        """The act as something to call; what cannot be done is found now.  Raises AxistwinError."""
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
        """The attendant of this board, if there is one, leaves its registers alone."""
        if name in self.bench.attendants:
            self.bench.attendants.pop(name).close()

    def _say(self, name: str, data: bytes) -> None:
        attend = self.bench[name].product.attend if name in self.bench.controllers else None
        if attend is None:
            self.bench.port(name).write(data)
            return
        if name not in self.bench.attendants:
            self.bench.attendants[name] = attend(self.bench[name].bus)
            self.bench.attendants[name].hear(lambda _: None)  # it is read, so that the next one can come
        self.bench.attendants[name].write(data)

    def _by_hand(self, name: str, do: Callable[[], object]) -> None:
        self.leave(name)
        do()
