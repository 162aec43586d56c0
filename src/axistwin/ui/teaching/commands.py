"""Commands of a terminal itself, such as `:why`: a colon and a lower-case word, which no controller accepts."""

import re

_COMMAND = re.compile(r":([a-z]+)(?:\s+(.*))?")


def own_command(line: str) -> tuple[str, str] | None:
    """Split a command such as `:why` into name and argument; None for any other line, e.g. an IF1's `:X400:$`."""
    found = _COMMAND.fullmatch(line)
    return None if found is None else (found[1], (found[2] or "").strip())
