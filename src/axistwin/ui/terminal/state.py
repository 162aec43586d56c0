"""Files that the terminal keeps from one session to the next."""

import os
from pathlib import Path


def state_file(name: str) -> Path:
    usual = Path.home() / (".local/state" if os.name == "posix" else "AppData/Local")
    state = os.environ.get("XDG_STATE_HOME") or os.environ.get("LOCALAPPDATA") or usual
    return Path(state) / "axistwin" / name
