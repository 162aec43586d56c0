"""Malformed and mutated socket.io messages to the panel of a server, while a host polls the server's controller.

    python benchmarks/robustness/panel_messages.py [--seed 1] [--number 200]

Exit code 0 if the server survives, the host is always answered, and the page still opens for a new visitor; else 1.
"""

import argparse
import asyncio
import json
import random
import re
import sys
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

SERVE = [
    sys.executable, "-c", "from axistwin.cli.program import main; main()",
    "serve", "if1", "--tcp", ":0", "--line", "instant", "--panel", "0",
]  # fmt: skip
NAMES = (
    "connect", "disconnect", "handshake", "event", "javascript_response", "ack", "log", "connect_error", "message", "",
    "*", "ping", "update", "__class__", "x" * 2000,
)  # fmt: skip
KEYS = (
    "client_id", "id", "listener_id", "args", "request_id", "result", "next_message_id", "tab_id", "document_id",
    "old_tab_id", "level", "unknown",
)  # fmt: skip
ODD: tuple[object, ...] = (
    None, True, 0, -1, 1.5, 1e308, 10**40, "", "x", "\0", "é" * 300, [], {}, [[]], {"a": {}}, [None] * 50, "../../etc",
)  # fmt: skip
RAW = (
    "", "4", "42", "42[", "42[]", "42[1]", "42{}", "42null", '42["event"', '42["event",', "43", "43[]", "430[1]",
    "44", '44{"a":1}', "45", '451-["event"]', '459999-["event"]', "451-", "46", "47", "49", "40", '40{"a":1}', "41",
    '40/other,{"a":1}', "41/other,", "0", "1", "2", "2probe", "3", "5", "6", "7", "9", "x", "\0", "42" + "[" * 3000,
    '42["event",' + '{"a":' * 3000, '42999999999999999999["event",{}]', "4" * 5000,
)  # fmt: skip
LATEST_S = 2.0
"""Longest permitted time to an answer."""


def messages(seed: int, number: int, client: str) -> Iterator[str | bytes]:
    """Return websocket frames of a malicious client that knows the number of its page."""
    chance = random.Random(seed)
    fixed = [*RAW, *(event(name, "x") for name in NAMES), *(event(name) for name in NAMES)]
    for count in range(number):
        yield fixed[count] if count < len(fixed) else _mutated(chance, _made_up(chance, client))


def event(name: str, *arguments: object) -> str:
    """Return a socket.io event as a frame."""
    return "42" + json.dumps([name, *arguments])


def _made_up(chance: random.Random, client: str) -> str:
    values = (*ODD, client, client)
    contents = {key: chance.choice(values) for key in chance.sample(KEYS, chance.randrange(len(KEYS)))}
    if chance.random() < 0.7:
        contents["client_id"] = client
    return event(chance.choice(NAMES), *([contents] if chance.random() < 0.8 else chance.choices(ODD, k=2)))


def _mutated(chance: random.Random, text: str) -> str | bytes:
    kind = chance.randrange(5)
    place = chance.randrange(len(text))
    if kind == 0:
        return text[:place]
    if kind == 1:
        return text[:place] + chance.choice('{}[]",:0x\0') + text[place + 1 :]
    if kind == 2:
        return chance.randbytes(chance.randrange(60))
    return text


async def main(seed: int, number: int) -> bool:
    """Print the results; return True if all are good."""
    program = await asyncio.create_subprocess_exec(*SERVE, stdout=-1, stderr=-1)
    assert program.stdout is not None and program.stderr is not None
    errors = asyncio.create_task(program.stderr.read())
    host, sent, page = Host(), 0, ""
    try:
        panel = _found(r"panel on (\S+)", await program.stdout.readline())
        host.begin(int(_found(r"tcp://127.0.0.1:(\d+)", await program.stdout.readline())))
        await host.ready.wait()
        sent = await attack(panel, seed, number)
        page = await asyncio.to_thread(_page, panel)
    except OSError as error:
        print(f"the panel is gone: {error}")
    finally:
        lost = await host.end()
        if alive := program.returncode is None:
            program.terminate()
        told = (await errors).decode(errors="replace")
    print(f"seed {seed}: {sent} messages, {told.count('Traceback')} tracebacks reported")
    print(f"the server is {'alive' if alive else 'dead'}; a visitor {'is' if page else 'is not'} shown the page")
    print(f"{host.answered} polls answered, the slowest after {host.longest_s * 1000:.0f} ms {lost or ''}")
    good = sent == number and alive and bool(page) and lost is None and 0 < host.longest_s < LATEST_S
    print("held" if good else f"BROKEN\n{told[-3000:]}")
    return good


def _found(pattern: str, line: bytes) -> str:
    found = re.search(pattern, line.decode())
    assert found is not None, line
    return found[1]


def _page(address: str) -> str:
    with urllib.request.urlopen(address, timeout=30) as answer:
        return str(answer.read().decode())


async def attack(address: str, seed: int, number: int) -> int:
    """Send all messages; open a new page and connection when the server has closed the last one."""
    import websockets

    sent, pending = 0, iter(messages(seed, number, "CLIENT"))
    frame = next(pending, None)
    while frame is not None:
        client = _found(r"client_id\W+([\w-]+)", (await asyncio.to_thread(_page, address)).encode())
        query = f"client_id={client}&document_id=1&tab_id=1&next_message_id=0&implicit_handshake=true&EIO=4"
        url = f"{address.replace('http', 'ws')}_nicegui_ws/socket.io/?{query}&transport=websocket"
        try:
            async with websockets.connect(url, max_size=None) as socket:
                await socket.recv()
                await socket.send("40")
                while frame is not None:
                    now = frame.replace("CLIENT", client) if isinstance(frame, str) else frame
                    frame, sent = next(pending, None), sent + 1
                    await socket.send(now)
                    await asyncio.sleep(0.01)
        except websockets.ConnectionClosed:
            pass
    return sent


class Host:
    """A host that polls the busy state of an IF1."""

    def __init__(self) -> None:
        self.ready = asyncio.Event()
        self.longest_s, self.answered = 0.0, 0

    def begin(self, port: int) -> None:
        """Connect, and poll until the end."""
        self._task = asyncio.create_task(self._poll(port))

    async def end(self) -> BaseException | None:
        """Stop polling; return the error that ended it earlier."""
        self._task.cancel()
        (outcome,) = await asyncio.gather(self._task, return_exceptions=True)
        return None if isinstance(outcome, asyncio.CancelledError) else outcome

    async def _poll(self, port: int) -> None:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        for words in (b"", b"(", b"U61\r"):  # self test after power-up
            writer.write(words)
            await asyncio.sleep(1.5)
        await reader.readuntil(b"U\r")
        self.ready.set()
        while True:
            began = perf_counter()
            writer.write(b"E\r")
            await asyncio.wait_for(reader.readuntil(b"C\r"), 10)
            self.longest_s = max(self.longest_s, perf_counter() - began)
            self.answered += 1
            await asyncio.sleep(0.02)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--number", type=int, default=200)
    given = parser.parse_args()
    sys.exit(0 if asyncio.run(main(given.seed, given.number)) else 1)
