"""Errors of a driver: each message is one line with the fault and its remedy."""


class DriverError(Exception):
    """Base class of all errors of a driver.

    `in_step`: True if no part of an answer can still arrive, so that the next operation needs no re-synchronisation.
    """

    in_step = True


class PortError(DriverError):
    """Raised if a port cannot be opened, or is closed during an operation."""

    in_step = False


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
