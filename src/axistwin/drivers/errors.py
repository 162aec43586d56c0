"""Errors of a driver: each message is one line that says what is wrong and what to do."""


class DriverError(Exception):
    """An operation that failed.

    `in_step`: True if no part of an answer can still arrive, so that the next operation needs no re-synchronisation.
    """

    in_step = True


class PortError(DriverError):
    """A port that cannot be opened, or that was closed during an operation."""

    in_step = False


class SilentError(DriverError):
    """No answer, or half an answer, within the timeout."""

    in_step = False


class WrongAnswerError(DriverError):
    """An answer that this controller cannot give: a disturbed line, or another controller at the port."""

    in_step = False


class RefusedError(DriverError):
    """A command that the controller has refused, or that it would refuse in its present state."""


class BusyError(RefusedError):
    """A command that has to wait for the end of a motion."""


class PositionLostError(DriverError):
    """The position is not known: the power was cut, or another host has moved the axis."""
