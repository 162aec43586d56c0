"""Errors of a driver: each message is one line with the fault and its remedy."""

import os
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from axistwin.drivers.axis import Status


class DriverError(Exception):
    """Base class of all errors that a driver raises.

    `in_step`: True if no part of an answer can still arrive, so that the next operation needs no re-synchronisation.
    """

    in_step = True


class PortError(DriverError):
    """Raised if a port cannot be opened, or if a port is closed during an operation."""

    in_step = False


def opening_fault(url: str, error: Exception) -> tuple[str, str]:
    """Return the reason why a port cannot be opened, and a remedy.

    `error` may be an error of pyserial, which has the error of the operating system as its context.
    """
    cause = error.__context__ or error
    if isinstance(cause, OSError) and cause.errno:
        reason = os.strerror(cause.errno) if cause.errno > 0 else cause.strerror or str(cause)
        remedy = (
            "start the server, and check the address"
            if "://" in url
            else "check the name of the port, the cable and your permissions"
        )
        return reason.lower(), remedy
    reason = "no port number" if isinstance(cause, TypeError) else str(error)
    return reason, "expected a port, e.g. socket://127.0.0.1:5001"


class SilentError(DriverError):
    """Raised if the controller sends no complete answer within the timeout."""

    in_step = False


class WrongAnswerError(DriverError):
    """Raised if the answer of the controller is invalid, e.g. because of noise on the line."""

    in_step = False


class RefusedError(DriverError):
    """Raised for a command that the controller refuses."""


class BusyError(RefusedError):
    """Raised for a command that is not possible during a motion."""


class StoppedError(RefusedError):
    """Raised if a move or a search for home has ended elsewhere.  `status`: the status of the axis at rest."""

    def __init__(self, name: str, status: "Status") -> None:
        super().__init__(f"axis {name} stopped at {status.position:g}: {status.missed}")
        self.status = status


class PositionLostError(DriverError):
    """Raised if the position of an axis is not known, e.g. after a power cut."""
