"""The process of the HAL component, and the thread that reads the component's reports."""

import json
import os
import subprocess
from collections.abc import Callable, Sequence
from importlib import resources
from tempfile import TemporaryFile
from threading import Thread
from typing import Any

from axistwin.core.errors import LinkError
from axistwin.real.standin.hal.board import HalBoard
from axistwin.real.standin.hal.wiring import COMPONENT, HalWiring
from axistwin.real.standin.output import Deliver, Output

PYTHON = "/usr/bin/python3"  # The Python for which LinuxCNC's module `hal` is installed.
INSTALL = "install LinuxCNC (Debian: linuxcnc-uspace)"
ENDED = "the HAL component axistwin has ended: check HAL, then type `go`"
END_S = 2.0  # Longest time until the component has ended.


class HalSender(Output):
    """Serves the axes at HAL.  `deliver` is called in another thread with each event.

    `prefix`: words before each command that uses HAL, such as ("runuser", "-u", "cnc", "--").
    """

    _board: HalBoard
    wiring: HalWiring

    def __init__(self, board: HalBoard, deliver: Deliver, prefix: Sequence[str] = ()) -> None:
        super().__init__(board, deliver)
        self._prefix = list(prefix)
        self._process: subprocess.Popen[bytes] | None = None
        self._owner = False

    def start(self) -> None:
        Thread(target=self._run, name=f"board {self.wiring.name}", daemon=True).start()

    def _run(self) -> None:
        try:
            running = self._halcmd("list", "comp").split()
            self._owner = all(name.startswith("halcmd") for name in running)
            process = self._start_component()
            assert process.stdout is not None
            with process.stdout:
                self._prepare(process.stdout.readline())
                for line in process.stdout:
                    self._act(self._board.receive, json.loads(line))
        except LinkError as error:
            self._end()
            self._act(self._board.fail, str(error))
        else:
            if self._process is process:
                self._act(self._board.fail, ENDED)

    def _start_component(self) -> "subprocess.Popen[bytes]":
        if os.geteuid() == 0 and not self._prefix:
            raise LinkError("LinuxCNC's rtapi_app cannot run as root: start axistwin as another user")
        code = resources.files(__package__).joinpath("component.py").read_text(encoding="utf-8")
        try:
            process = subprocess.Popen(
                [*self._prefix, PYTHON, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL, start_new_session=True,
                cwd="/",  # The first place of `import hal` is the working directory, e.g. the scene's folder.
            )  # fmt: skip
        except OSError:
            raise LinkError(f"the program {PYTHON} is missing: {INSTALL}") from None
        assert process.stdin is not None
        os.set_blocking(process.stdin.fileno(), False)
        self._process = process
        with self._lock:
            self._flush()
        return process

    def _prepare(self, first: bytes) -> None:
        created = json.loads(first or b"{}")
        if "created" not in created:
            raise LinkError(f"cannot create the HAL component axistwin: {created.get('error', INSTALL)}")
        if self.wiring.file is not None:
            try:
                self._halcmd("-f", self.wiring.file.name)
            except LinkError as error:
                if self._owner:
                    raise
                raise LinkError(f"HAL was already running ({error}): end HAL by `halrun -U`") from None
        self._check_links()
        with self._lock:
            self._board.commands.append({"begin": True})
            self._flush()

    def _check_links(self) -> None:
        """Raise LinkError if an input pin of the HAL component is not linked to a signal."""
        pins = (line.split() for line in self._halcmd("-s", "show", "pin", f"{COMPONENT}.").splitlines())
        if missing := [words[4] for words in pins if words[2:3] == ["IN"] and "<==" not in words]:
            raise LinkError(
                f"HAL pins without a signal: {', '.join(missing)}; link each pin to a signal in {self.wiring.file}"
            )

    def _halcmd(self, *words: str) -> str:
        folder = self.wiring.file.parent if self.wiring.file else None
        # With pipes instead of files, this function could block until LinuxCNC HAL ends.
        with TemporaryFile("w+") as out, TemporaryFile("w+") as err:
            try:
                code = subprocess.call([*self._prefix, "halcmd", *words], stdout=out, stderr=err, cwd=folder)
            except OSError:
                raise LinkError(f"the program halcmd is missing: {INSTALL}") from None
            out.seek(0)
            err.seek(0)
            if code:
                said = [line.strip() for line in err if not line.startswith("Note:")]
                reason = said[0] if said else f"exit code {code}"
                raise LinkError(f"`halcmd {' '.join(words)}` has failed: {reason}")
            return out.read()

    def _act(self, act: Callable[..., None], *values: Any) -> None:
        with self._lock:
            act(*values)
            self._flush()
        self._report()

    def _flush(self) -> None:
        commands, process = self._board.commands, self._process
        if process is None or process.stdin is None:
            return
        data = b"".join(json.dumps(commands.popleft()).encode() + b"\n" for _ in range(len(commands)))
        try:
            if data and os.write(process.stdin.fileno(), data) < len(data):
                self._board.fail("the HAL component axistwin does not answer: check the load of the computer")
        except OSError:
            self._board.fail(ENDED)

    def complete(self, until_s: float) -> None:
        """Send the positions up to this time: all pulses before it have been queued."""
        self._act(self._board.complete, until_s)

    def restart(self, now_s: float) -> None:
        self._end()
        self._board.restart(now_s)
        self.start()

    def close(self) -> None:
        """End the HAL component, and also end HAL if HAL was started by axistwin."""
        self._end()

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is None:
            return
        assert process.stdin is not None
        process.stdin.close()
        try:
            process.wait(END_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        if self._owner:
            for words in (("stop",), ("unload", "all")):
                try:
                    self._halcmd(*words)
                except LinkError:
                    continue
