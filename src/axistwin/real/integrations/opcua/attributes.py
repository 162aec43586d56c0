"""Reads and writes of values."""

import dataclasses
from collections.abc import Awaitable, Callable
from datetime import UTC, datetime
from typing import Any

from asyncua import ua
from asyncua.server.address_space import AttributeService
from asyncua.server.internal_server import InternalServer

from axistwin.drivers.errors import DriverError, PositionLostError, RefusedError

NO_ANSWER, LOST = int(ua.StatusCodes.BadNoCommunication), int(ua.StatusCodes.BadSensorFailure)
Write = Callable[[Any], Awaitable[None]]
BAD_VALUE = (DriverError, TypeError, ValueError, ArithmeticError)  # A request that server or controller refuses.


def stamped(variant: ua.Variant, code: int = ua.StatusCodes.Good) -> ua.DataValue:
    """Return a value with its status code, and with the present time as source and server time stamps."""
    now = datetime.now(UTC)
    return ua.DataValue(variant, ua.StatusCode(code), SourceTimestamp=now, ServerTimestamp=now)


class Attributes(AttributeService):
    """Sends each value that a client writes to the axis, pin or register that its node represents."""

    def __init__(self, server: InternalServer) -> None:
        super().__init__(server.aspace)
        self.writes: dict[ua.NodeId, tuple[ua.VariantType, Write]] = {}

    def read(self, params: ua.ReadParameters) -> list[ua.DataValue]:
        """Return the requested attributes; the values are of now, because the controllers are polled."""
        now = datetime.now(UTC)
        return [
            dataclasses.replace(found, ServerTimestamp=now) if asked.AttributeId == ua.AttributeIds.Value else found
            for asked, found in zip(params.NodesToRead, super().read(params), strict=True)
        ]

    async def write(self, params: ua.WriteParameters, *user: Any, **named: Any) -> list[ua.StatusCode]:
        found = []
        for given in params.NodesToWrite:
            kind, write = self.writes.get(given.NodeId, (None, None))
            if write is None or given.AttributeId != ua.AttributeIds.Value:
                found += await super().write(ua.WriteParameters([given]), *user, **named)
            else:
                found.append(ua.StatusCode(await self._write(given, kind, write)))
        return found

    async def _write(self, given: ua.WriteValue, kind: ua.VariantType, write: Write) -> int:
        variant, status = given.Value.Value, given.Value.StatusCode
        if given.IndexRange or (status is not None and not status.is_good()):
            return int(ua.StatusCodes.BadWriteNotSupported)
        if variant is None or variant.VariantType != kind or variant.is_array:
            return int(ua.StatusCodes.BadTypeMismatch)
        try:
            await write(variant.Value)
        except BAD_VALUE as error:
            return status_code(error)
        await self._aspace.write_attribute_value(given.NodeId, given.AttributeId, stamped(variant))
        return int(ua.StatusCodes.Good)


def number(given: ua.Variant) -> float:
    """Return the number that a client has sent.  Raises TypeError for anything else, e.g. True or "5"."""
    if isinstance(given.Value, bool) or not isinstance(given.Value, int | float):
        raise TypeError(f"invalid {given.VariantType.name}: expected a number, e.g. 12.5")
    return float(given.Value)


def status_code(error: Exception) -> int:
    match error:
        case PositionLostError():
            return LOST
        case RefusedError():
            return int(ua.StatusCodes.BadInvalidState)
        case DriverError():
            return NO_ANSWER
        case TypeError():
            return int(ua.StatusCodes.BadTypeMismatch)
        case _:
            return int(ua.StatusCodes.BadOutOfRange)
