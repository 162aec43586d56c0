"""The twin's process: reads what the relay has passed on, and tells what differs.

The relay is another process, so that a twin that fails, hangs or is slow cannot stop the machine.
"""

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from queue import Empty, Queue
from threading import Thread
from typing import IO, Any

from axistwin.core.units import MS, S
from axistwin.real.shadow.feed import Record, What, records
from axistwin.real.shadow.findings import TOLERANCE_NS, Finding, Kind
from axistwin.real.shadow.log import Log
from axistwin.real.shadow.shadow import EARLY_NS, Shadow
from axistwin.real.shadow.summary import as_dict, lines
from axistwin.real.shadow.twin import Twin, endpoint

TICK_S = 0.05
LAST_NS = 3 * S
BEHIND_NS = 100 * MS  # What arrives is never older than this, so that the twin's time can go on in a silence.


class Observer:
    """Compares what arrives with a twin.  `show` receives each new finding and note; default: print it."""

    def __init__(self, settings: dict[str, Any], show: Callable[[Finding], object] | None = None) -> None:
        self._log = Log(Path(settings["log"]) if settings["log"] else None, _warn)
        tolerance_ms = settings["tolerance_ms"]
        self.bench = bench = _bench(settings)
        self._show = show or self._print
        self.shadow = Shadow(
            Twin(bench, endpoint(bench)), self._tell, self._log.learned(),
            tolerance_ns=TOLERANCE_NS if tolerance_ms is None else round(tolerance_ms * MS), timed=self._log.timed,
        )  # fmt: skip
        self.shadow.early_ns = EARLY_NS if settings.get("listens") else 0
        self._as_json = bool(settings["json"])
        self._bus = _bus_talk(self) if self.shadow.twin.on_bus else None
        self.now_ns = self.since_ns = 0

    def _tell(self, finding: Finding) -> None:
        self._log.found(finding)
        self._show(finding)

    def _print(self, finding: Finding) -> None:
        if finding.kind is Kind.NOTE:
            print(finding.line(), file=sys.stderr, flush=True)
        elif not self._as_json:
            print(finding.line(), flush=True)

    def take(self, record: Record) -> None:
        time_ns = self._reach(record.time_ns)
        match record.what:
            case What.HOST:
                self._bus.host(record.data) if self._bus else self.shadow.host(time_ns, record.data)
            case What.MACHINE:
                self._bus.board(record.data) if self._bus else self.shadow.machine(time_ns, record.data)
            case What.FORMAT:
                self.shadow.twin.set_line(record.data.decode())
            case What.AWAY | What.BACK:
                self.shadow.port(time_ns, away=record.what is What.AWAY)
            case What.MISSED:
                words = f"the twin was behind: {record.data.decode()} characters were not compared"
                self.shadow.rejoin(time_ns, words)
            case What.LATE:
                self.shadow.blind(time_ns, int(record.data))
            case What.SUMMARY:
                self.summary(sys.stderr)

    def _reach(self, time_ns: int) -> int:
        self.since_ns = self.since_ns or time_ns
        self.now_ns = max(self.now_ns, time_ns)
        return self.now_ns

    def tick(self, now_ns: int) -> None:
        self.shadow.tick(self._reach(now_ns))
        self._log.tick(self.now_ns, self.shadow.learned)

    def command(self, data: bytes) -> None:
        self.shadow.host(self.now_ns, data)

    def message(self, data: bytes) -> None:
        self.shadow.machine(self.now_ns, data)

    def absent(self) -> None:
        self.shadow.absent(self.now_ns)

    def summary(self, stream: Any) -> None:
        for line in lines(self.shadow, self.since_ns, self.now_ns):
            print(line, file=stream, flush=True)

    def finish(self) -> int:
        """Print the summary; return 1 if anything differed."""
        self.shadow.tick(self.now_ns + LAST_NS)  # The twin's last answers, and what waits for them.
        found = as_dict(self.shadow, self.since_ns, self.now_ns)
        self._log.write_hour()
        self._log.write_day()
        self._log.save(self.shadow.learned)
        self._log.add("summary", **{key: value for key, value in found.items() if key not in ("findings", "notes")})
        if self._as_json:
            print(json.dumps(found, ensure_ascii=False), flush=True)
        else:
            self.summary(sys.stdout)
        return 1 if self.shadow.findings.differences else 0


def _bench(settings: dict[str, Any]) -> Any:
    from axistwin.bench import Bench, product
    from axistwin.bench.options import read_options
    from axistwin.devices.loading import load_texts

    load_texts(settings["devices"])
    if settings["scene"]:
        from axistwin.scenes.scene import Scene

        bench: Bench = Scene.load(Path(settings["scene"])).build()
    else:
        bench = Bench()
        options = read_options(tuple(settings["options"]))
        made = product(settings["model"])
        for axis in made.limit_pins:  # The machine has limit switches; where they are, its answers will tell.
            options[axis] = {"limits": (-FAR, FAR), **options.get(axis, {})}
        bench.add(settings["model"], history=HISTORY, line=settings["line"], **options)
    bench.run(2.0)
    return bench


FAR, HISTORY = 1 << 40, 50


def _bus_talk(observer: Observer) -> Any:
    from axistwin.real.shadow.dialects.compumotor import BusTalk

    return BusTalk(observer.command, observer.message, observer.absent)


def _warn(words: str) -> None:
    print(f"axistwin: {words}", file=sys.stderr, flush=True)


def read(stream: IO[bytes], into: "Queue[Record | None]") -> None:
    for record in records(stream):
        into.put(record)
    into.put(None)


def run(settings: dict[str, Any], stream: IO[bytes]) -> int:
    """Observe until the stream ends; return the exit code."""
    observer, arriving = Observer(settings), Queue[Record | None](10_000)
    Thread(target=read, args=(stream, arriving), daemon=True).start()
    while True:
        try:
            record = arriving.get(timeout=TICK_S)
        except Empty:
            observer.tick(time.monotonic_ns() + int(settings["ahead_ns"]) - BEHIND_NS)
            continue
        if record is None:
            return observer.finish()
        observer.take(record)


if __name__ == "__main__":
    sys.exit(run(json.loads(sys.stdin.buffer.readline()), sys.stdin.buffer))
