"""The twin's process of `axistwin shadow --panel`: it also serves the panel, at which nothing can be acted on.

A slow page delays the twin and never the relay, which is another process; the times of what arrives are the relay's.
"""

import asyncio
import json
import logging
import os
import sys
import time
from collections import deque
from collections.abc import Iterator, Sequence
from datetime import datetime
from io import BytesIO
from queue import Empty, Queue
from threading import Thread
from typing import IO, Any

from axistwin.core.errors import LinkError
from axistwin.core.units import MS, S
from axistwin.real.shadow.feed import Record, What, records
from axistwin.real.shadow.findings import Finding, Kind
from axistwin.real.shadow.process import BEHIND_NS, Observer, read
from axistwin.real.shadow.summary import state
from axistwin.real.shadow.talk import Answer, Command
from axistwin.scenes.sessions.session import Session
from axistwin.ui.panel.address import Address
from axistwin.ui.panel.comparison import Found
from axistwin.ui.panel.web import Panel

SLICE_S, IDLE_S = 0.01, 0.02  # Time for records before the pages' turn; pause if there are none.
NICE = 10  # The relay, which has no pages to build, gets a processor first.
AFTER_NS = 20 * MS  # From a finding to its moment: the twin may answer a little later.
CHUNK, CHUNKS = 1 << 20, 16  # What has arrived is kept for going back, in so many pieces of bytes.


class Kept:
    """The latest records, for going back."""

    def __init__(self) -> None:
        self._chunks = deque([bytearray()], maxlen=CHUNKS)

    def add(self, record: Record) -> None:
        if record.what is not What.SUMMARY:
            if len(self._chunks[-1]) > CHUNK:
                self._chunks.append(bytearray())
            self._chunks[-1] += record.pack()

    def __iter__(self) -> Iterator[Record]:
        for chunk in list(self._chunks):
            yield from records(BytesIO(bytes(chunk)))


class Beside:
    """The machine's positions: those of the twin, and by how much the last answers of both have differed.

    What a controller counts from the start of each move adds to the difference before it.
    """

    def __init__(self, observer: Observer) -> None:
        self.observer, self.apart, self._before = observer, dict[str, int](), dict[str, int]()
        self._move: Command | None = None
        observer.shadow.paired = self._pair

    def _pair(self, machine: Answer, twin: Answer) -> None:
        if machine.asked is None or machine.asked.echo:
            return
        dialect, command = self.observer.shadow.dialect, machine.asked.command
        theirs, ours = dialect.read(command, machine.data), dialect.read(command, twin.data)
        if theirs.position is not None and ours.position is not None and not theirs.encoder:
            axis, by = dialect.axis_of(command), theirs.position - ours.position
            if theirs.ahead:
                by = self._base(axis) + self.observer.shadow.twin.busiest()[1] * by
            self.apart[axis] = by

    def _base(self, axis: str) -> int:
        move = self.observer.shadow.moves.command
        if move is not self._move:
            self._move, self._before = move, dict(self.apart)
        return self._before.get(axis, 0)

    def position(self, axis: str) -> int | None:
        if axis not in self.apart:
            return None
        return self.observer.shadow.twin.position(axis) + self.apart[axis]


class Compared:
    """What the panel shows: the twin beside the machine, now or at the moment of a finding.

    A past moment is reached by another twin, which receives again what has arrived until then.
    """

    def __init__(self, settings: dict[str, Any], observer: Observer) -> None:
        self._settings = {**settings, "log": None}
        self.live = self._shown = Beside(observer)
        self.kept = Kept()
        self.session = Session(lambda: observer.bench)
        self._state, self._since_ns = "", 0
        self._listed, self._key = dict[Found, Finding](), (0, 0)
        self._goal: Finding | None = None
        self._goal_ns = 0
        self._again: Iterator[Record] = iter(())

    def advance(self) -> bool:
        """Go on towards a past moment, for a short time.  Return False if it is reached."""
        observer, until_s = self._shown.observer, time.monotonic() + SLICE_S
        if self._reached:
            return False
        while time.monotonic() < until_s:
            record = next(self._again, None)
            if record is None or record.time_ns > self._goal_ns:
                observer.tick(self._goal_ns)
                break
            observer.take(record)
        self._tell_pages()
        return True

    @property
    def _reached(self) -> bool:
        return self._goal is None or self._shown.observer.now_ns >= self._goal_ns

    def _tell_pages(self) -> None:
        self.session.pacer.advance_slice(lambda over: None)

    def tick(self) -> None:
        """Note since when they agree or differ; to be called now and then."""
        observer = self.live.observer
        if (now := state(observer.shadow)) != self._state:
            self._state, self._since_ns = now, observer.now_ns
        if not self.past:
            self._tell_pages()

    # The panel's part

    @property
    def state(self) -> str:
        if self._goal is not None:
            return self._goal.text if self._reached else f"going back to {_clock(self._goal.time_ns)}, at {self.clock}"
        shadow = self.live.observer.shadow
        if shadow.silent_since_ns is not None:
            return f"the machine is silent since {_clock(shadow.silent_since_ns)[:5]}"
        latest = shadow.findings.differences[-1:]
        words = {"agrees": "agrees", "differs": "differs"}.get(self._state)
        if words is None:
            return self._state
        since_ns = latest[0].time_ns if latest else self._since_ns
        return "".join((f"{words} since {_clock(since_ns)[:5]}", *(f": {found.text}" for found in latest)))

    @property
    def differs(self) -> bool:
        return bool(self.live.observer.shadow.findings.differences)

    @property
    def clock(self) -> str:
        return _clock(self._shown.observer.now_ns)

    @property
    def past(self) -> bool:
        return self._goal is not None

    @property
    def found(self) -> Sequence[Found]:
        findings = self.live.observer.shadow.findings
        every = [*findings.differences, *findings.notes]
        if (key := (len(every), sum(found.count for found in every))) != self._key:
            every.sort(key=lambda found: found.time_ns, reverse=True)
            self._key, self._listed = key, {_found(found): found for found in every}
        return tuple(self._listed)

    def beside(self, axis: str) -> int | None:
        return self._shown.position(axis)

    def go_back(self, found: Found) -> bool:
        goal, first = self._listed.get(found), next(iter(self.kept), None)
        if goal is None or first is None or goal.time_ns < first.time_ns:
            return False
        self._goal, self._goal_ns = goal, goal.time_ns + AFTER_NS
        self._shown = Beside(Observer(self._settings, lambda finding: None))
        self._again = iter(self.kept)
        self.session.show(self._shown.observer.bench)
        return True

    def go_on(self) -> None:
        self._goal, self._shown = None, self.live
        self.session.show(self.live.observer.bench)


def _found(finding: Finding) -> Found:
    times = "" if finding.count == 1 else f"{finding.count} times"
    return Found(_clock(finding.time_ns), finding.text, times, finding.kind is Kind.NOTE)


def _clock(time_ns: int) -> str:
    return f"{datetime.fromtimestamp(time_ns / S):%H:%M:%S}" if time_ns else "–"  # noqa: DTZ006  # for a person here


async def watch(settings: dict[str, Any], stream: IO[bytes]) -> int:
    """Observe until the stream ends, and serve the panel; return the exit code."""
    if hasattr(os, "nice"):
        os.nice(NICE)
    observer, arriving = Observer(settings), Queue[Record | None](10_000)
    compared = Compared(settings, observer)
    panel = Panel(compared.session.title, compared.session, Address(*settings["panel"]), compared)
    try:
        print("panel on", await panel.open(), file=sys.stderr if settings["json"] else sys.stdout, flush=True)
    except LinkError as error:
        logging.getLogger("axistwin").warning("%s", error)
    Thread(target=read, args=(stream, arriving), daemon=True).start()
    ended = False
    while not ended:
        busy, ended = _take(observer, arriving, compared, time.monotonic() + SLICE_S)
        if not busy:
            observer.tick(max(observer.now_ns, time.monotonic_ns() + int(settings["ahead_ns"]) - BEHIND_NS))
        compared.tick()
        await asyncio.sleep(0 if compared.advance() or busy else IDLE_S)
    code = observer.finish()
    await panel.close()
    return code


def _take(
    observer: Observer, arriving: "Queue[Record | None]", compared: Compared, until_s: float
) -> tuple[bool, bool]:  # fmt: skip
    """Take records that have arrived until a time; return whether there are more, and whether it was the last."""
    try:
        while time.monotonic() < until_s:
            record = arriving.get_nowait()
            if record is None:
                return True, True
            compared.kept.add(record)
            observer.take(record)
    except Empty:
        return False, False
    return True, False


if __name__ == "__main__":
    sys.exit(asyncio.run(watch(json.loads(sys.stdin.buffer.readline()), sys.stdin.buffer)))
