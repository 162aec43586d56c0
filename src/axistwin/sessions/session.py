"""A bench in people's hands: run, paused, stepped, spoken to, and run again up to any moment.

Everything that comes from outside goes through a session, which keeps it with its time; what the bench itself does
(hosts of the scene, its script, planned faults) it does again when it is run again.  So who goes back in time gets a
new bench, on which the same happens up to then; going on, the rest of what has been recorded happens again, and hosts
at the ports wait for it, until somebody does something else: that is where another future begins.
"""

import asyncio
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from logging import getLogger

from axistwin.bench import Bench, endpoints
from axistwin.bench.acts import Do, Say
from axistwin.errors import AxistwinError, UsageError
from axistwin.links.pacing import Pacer
from axistwin.links.server import Server
from axistwin.scenes.scene import Scene
from axistwin.sessions import programs, saving, steps
from axistwin.sessions.breaks import Break
from axistwin.sessions.journal import Journal
from axistwin.sessions.outside import Outside, Repetition
from axistwin.sim.serial_port import Flow
from axistwin.storage import FileStore
from axistwin.units import S, to_ns, to_seconds

log = getLogger("axistwin")

Attach = Callable[[Bench], object]
DRAINED_EVERY = 1 << 12
"""So many passes of the clock."""


class Session:
    """One bench, made by `build`, and what is done to it.

    `speed`: times real time, None as fast as it goes.  `scene`: what `build` builds, for `save`; `served`: without the
    hosts of controllers that have ports.  Used within a running event loop where time passes.
    """

    def __init__(
        self,
        build: Callable[[], Bench],
        speed: float | None = 1.0,
        *,
        scene: Scene | None = None,
        served: bool = False,
    ) -> None:
        self._build, self._scene, self._served = build, scene, served
        self.bench = build()
        """The bench as it is now; another takes its place when somebody goes back in time."""
        self.pacer = Pacer(self.bench.clock, speed)
        self.server: Server | None = None
        """What opens ports to it; see `serve`."""
        self.breaks: list[Break] = []
        """Those that have been added."""
        self.halted_by = ""
        """Why it stands, in words; "" if it has been paused by hand."""
        self.progress: float | None = None
        """How much of the way to another moment is done, 0 to 1; None: it is not on its way."""
        self._outside = Outside(self.pacer)
        self._outside.attach(self.bench)
        self._attached: list[Attach] = []
        self._repetition: Repetition | None = None
        self._recorded_ns = 0
        self._running = self._busy = self._halted = self._caught_up = self._given_up = False
        self._aim: Break | None = None
        self.pacer.watch(self._passed)
        self.pacer.troubled = self._goes_wrong

    @property
    def seconds(self) -> float:
        """Virtual time, in seconds, when the bench was last advanced: it sleeps while nothing is due (`pacer.work`)."""
        return to_seconds(self.bench.now)

    def each_bench(self, attach: Attach) -> None:
        """Call `attach` with the bench there is, and with each that takes its place, before anything happens on it."""
        self._attached.append(attach)
        attach(self.bench)

    def serve(self, *, flow: Flow = Flow.DTR, reset: bool = False) -> Server:
        """A server for hosts at real ports, whose clients stay when another bench takes the place of this one."""
        self.pacer.sync()
        self.server = Server(
            self.bench,
            pacer=self.pacer,
            flow=flow,
            reset=self._power_cycle if reset else False,
            opening=lambda _: self._outside.watch(),
        )
        return self.server

    def client(self, name: str) -> str:
        """Who is connected there from outside; "" if nobody is."""
        return "" if self.server is None else self.server.client(name)

    @property
    def journal(self) -> Journal:
        """What has been done to it from outside."""
        return self._outside.journal

    # Doing something to it

    def do(self, who: str, target: str, value: str) -> None:
        """What `! target value` does in a conversation, to a controller or a line.  Raises AxistwinError."""
        self._do(Do(target, value, controller=who))

    def say(self, name: str, data: bytes) -> None:
        """A host says this to whom it reaches by this name: characters; to a board on a bus, a whole command.

        Raises AxistwinError if nobody is called so, or if it is no command.
        """
        if endpoints.at_a_bus(self.bench, name):
            codec = endpoints.codec_at(self.bench, name)
            codec.read(codec.show(data))  # as it is kept; raises if it cannot be
        else:
            self.bench.port(name)  # raises if there is none
        self._do(Say(data, controller=name))

    def load(self, name: str, filename: str, text: str) -> None:
        """Switch a controller off and on, load a program into it, and start it.

        A SmartMotor's source (.sms) is stored and run; command lines (.if1, .181x) are sent by a host.  Raises
        AxistwinError, for what is wrong in the program with its file, line and column, before anything is done.
        """
        file = programs.checked(self.bench, name, filename, text, self._outside.texts)
        if name in self.bench.ports:
            self.do(name, "drop", "pending")
        self.do(name, "power", "off")
        until_ns = self.bench.now + to_ns(programs.OFF_S)
        self.pacer.by_hand(lambda _: self.bench.clock.run_to(until_ns))
        self._outside.texts[file] = text
        self.do(name, "load", file)

    def _do(self, act: Say | Do) -> None:
        self._check_free()
        do = self._outside.prepared(act)
        self.forget_rest()
        do()

    def _power_cycle(self, name: str) -> None:
        """For a client that wants to find it just switched on."""
        line = self.bench.lines.get(name)
        for motor in (self.bench[name.removesuffix(".rs485")],) if line is None else line.motors:
            for level in ("off", "on"):
                self._outside.prepared(Do("power", level, controller=motor.name))()

    def _check_free(self) -> None:
        if self._busy:
            raise UsageError(f"wait until it is there: it is on its way, at {self.seconds:.3f} s")

    # Time

    @property
    def busy(self) -> bool:
        """Whether it is on its way, by a step or to another moment; nobody can do anything meanwhile."""
        return self._busy

    @property
    def running(self) -> bool:
        """Whether time passes."""
        return self._running

    @property
    def speed(self) -> float | None:
        """Times real time; None: as fast as it goes.  Raises UsageError for what is no speed."""
        return self.pacer.speed

    @speed.setter
    def speed(self, speed: float | None) -> None:
        self.pacer.speed = speed

    def run(self) -> None:
        """Let time pass."""
        self._check_free()
        self.halted_by, self._halted, self._running = "", False, True
        self.pacer.agenda_ns = self.bench.agenda_ns  # who drives wants to see what the scene has in store
        self.pacer.start()

    def pause(self) -> None:
        """Let time stand still, when everything due by now has happened."""
        self._check_free()
        self.pacer.sync()
        self.pacer.stop()
        self._stand("")

    async def step(self, kind: str) -> bool:
        """Go on to the next of a kind, and stand there; returns whether there was one within 60 virtual seconds.

        "event": a nanosecond in which something can be seen: a pin, a character, a message, a fault, a motion that
        begins or ends; "move": such a motion; "statement": a line of a stored program begins.  Raises UsageError.
        """
        self.pause()
        with steps.Watch(self.bench, kind) as watch, self._on_the_way():
            end_ns = self.bench.now + steps.MOST_S * S
            while not (watch.seen or self._halted or self._given_up):
                if not self.pacer.by_hand(partial(self._step, watch, end_ns)):
                    break
                await asyncio.sleep(0)
            return watch.seen

    def add_break(self, sentence: str) -> Break:
        """Stop whenever this comes true, in the middle of anything: "table.X passes 1000".  Raises UsageError."""
        self._check_free()
        self.breaks.append(Break(sentence, self.bench, self._hit))
        return self.breaks[-1]

    def remove_break(self, which: Break) -> None:
        """It stops nothing any more, also if it has been removed before."""
        which.on = False
        self.breaks[:] = [each for each in self.breaks if each is not which]

    def run_until(self, sentence: str) -> None:
        """Run until this comes true, or a break does; then it stands.  Raises UsageError."""
        self._check_free()
        self._aim_at(Break(sentence, self.bench, self._hit, once=True))
        self.run()

    def _step(self, watch: steps.Watch, end_ns: int, over: Callable[[], bool]) -> bool:
        """Returns whether it may be worth while to go on."""
        return steps.go_on(self.bench, end_ns, lambda: watch.seen or self._halted or self._caught_up or over())

    def _hit(self, which: Break) -> None:
        """While something happens: that is where it stands when all has that is due then."""
        self.pacer.stop()
        if not self._halted:
            self._stand(which.sentence if which.once else f"break: {which.sentence}")

    def _goes_wrong(self, error: AxistwinError) -> None:
        """Something that was planned cannot be done: it stands there, unless it is on its way to another moment."""
        log.warning("%s", error)
        if self.progress is None:
            self.pacer.stop()
            self._stand(str(error))

    def _stand(self, why: str) -> None:
        self.halted_by, self._halted, self._running = why, True, False
        self._aim_at(None)

    def _aim_at(self, aim: Break | None) -> None:
        if self._aim is not None:
            self._aim.on = False
        self._aim = aim

    # Back in time

    @property
    def recorded_seconds(self) -> float:
        """How far has been recorded; one can go back to any moment up to there."""
        return to_seconds(self._recorded)

    @property
    def repeating(self) -> bool:
        """Whether what has been recorded happens again; hosts at the ports wait meanwhile."""
        return self._repetition is not None

    def give_up(self) -> None:
        """Stand wherever it has come to, on the way by a step or to another moment."""
        self._given_up = self._busy

    async def go_to(self, seconds: float) -> None:
        """Have everything happen again up to that moment, and stand there.  Raises UsageError for another time."""
        time_ns = to_ns(seconds)
        if not 0 <= time_ns <= self._recorded:
            raise UsageError(f"{seconds:g} s has not been recorded: choose 0 to {self.recorded_seconds:.3f} s")
        self.pause()
        with self._on_the_way():
            if time_ns < self.bench.now:
                self._begin_again()
            await self._bring_to(time_ns)

    def forget_rest(self) -> None:
        """What has been recorded of the time to come will not happen: from here on it is live."""
        self._check_free()
        self.pacer.sync()
        if self._repetition is not None:
            self._repetition.forget_rest()
            self._be_live()

    @property
    def _recorded(self) -> int:
        ns = max(self._recorded_ns, self.bench.now)
        full_ns = self.journal.full_ns
        return ns if full_ns is None else min(ns, max(0, full_ns - 1))

    def _begin_again(self) -> None:
        """Another bench takes the place of this one, on which nothing has happened yet."""
        recorded_ns = self._recorded
        for controller in self.bench.controllers.values():
            if isinstance(controller.store, FileStore):
                controller.store.put_back()
        bench = self._build()  # if that cannot be, hosts are heard as before
        if self.server is not None:
            self.server.deaf = True
        self.bench = bench
        for attach in self._attached:
            attach(self.bench)
        if self.server is not None:
            self.server.exchange(self.bench)
        else:
            self.pacer.exchange(self.bench.clock)
        self._outside.attach(self.bench)
        self._recorded_ns = recorded_ns
        self._repetition = Repetition(self.bench.clock, self.journal, self._outside.again, recorded_ns, self._catch_up)

    async def _bring_to(self, time_ns: int) -> None:
        """Breaks do not count on the way."""
        since_ns = self.bench.now
        for each in self.breaks:
            each.rest()
        try:
            while not (self._is_at(time_ns) or self._given_up):
                self.progress = (self.bench.now - since_ns) / max(1, time_ns - since_ns)
                self.pacer.by_hand(partial(steps.run_to, self.bench.clock, time_ns))
                await asyncio.sleep(0)
        finally:
            for each in self.breaks:
                each.go_on(self.bench)

    def _is_at(self, time_ns: int) -> bool:
        """Whether all has happened that was done by then."""
        waits = self._repetition is not None and self._repetition.happens_by(time_ns)
        return self.bench.now == time_ns and not waits

    @contextmanager
    def _on_the_way(self) -> Iterator[None]:
        """Nobody does anything meanwhile."""
        self._busy, self._halted, self._given_up = True, False, False
        try:
            yield
        finally:
            self._busy, self.progress = False, None

    def _catch_up(self) -> None:
        """While something happens: all that was recorded has happened."""
        self._caught_up = True
        self.pacer.speed = self.pacer.speed  # it comes up for air

    def _passed(self) -> None:
        """The bench has been advanced."""
        if self._caught_up:
            self._be_live()
        if self.pacer.passes % DRAINED_EVERY == 0:
            self._drain()

    def _drain(self) -> None:
        """What nobody is connected to hear is lost, as with nobody at the other end of the cable."""
        for name, port in self.bench.ports.items():
            if not self.client(name):
                port.read()

    def _be_live(self) -> None:
        """Outside hosts are heard again; what they have missed is made up for."""
        self._repetition, self._caught_up, self._recorded_ns = None, False, self.bench.now
        if self.server is not None:
            self.server.deaf = False

    # Keeping it

    def save(self) -> dict[str, str]:
        """A scene that repeats all that has been recorded, by `axistwin run`: the texts of its files, by name."""
        texts, end_ns = self._outside.texts, self._recorded
        return saving.files(self._scene, self._served, self.bench, self.journal, texts, end_ns)
