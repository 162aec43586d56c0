"""Errors of a driver: each message is one line with the fault and its remedy."""

from typing import TYPE_CHECKING

from axistwin.core.errors import LinkError

if TYPE_CHECKING:
    from axistwin.drivers.axis import Status


class DriverError(Exception):
    """Base class of all errors that a driver raises.

    `in_step`: True if no part of an answer can still arrive, so that the next operation needs no re-synchronisation.
    """

    in_step = True


class PortError(DriverError, LinkError):
    """Raised if a port cannot be opened, or if a port is closed during an operation."""

    in_step = False


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
