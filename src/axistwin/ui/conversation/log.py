"""The list of a conversation: messages, acts at the machine and faults in order, each with the notes below it."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from axistwin.bench import Bench, endpoints
from axistwin.bench.codec import Codec, unpadded, word
from axistwin.bench.events import Event, FaultChanged, LineBreak, ManualAction, Received, Sent, observing
from axistwin.core.units import MS, to_seconds
from axistwin.scenes.sessions.session import Session
from axistwin.ui.conversation import notes
from axistwin.ui.conversation.acts import Told, alarm, planned, told_of

KEPT = 20_000  # Largest number of events that wait until a page reads the list; each character is an event.
MOST_ENTRIES = 4_000  # Largest number of entries of an endpoint.
PAUSE_NS = 50 * MS  # Longest pause within one message of characters.
HOST, DEVICE, ACT, FAULT, QUESTION = ">", "<", "·", "!", "?"
CR, LF = b"\r", b"\n"

_Act = ManualAction | FaultChanged


@dataclass(frozen=True)
class _Alarm:
    """An alarm of a controller; without `flag`, an act of the scene's script."""

    time_ns: int
    controller: str
    flag: str


@dataclass(eq=False)
class Entry:
    """One line of the list.  `parts`: texts, each with its kind: "", "control", "wrong" or "quiet"."""

    number: int
    time_ns: int
    who: str
    parts: list[tuple[str, str]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    data: bytes = b""
    held: bool = False  # True for a typed line that the controller has not received yet.

    @property
    def text(self) -> str:
        return "".join(f"<{text}>" if kind == "control" else text for text, kind in self.parts)

    def shown(self) -> dict[str, Any]:
        """Return the entry as data for the page."""
        return {
            "number": self.number, "time": f"{to_seconds(self.time_ns):.6f}", "who": self.who, "parts": self.parts,
            "notes": [notes.parts(note) for note in self.notes], "held": self.held,
        }  # fmt: skip


class _Thread:
    """The entries of one endpoint."""

    def __init__(self, codec: Codec, whole: bool) -> None:
        self.codec, self.whole = codec, whole
        self.entries: deque[Entry] = deque(maxlen=MOST_ENTRIES)
        self.changes: deque[tuple[int, Entry]] = deque(maxlen=MOST_ENTRIES)
        self.count, self.number = 0, 0  # Number of changes, and of entries.
        self.lost = 0  # Number of the last change that is no longer known.
        self.open: Entry | None = None  # The entry that further characters continue.
        self.last_ns = 0  # Time of its last character.
        self.typed: deque[Entry] = deque()  # Lines that the controller has not received yet.

    def add(self, time_ns: int, who: str, parts: Iterable[tuple[str, str]] = (), data: bytes = b"") -> Entry:
        self.number += 1
        entry = Entry(self.number, time_ns, who, list(parts), data=data)
        self.entries.append(entry)
        self.changed(entry)
        return entry

    def changed(self, entry: Entry) -> None:
        self.count += 1
        if self.changes and self.changes[-1][1] is entry:
            self.changes.pop()
        if len(self.changes) == MOST_ENTRIES:
            self.lost = self.changes[0][0]
        self.changes.append((self.count, entry))

    def since(self, count: int) -> list[Entry]:
        if count <= self.lost:
            return list(self.entries)
        return list(dict.fromkeys(entry for at, entry in self.changes if at > count))

    # Messages

    def said(self, event: Sent | Received | LineBreak) -> Entry:
        if isinstance(event, Sent) and self.typed and self.typed[0].data == event.data:
            entry = self.typed.popleft()
            entry.time_ns, entry.held = event.time_ns, False
        elif self.whole and not isinstance(event, LineBreak):
            entry = self.add(
                event.time_ns, HOST if isinstance(event, Sent) else DEVICE, self._message(event), event.data
            )
        else:
            entry = self._continued(event)
        self.changed(entry)
        return entry

    def _continued(self, event: Sent | Received | LineBreak) -> Entry:
        who = DEVICE if isinstance(event, Received) else HOST
        data = b"" if isinstance(event, LineBreak) else event.data
        entry = self.open
        if entry is None or entry.who != who or event.time_ns > self.last_ns + PAUSE_NS or self._ended(entry, data):
            entry = self.open = self.add(event.time_ns, who)
        self.last_ns = event.time_ns
        entry.data += data
        for text, kind in characters(event):
            if entry.parts and entry.parts[-1][1] == kind == "":
                entry.parts[-1] = entry.parts[-1][0] + text, ""
            else:
                entry.parts.append((text, kind))
        return entry

    @staticmethod
    def _ended(entry: Entry, data: bytes) -> bool:
        return entry.data[-1:] in (CR, LF) and not (entry.who == DEVICE and data == LF)

    def _message(self, said: Sent | Received) -> Iterator[tuple[str, str]]:
        by_host = isinstance(said, Sent)
        yield self.codec.show(said.data if by_host else unpadded(said.data)), ""
        if words := self.codec.words(said.data, by_host):
            yield f"  {words}", "quiet"


def characters(said: Sent | Received | LineBreak) -> Iterator[tuple[str, str]]:
    if isinstance(said, LineBreak):
        yield f"BREAK {said.seconds:g} s", "control"
        return
    wrong = isinstance(said, Received) and bool(said.errors)
    for byte in said.data:
        shown = word(byte)
        yield shown.strip("<>") if len(shown) > 1 else shown, "wrong" if wrong else "control" if len(shown) > 1 else ""


class Log:
    """The lists of all endpoints of a session, from the beginning of its present bench."""

    def __init__(self, session: Session) -> None:
        self.generation = 0  # Number of benches that the session has used.
        self.on_said: Callable[[str, Entry, Received], None] = lambda name, entry, event: None
        """Function that is called with each message of a controller, and may add notes to its entry."""
        self._session = session
        self._events: deque[Sent | Received | LineBreak | _Act | _Alarm] = deque(maxlen=KEPT)
        self._plan: deque[tuple[int, str]] = deque()  # Acts of the scene's script that are not in the lists yet.
        self._threads: dict[str, _Thread] = {}
        self._observing = ExitStack()
        session.each_bench(self._attach)

    def _attach(self, bench: Bench) -> None:
        self._observing.close()
        self.generation += 1
        self._events.clear()
        self._plan = deque(sorted(bench.planned))
        self._threads = {
            name: _Thread(endpoints.codec_at(bench, name), endpoints.at_a_bus(bench, name))
            for name in endpoints.names(bench)
        }
        self._observing.enter_context(observing(bench, self._take))
        for name, controller in bench.controllers.items():
            if controller.alarms is not None:
                self._observing.callback(controller.alarms.subscribe(partial(self._alarm, bench, name)))

    def _take(self, event: Event) -> None:
        if isinstance(event, Sent | Received | LineBreak | _Act):
            self._events.append(event)

    def _alarm(self, bench: Bench, name: str, flag: str) -> None:
        self._events.append(_Alarm(bench.now, name, flag))

    def since(self, name: str, count: int) -> tuple[int, list[Entry]]:
        """Return the number of changes of an endpoint's list, and the entries that have changed since `count`."""
        self._absorb()
        thread = self._threads.get(name)
        return (0, []) if thread is None else (thread.count, thread.since(count))

    # What pages add

    def close_line(self, name: str) -> None:
        """End the present message, so that the next character begins a new entry."""
        self._absorb()
        if name in self._threads:
            self._threads[name].open = None

    def typed(self, name: str, data: bytes, explained: Iterable[str]) -> None:
        """Put notes below a line that has just been typed; if the controller has not received it, the line waits."""
        self._absorb()
        thread = self._threads[name]
        entry = thread.open or (thread.entries[-1] if thread.entries else None)
        if entry is None or entry.who != HOST or entry.data != data:
            said = Sent(self._session.bench.now, name, data)
            entry = thread.add(said.time_ns, HOST, thread._message(said), data)
            entry.held = True
            thread.typed.append(entry)
        entry.notes += explained
        thread.changed(entry)
        thread.open = None

    def ask(self, name: str, question: str, answer: Iterable[str]) -> None:
        """Add a question to the tutor, or to the terminal itself, with the answer below it."""
        self._absorb()
        thread = self._threads[name]
        entry = thread.add(self._session.bench.now, QUESTION, [(question, "")])
        entry.notes += answer
        thread.open = None

    def note(self, name: str, explained: Iterable[str]) -> None:
        """Put notes below the last entry."""
        self._absorb()
        thread, lines = self._threads[name], list(explained)
        if lines and thread.entries:
            thread.entries[-1].notes += lines
            thread.changed(thread.entries[-1])

    # Parts

    def _absorb(self) -> None:
        while self._events:
            event = self._events.popleft()
            # A script's acts come after all other events of their time, but before the alarms that they cause.
            self._tell_plan(event.time_ns + isinstance(event, _Alarm))
            if isinstance(event, Sent | Received | LineBreak):
                self._said(event)
            elif isinstance(event, _Alarm):
                self._tell(event, alarm(self._session.bench[event.controller], event.flag))
            else:
                self._tell(event, told_of(self._session.operator, event))
        self._tell_plan(self._session.bench.now + 1)

    def _said(self, event: Sent | Received | LineBreak) -> None:
        thread = self._threads.get(event.controller)
        if thread is not None:
            entry = thread.said(event)
            if isinstance(event, Received):
                self.on_said(event.controller, entry, event)

    def _tell_plan(self, before_ns: int) -> None:
        while self._plan and self._plan[0][0] < before_ns:
            time_ns, text = self._plan.popleft()
            for name, told in planned(self._session.operator, self._session.bench, text):
                self._tell(_Alarm(time_ns, name, ""), told)

    def _tell(self, event: _Act | _Alarm, told: Told | None) -> None:
        if told is None:
            return
        for name in self._places(event.controller):
            thread = self._threads[name]
            last = thread.entries[-1] if thread.entries else None
            if isinstance(event, _Alarm) and event.flag and last and (last.who, last.time_ns) == (FAULT, event.time_ns):
                continue  # The act that has caused the alarm says the same.
            thread.add(event.time_ns, FAULT if told.bad else ACT, [(told.words, "")])
            thread.open = None

    def _places(self, controller: str) -> Iterator[str]:
        """Yield the endpoints at which the acts on a controller are told."""
        lines = self._session.bench.lines
        for name in self._threads:
            if name == controller or (name in lines and any(each.name == controller for each in lines[name].motors)):
                yield name
