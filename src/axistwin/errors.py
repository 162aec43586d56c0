"""What a *user of axistwin* can do wrong.  One line each, with place and remedy; the command line prints it.

What a *host* does wrong is no exception: the device ignores it, sets a flag, lights its LED.
Anything else that is raised is a bug and must surface.
"""


class AxistwinError(Exception):
    """Something the user can mend.  The message is one line and says how."""


class UsageError(AxistwinError):
    """An option, a name or a value that does not exist."""


class MissingExtraError(UsageError):
    """A library that only some users need is not installed."""

    def __init__(self, library: str, extra: str) -> None:
        super().__init__(f'needs {library}: pip install "axistwin[{extra}]"')


class PlacedError(AxistwinError):
    """An error in a text the user wrote: `file:line:column: message`."""

    def __init__(self, message: str, *, file: str = "", line: int = 0, column: int = 0) -> None:
        self.message, self.file, self.line, self.column = message, file, line, column
        place = ":".join(str(part) for part in (file, line, column) if part)
        super().__init__(f"{place}: {message}" if place else message)


class SceneError(PlacedError):
    """A scene file that cannot be built."""


class ProgramError(PlacedError):
    """A program or conversation that cannot be read."""


class LinkError(AxistwinError):
    """A port, socket, pty or serial device that cannot be opened."""
