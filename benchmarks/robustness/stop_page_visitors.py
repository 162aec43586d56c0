"""Bad visitors of the page with the stop button, while a host moves a motor through `axistwin stand-in`.

    python benchmarks/robustness/stop_page_visitors.py [--seed 1] [--visitors 1500]

In turn: connections that stay idle, connections that all close at once (with and without a request, with a reset),
requests with a wrong length or of random bytes, and requests of other web sites, among them a name that points to this
computer.  After each of them the page and the host's port must answer, the descriptors and threads of the command must
be bounded, and no motor may have been stopped.  At the end the button stops the motor, and the journal must contain its
position.  Runs in real time with a simulated board.  Prints the errors and a verdict; the exit code is 1 if there are
errors.
"""

import argparse
import random
import resource
import signal
import socket
import struct
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import urlopen

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.robustness.stand_in_real_time import SCENE
from tests.standin.command import StandInCommand

from axistwin.real.standin.journal import last_positions

MOST_FILES, MOST_THREADS = 250, 3
"""Largest number of additional descriptors and threads of the command."""
OWN = b"Host: localhost\r\n"


class Campaign:
    """The command, with a host at its port and the address of its page."""

    def __init__(self, folder: Path, seed: int, visitors: int) -> None:
        self.rng, self.visitors, self.wrong = random.Random(seed), visitors, list[str]()
        self.run = StandInCommand(folder, SCENE.format(watchdog=500), "--panel", "0")
        assert self.run.program.stdout is not None
        self.url = self.run.first.split()[-1]
        listening = self.run.program.stdout.readline()
        self.host = socket.create_connection(("127.0.0.1", int(listening.rpartition(":")[2])), timeout=5)
        for text, seconds in ((b"", 0.6), (b"(", 0.3), (b"U61\r", 1.5)):
            self.host.sendall(text)
            time.sleep(seconds)
        self.files, self.threads = self.counts()

    def counts(self) -> tuple[int, int]:
        """Return the number of descriptors and of threads of the command."""
        process = Path(f"/proc/{self.run.program.pid}")
        return sum(1 for _ in (process / "fd").iterdir()), sum(1 for _ in (process / "task").iterdir())

    def visit(self, data: bytes = b"") -> socket.socket:
        """Connect to the page, and send a request."""
        visitor = socket.create_connection(("127.0.0.1", urlsplit(self.url).port or 0), timeout=10)
        visitor.sendall(data)
        return visitor

    def check(self, what: str) -> None:
        """Check that the command serves the page and the host."""
        files, threads = self.counts()
        began = time.monotonic()
        try:
            with urlopen(f"{self.url}state", timeout=10) as answer:
                if b'"live": true' not in answer.read():
                    self.wrong.append(f"{what}: stopped")
        except OSError as error:
            self.wrong.append(f"{what}: the page does not answer: {error}")
        page_s = time.monotonic() - began
        self.heard()
        self.host.sendall(b"E\r")
        began = time.monotonic()
        if not self.host.recv(100):
            self.wrong.append(f"{what}: the host hears nothing")
        if files > self.files + MOST_FILES or threads > self.threads + MOST_THREADS:
            self.wrong.append(f"{what}: {files} descriptors, {threads} threads")
        print(f"{what}: page {page_s:.2f} s, host {time.monotonic() - began:.2f} s, {files} descriptors")

    def heard(self) -> bytes:
        """Return what the host has received."""
        self.host.setblocking(False)
        try:
            return self.host.recv(10_000)
        except BlockingIOError:
            return b""
        finally:
            self.host.settimeout(5)

    def idle(self) -> None:
        """Open connections and leave them open."""
        with ExitStack() as stack:
            for _ in range(self.visitors):
                with suppress(OSError):
                    stack.enter_context(self.visit(self.rng.choice((b"", b"GET / HT"))))
            self.check(f"{self.visitors} idle connections")

    def leave(self) -> None:
        """Open connections, and close all at once."""
        with ExitStack() as stack:
            for _ in range(self.visitors):
                with suppress(OSError):
                    visitor = stack.enter_context(
                        self.visit(self.rng.choice((b"", b"GET / HTTP/1.1\r\n" + OWN + b"\r\n")))
                    )
                    visitor.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", self.rng.randrange(2), 0))
        self.check(f"{self.visitors} connections that close at once")

    def ask(self, what: str, request: Callable[[], bytes], statuses: Sequence[bytes], count: int = 300) -> None:
        """Send requests; each must have one of the answers."""
        for _ in range(count):
            sent, answer = request(), b""
            with suppress(OSError), self.visit(sent + b"\r\n\r\n") as visitor:
                answer = visitor.recv(12)
            if answer[9:12] not in statuses:
                self.wrong.append(f"{what}: {answer!r} to {sent!r}")
        self.check(f"{count} {what}")

    def foreign(self) -> bytes:
        """Return a request that another web site has made a browser send."""
        port = urlsplit(self.url).port
        heads = (
            b"Host: evil.example:%d" % port, b"Host: 127.0.0.1:%d\r\nOrigin: http://evil.example" % port,
            b"Host: evil.example\r\nOrigin: http://evil.example", b"Host: localhost\r\nOrigin: null",
            b"Host: localhost\r\nSec-Fetch-Site: cross-site\r\nSec-Fetch-Mode: cors", b"Host: localhost.evil.example",
        )  # fmt: skip
        return self.rng.choice((b"POST /stop", b"GET /state", b"GET /")) + b" HTTP/1.1\r\n" + self.rng.choice(heads)

    def all(self) -> None:
        """Run the campaign with a moving motor."""
        self.host.sendall(b"X+9000 @ 200 $ \r")
        time.sleep(0.5)
        self.check("no visitor")
        self.idle()
        self.leave()
        lengths = (b"abc", b"-1", b"1e9", b"9" * 4000)
        self.ask("wrong lengths", lambda: b"GET /state HTTP/1.1\r\n" + OWN + b"Content-Length: "
                 + self.rng.choice(lengths), (b"200",))  # fmt: skip
        self.ask("random requests", lambda: self.rng.randbytes(self.rng.randrange(300)), (b"400", b"403", b""))
        self.ask("requests of other web sites", self.foreign, (b"403",))

    def end(self, folder: Path) -> None:
        """Stop by the button, then end the command; the position must be known."""
        with urlopen(f"{self.url}stop", data=b"", timeout=10):
            time.sleep(1.0)
        stops = self.run.stops()
        if len(stops) != 1 or "stopped from the page" not in stops[0]:
            self.wrong.append(f"stops: {stops}")
        self.run.program.send_signal(signal.SIGINT)
        self.run.program.wait(30)
        made = self.run.close()["pulses"]["2"]
        known = last_positions(folder / "table.journal", ["table.X"])
        if known != {"table.X": len(made)}:
            self.wrong.append(f"positions {known} after {len(made)} pulses")
        errors = (folder / "errors").read_text()
        if "Traceback" in errors:
            self.wrong.append(errors)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the campaign."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--visitors", type=int, default=1500)
    given = parser.parse_args(arguments)
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    with tempfile.TemporaryDirectory() as name:
        campaign = Campaign(Path(name), given.seed, given.visitors)
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, given.visitors + 500), hard))
        campaign.all()
        campaign.end(Path(name))
    print("\n".join(campaign.wrong[:30]), end="\n" if campaign.wrong else "")
    print(f"{'FAILED' if campaign.wrong else 'passed'}: seed {given.seed}: {len(campaign.wrong)} wrong")
    return 1 if campaign.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
