"""End a serving program after an interrupt, a termination signal, or an internal error of axistwin, which is raised.

A defect of the web framework or of the panel is logged with its traceback, and the program continues.
"""

import asyncio
import logging
import signal
from collections.abc import Callable
from functools import partial
from traceback import walk_tb
from typing import Any

INTERRUPTED = 130
ENDS = {"SIGINT": INTERRUPTED, "SIGTERM": 0, "SIGHUP": 0, "SIGBREAK": 0}
"""Signals and their exit codes: SIGHUP from a closed terminal or a lost connection, SIGBREAK on Windows
for Ctrl-Break and service managers."""
OWN_MODULES, DISPLAY_MODULES = "axistwin.", ("axistwin.ui.panel.",)
"""Modules whose errors end the program, and modules that only display the bench, whose errors do not."""


def ending() -> asyncio.Future[int]:
    """Return an asyncio future that is finished when this program receives Ctrl-C or SIGTERM.

    The result of the future is the exit code of the program: 130 after Ctrl-C, 0 after SIGTERM.  The future raises an
    internal error of axistwin.  An operating system error for one client and a defect of a module that only displays
    the bench are logged; the program continues.  Must be called within a running event loop.
    """
    loop = asyncio.get_running_loop()
    ended: asyncio.Future[int] = loop.create_future()
    loop.set_exception_handler(lambda _, context: _handle_exception(ended, context))
    for name, code in ENDS.items():
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:  # `nohup` ignores SIGHUP
            _subscribe(loop, number, partial(_end, ended, code))
    return ended


def _subscribe(loop: asyncio.AbstractEventLoop, number: int, callback: Callable[[], None]) -> None:
    try:
        loop.add_signal_handler(number, callback)
    except NotImplementedError:  # On Windows, the event loop of asyncio has no signal handlers.
        signal.signal(number, lambda *_: loop.is_closed() or loop.call_soon_threadsafe(callback))


def fail(ended: asyncio.Future[int], error: BaseException) -> None:
    """End the process of `axistwin` with the exception `error`, unless the process is already ending."""
    if not ended.done():
        ended.set_exception(error)


def _end(ended: asyncio.Future[int], code: int) -> None:
    if not ended.done():
        ended.set_result(code)


def _handle_exception(ended: asyncio.Future[int], context: dict[str, Any]) -> None:
    error = context.get("exception")
    if isinstance(error, OSError):
        logging.getLogger("axistwin.links").warning("%s: %s", context["message"], error)
    elif error is not None and _is_own(error):
        fail(ended, error)
    else:
        logging.getLogger("axistwin").error("%s", context["message"], exc_info=error)


def _is_own(error: BaseException) -> bool:
    """True if the error was raised by a callback or task of axistwin, but not of the panel."""
    modules = (f"{frame.f_globals.get('__name__', '')}." for frame, _ in walk_tb(error.__traceback__))
    began_in = next((name for name in modules if not name.startswith("asyncio")), "")
    return began_in.startswith(OWN_MODULES) and not began_in.startswith(DISPLAY_MODULES)
