"""A client of the language server, over its standard input and output: messages with a Content-Length."""

import json
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Self

ROOT = Path(__file__).parents[2]


class Client:
    def __init__(self, *before: str) -> None:
        command = [sys.executable, "-c", f"from axistwin.cli.program import main; main({[*before, 'lsp']})"]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            env={"PYTHONPATH": str(ROOT / "src"), "PATH": ""},
        )  # fmt: skip
        self.number = 0
        self.notified: list[dict[str, Any]] = []
        self.capabilities = self.ask(
            "initialize", {"processId": None, "rootUri": None, "capabilities": {}}
        )["capabilities"]  # fmt: skip
        self.tell("initialized", {})

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.ask("shutdown", None)
        self.tell("exit", None)
        self.process.stdin.close()
        assert self.process.wait() == 0
        self.process.stdout.close()

    def tell(self, method: str, params: object) -> None:
        self._send({"jsonrpc": "2.0", "method": method, "params": params})

    def ask(self, method: str, params: object) -> Any:
        self.number += 1
        self._send({"jsonrpc": "2.0", "id": self.number, "method": method, "params": params})
        while True:
            message = self._receive()
            if message.get("id") == self.number:
                assert "error" not in message, message
                return message["result"]
            self.notified.append(message)

    def diagnostics(self, uri: str, version: int) -> list[dict[str, Any]]:
        """Return the diagnostics that are published for this version of a document."""
        while True:
            for message in self.notified:
                told = message.get("params", {})
                if "diagnostics" in told and (told["uri"], told.get("version")) == (uri, version):
                    self.notified.remove(message)
                    return told["diagnostics"]
            self.notified.append(self._receive())

    def open(self, uri: str, text: str) -> list[dict[str, Any]]:
        document = {"uri": uri, "languageId": "axistwin", "version": 1, "text": text}
        self.tell("textDocument/didOpen", {"textDocument": document})
        return self.diagnostics(uri, 1)

    def at(self, method: str, uri: str, line: int, character: int) -> Any:
        place = {"line": line, "character": character}
        return self.ask(f"textDocument/{method}", {"textDocument": {"uri": uri}, "position": place})

    def tell_all(self, method: str, many: Iterable[object]) -> None:
        self._send(*({"jsonrpc": "2.0", "method": method, "params": params} for params in many))

    def _send(self, *messages: dict[str, Any]) -> None:
        bodies = [json.dumps(message).encode() for message in messages]
        self.process.stdin.write(b"".join(b"Content-Length: %d\r\n\r\n%s" % (len(body), body) for body in bodies))
        self.process.stdin.flush()

    def _receive(self) -> dict[str, Any]:
        length = 0
        while (line := self.process.stdout.readline()).strip():
            name, _, value = line.partition(b":")
            length = int(value) if name.lower() == b"content-length" else length
        assert length, "the server has ended"
        return json.loads(self.process.stdout.read(length))
