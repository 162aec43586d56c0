"""Errors of a driver: each message is one line with the fault and its remedy."""

import os


class DriverError(Exception):
    """Base class of all errors of a driver.

    `in_step`: True if no part of an answer can still arrive, so that the next operation needs no re-synchronisation.
    """

    in_step = True


class PortError(DriverError):
    """Raised if a port cannot be opened, or is closed during an operation."""

    in_step = False


def cannot_open(url: str, error: Exception) -> PortError:
    """Return the error for a port that cannot be opened; `error` may be pyserial's wrapper of an error."""
    cause = error.__context__ or error
    if isinstance(cause, OSError) and cause.errno:
        reason = os.strerror(cause.errno) if cause.errno > 0 else cause.strerror or str(cause)
        remedy = (
            "start its server, and check the address"
            if "://" in url
            else "check its name, the cable and its permissions"
        )
        return PortError(f"cannot open {url}: {reason.lower()}: {remedy}")
    reason = "no port number" if isinstance(cause, TypeError) else str(error)
    return PortError(f"cannot open {url}: {reason}; expected a port, e.g. socket://127.0.0.1:5001")


class SilentError(DriverError):
    """Raised if the controller has sent no answer or only a part of an answer within the timeout."""

    in_step = False


class WrongAnswerError(DriverError):
    """Raised for an answer that this controller cannot give: a disturbed line, or another controller at the port."""

    in_step = False


class RefusedError(DriverError):
    """Raised for a command that the controller has refused, or would refuse in its present state."""


class BusyError(RefusedError):
    """Raised for a command that is possible only after the end of the present motion."""


class PositionLostError(DriverError):
    """Raised if the position is not known: the power was cut, or another host has moved the axis."""
