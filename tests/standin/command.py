"""`axistwin stand-in` in a folder, with a simulated board in another process, in real time."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

HOME = Path(__file__).resolve().parents[2]


class StandInCommand:
    """The command and its board.  `program` is the process of the command; `first` is the first line that it prints."""

    def __init__(self, folder: Path, scene: str, *options: str) -> None:
        """Start both; the board's port in the scene is `board`.  Raises RuntimeError if the command ends at once."""
        self._folder = folder
        self._command = [sys.executable, "-m", "axistwin", "stand-in", "table.toml", *options]
        self._environment = {**os.environ, "PYTHONPATH": str(HOME / "src"), "PYTHONUNBUFFERED": "1"}
        (folder / "table.toml").write_text(scene)
        script = HOME / "tests" / "standin" / "pty_board.py"
        self._board = subprocess.Popen([sys.executable, script, folder / "board", folder / "pulses"])
        while not (folder / "board").is_symlink():
            time.sleep(0.01)
        self._errors = (folder / "errors").open("w+")
        self.program = subprocess.Popen(self._command, cwd=folder, env=self._environment, text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors)  # fmt: skip
        self.first = self.program.stdout.readline()
        if not self.first:
            StandInCommand.close(self)
            raise RuntimeError((folder / "errors").read_text())

    @property
    def journal(self) -> Path:
        """The journal of the command, which grows while pulses are sent."""
        return self._folder / "table.journal"

    def stops(self) -> list[str]:
        return [line for line in (self._folder / "errors").read_text().splitlines() if "stopped:" in line]

    def again(self) -> "subprocess.CompletedProcess[bytes]":
        return subprocess.run(
            self._command, cwd=self._folder, env=self._environment, capture_output=True, check=False, timeout=300
        )

    def close(self) -> dict[str, object]:
        """End both processes; return the pulses and levels of the board."""
        self.program.terminate()
        self.program.wait(30)
        self.program.stdin.close()
        self.program.stdout.close()
        self._errors.close()
        self._board.terminate()
        self._board.wait()
        return json.loads((self._folder / "pulses").read_text())
