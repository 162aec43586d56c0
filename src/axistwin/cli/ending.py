"""How a program that serves comes to its end: interrupted, asked to end, or by a defect of its own, which is raised.

A defect of the web framework or of the panel, or what a bad client provokes there, is reported with its traceback, and
everybody else is served on.
"""

import asyncio
import logging
import signal
from collections.abc import Iterator
from traceback import walk_tb
from typing import Any

INTERRUPTED = 130
OWN, GUESTS = "axistwin.", ("axistwin.panel.",)
"""Modules whose callbacks and tasks serve the bench; and those among them that only show it."""


def ending() -> asyncio.Future[int]:
    """To be awaited for the exit code: 130 after Ctrl-C, 0 after SIGTERM.  A defect of ours in a callback is raised.

    What the system cannot do for one client is reported, and so is a defect of a guest; the others are served on.
    Within a running event loop.
    """
    loop = asyncio.get_running_loop()
    ended: asyncio.Future[int] = loop.create_future()
    loop.set_exception_handler(lambda _, context: _surface(ended, context))
    for number, code in ((signal.SIGINT, INTERRUPTED), (signal.SIGTERM, 0)):
        loop.add_signal_handler(number, _end, ended, code)
    return ended


def fail(ended: asyncio.Future[int], error: BaseException) -> None:
    """End with this error, unless the end has come already."""
    if not ended.done():
        ended.set_exception(error)


def _end(ended: asyncio.Future[int], code: int) -> None:
    if not ended.done():
        ended.set_result(code)


def _surface(ended: asyncio.Future[int], context: dict[str, Any]) -> None:
    error = context.get("exception")
    if isinstance(error, OSError):
        logging.getLogger("axistwin.links").warning("%s: %s", context["message"], error)
    elif error is not None and _is_ours(error):
        fail(ended, error)
    else:
        logging.getLogger("axistwin").error("%s", context["message"], exc_info=error)


def _is_ours(error: BaseException) -> bool:
    """True if the callback or task that has raised this is of axistwin, and not of a guest."""
    began_in = next((name for name in _modules(error) if not name.startswith("asyncio")), "")
    return began_in.startswith(OWN) and not began_in.startswith(GUESTS)


def _modules(error: BaseException) -> Iterator[str]:
    """The modules that the error has passed through, the outermost first, each with a dot at its end."""
    for frame, _ in walk_tb(error.__traceback__):
        yield f"{frame.f_globals.get('__name__', '')}."
