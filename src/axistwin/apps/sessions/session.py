"""A bench in people's hands: run, paused, stepped, spoken to, and run again up to any moment.

Everything that comes from outside goes through a session, which keeps it with its time; what the bench itself does
(hosts of the scene, its script, planned faults) it does again when it is run again.
"""

from collections.abc import Callable

from axistwin.apps.conversations import machine
from axistwin.apps.conversations.host import Host, host_at
from axistwin.bench import Bench
from axistwin.links.pacing import Pacer
from axistwin.units import to_seconds

Attach = Callable[[Bench], object]


class Session:
    """One bench, made by `build`, and what is done to it."""

    def __init__(self, build: Callable[[], Bench], speed: float | None = 1.0) -> None:
        self._build = build
        self.bench = build()
        """The bench as it is now; another takes its place when somebody goes back in time."""
        self.pacer = Pacer(self.bench.clock, speed)
        self._attached: list[Attach] = []
        self._hosts: dict[str, Host] = {}

    @property
    def seconds(self) -> float:
        """Virtual time, in seconds."""
        return to_seconds(self.bench.now)

    def each_bench(self, attach: Attach) -> None:
        """Call `attach` with the bench there is, and with each that takes its place, before anything happens on it."""
        self._attached.append(attach)
        attach(self.bench)

    # Doing something to it

    def do(self, who: str, target: str, value: str) -> None:
        """What `! target value` does in a conversation, to a controller or a line.  Raises AxistwinError."""
        act = machine.action(self.bench[who], target, value)
        self.pacer.sync()
        act()
        self.pacer.work()

    def say(self, name: str, data: bytes) -> None:
        """A host says this to whom it reaches by this name: characters; to a board on a bus, a whole command."""
        self.pacer.sync()
        if name not in self._hosts:
            self._hosts[name] = host_at(self.bench, name).__enter__()
        self._hosts[name].write(data)
        self.pacer.work()

    # Time

    @property
    def running(self) -> bool:
        """Whether time passes."""
        return self._running

    _running = False

    @property
    def speed(self) -> float | None:
        """Times real time; None: as fast as it goes."""
        return self.pacer.speed

    @speed.setter
    def speed(self, speed: float | None) -> None:
        was = self._running
        self.pause()
        self.pacer.speed = speed
        if was:
            self.run()

    def run(self) -> None:
        """Let time pass."""
        self._running = True
        self.pacer.start()

    def pause(self) -> None:
        """Let time stand still, when everything due by now has happened."""
        self.pacer.sync()
        self._running = False
        self.pacer.stop()

    halted_by = ""
    progress = None
    repeating = False
    recorded_seconds = 100.0
    breaks = []

    def client(self, name):
        return ""

    def forget_rest(self):
        pass

    async def step(self, kind):
        return False

    async def go_to(self, s):
        pass

    def add_break(self, s):
        self.breaks.append(Break(s))

    def remove_break(self, b):
        self.breaks.remove(b)

    def run_until(self, s):
        pass

    def save(self):
        return {"scene.toml": "x"}

    def serve(self, server):
        self.server = server


class Break:
    def __init__(self, s):
        self.sentence, self.on, self.hits = s, True, 0
