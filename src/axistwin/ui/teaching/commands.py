"""Commands of a terminal itself, such as `:why`: a colon and a lower-case word, which no controller accepts."""

import re

_COMMAND = re.compile(r":([a-z]+)(?:\s+(.*))?")


def own_command(line: str) -> tuple[str, str] | None:
    """Split a terminal command, e.g. `:why`, into its name and its argument.

    The result is None for a line that is sent to the controller.  A sequence of an IF1 also begins with a colon, but is
    upper case.
    """
    found = _COMMAND.fullmatch(line)
    return None if found is None else (found[1], (found[2] or "").strip())
