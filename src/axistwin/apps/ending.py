"""How a program that serves comes to its end: interrupted, asked to end, or by a bug, which is to be seen."""

import asyncio
import logging
import signal
from typing import Any

INTERRUPTED = 130


def ending() -> asyncio.Future[int]:
    """To be awaited for the exit code: 130 after Ctrl-C, 0 after SIGTERM.  A bug in a callback is raised there.

    What the system cannot do for one client is told, and the others go on.  Within a running event loop.
    """
    loop = asyncio.get_running_loop()
    ended: asyncio.Future[int] = loop.create_future()
    loop.set_exception_handler(lambda _, context: _surface(ended, context))
    for number, code in ((signal.SIGINT, INTERRUPTED), (signal.SIGTERM, 0)):
        loop.add_signal_handler(number, _end, ended, code)
    return ended


def _end(ended: asyncio.Future[int], code: int) -> None:
    if not ended.done():
        ended.set_result(code)


def _surface(ended: asyncio.Future[int], context: dict[str, Any]) -> None:
    error = context.get("exception")
    if isinstance(error, OSError):
        logging.getLogger("axistwin.links").warning("%s: %s", context["message"], error)
    elif not ended.done():
        ended.set_exception(error or RuntimeError(context["message"]))
