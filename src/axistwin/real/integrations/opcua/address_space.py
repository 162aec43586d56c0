"""Nodes of axes, pins and registers.

Objects/Machines/CONTROLLER/Identification, …/Axes/AXIS, …/Pins, …/Registers.  The folder `Machines` and the names in
`Identification` are those of OPC 40001-1, Machinery.
"""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

from asyncua import Node, Server, ua

from axistwin.drivers.axis import Scale
from axistwin.drivers.errors import RefusedError
from axistwin.real.integrations.driven_axis import DrivenAxis, Goal
from axistwin.real.integrations.opcua.attributes import (
    BAD_VALUE,
    LOST,
    NO_ANSWER,
    Attributes,
    Write,
    number,
    stamped,
    status_code,
)
from axistwin.real.integrations.pins_and_registers import Point
from axistwin.real.integrations.station import Station

NAMESPACE, MACHINERY = "urn:axistwin:axes", "http://opcfoundation.org/UA/Machinery/"
MANUFACTURERS = {"if1": "Digiplan", "if2": "Digiplan", "1810": "Compumotor", "1811": "Compumotor"}
BEGIN_S = 3.0  # Longest time for which a method waits for the beginning of a motion; clients wait for 4 s by default.
GOOD, ESTIMATED = ua.StatusCodes.Good, ua.StatusCodes.UncertainSensorNotAccurate
DOUBLE, BOOL, TEXT, INT = ua.VariantType.Double, ua.VariantType.Boolean, ua.VariantType.String, ua.VariantType.Int64


class AddressSpace:
    """The OPC UA nodes of all controllers."""

    def __init__(self, server: Server) -> None:
        self.server = server
        self._attributes = server.iserver.attribute_service = Attributes(server.iserver)

    async def build(self, stations: list[Station]) -> None:
        self._index = await self.server.register_namespace(NAMESPACE)
        machinery = await self.server.register_namespace(MACHINERY)
        machines = await self.server.nodes.objects.add_folder(
            ua.NodeId("Machines", self._index), ua.QualifiedName("Machines", machinery)
        )
        for station in stations:
            await self._add_station(machines, machinery, station)

    def _id(self, *names: str) -> tuple[ua.NodeId, ua.QualifiedName]:
        return ua.NodeId(".".join(names), self._index), ua.QualifiedName(names[-1], self._index)

    async def _add_station(self, machines: Node, machinery: int, station: Station) -> None:
        machine = await machines.add_object(*self._id(station.name))
        identification = await machine.add_folder(
            ua.NodeId(f"{station.name}.Identification", self._index), ua.QualifiedName("Identification", machinery)
        )
        facts = {
            "Manufacturer": MANUFACTURERS.get(station.model, "Animatics"), "Model": station.model,
            "ProductInstanceUri": f"urn:axistwin:{station.name}", "SerialNumber": "unknown",
            "Location": station.driver.url,
        }  # fmt: skip
        for name, text in facts.items():
            identifier = ua.NodeId(f"{station.name}.Identification.{name}", self._index)
            await identification.add_property(identifier, ua.QualifiedName(name, machinery), text)
        axes = await machine.add_folder(*self._id(station.name, "Axes"))
        for name, axis in station.axes.items():
            await AxisNodes(self, axis).build(axes, station.name, name)
        folders = {bit: await machine.add_folder(*self._id(station.name, title)) for bit, title in POINTS.items()}
        for point in station.points:
            await self._add_point(folders[point.bit], station.name, point)

    async def add_variable(
        self, parent: Node, names: tuple[str, ...], kind: ua.VariantType, value: Any, write: Write | None = None
    ) -> Node:
        """Create a variable under the node `parent`; clients can write it if `write` is given."""
        found = await parent.add_variable(*self._id(*names), ua.Variant(value, kind, is_array=isinstance(value, list)))
        if write is not None:
            await found.set_writable()
            self._attributes.writes[found.nodeid] = kind, write
        return found

    async def publish(self, node: Node, kind: ua.VariantType, value: Any, code: int = GOOD) -> None:
        variant = ua.Variant(value, kind, is_array=isinstance(value, list))
        await self.server.write_attribute_value(node.nodeid, stamped(variant, code))

    async def add_method(
        self, parent: Node, names: tuple[str, ...], act: Callable[..., Awaitable[None]], *arguments: str
    ) -> None:
        async def call(_: ua.NodeId, *given: ua.Variant) -> ua.StatusCode:
            if len(given) < len(arguments):
                return ua.StatusCode(ua.StatusCodes.BadArgumentsMissing)
            if len(given) > len(arguments):
                return ua.StatusCode(ua.StatusCodes.BadTooManyArguments)
            try:
                await act(*map(number, given))
            except BAD_VALUE as error:
                return ua.StatusCode(status_code(error))
            return ua.StatusCode()

        listed = [ua.Argument(Name=name, DataType=ua.NodeId(ua.ObjectIds.Double), ValueRank=-1) for name in arguments]
        await parent.add_method(*self._id(*names), call, listed, [])

    async def _add_point(self, folder: Node, station: str, point: Point) -> None:
        kind = BOOL if point.bit else INT

        async def write(value: int) -> None:
            if not -(2**31) <= value < 2**31:
                raise ValueError(f"invalid number {value}: expected 32 bits")
            await point.write(int(value))

        async def publish(value: int) -> None:
            await self.publish(node, kind, bool(value) if point.bit else value)

        names = (station, POINTS[point.bit], point.name)
        start = bool(point.value) if point.bit else point.value or 0
        node = await self.add_variable(folder, names, kind, start, write if point.writable else None)
        if point.value is None:
            await self.publish(node, kind, start, ua.StatusCodes.UncertainInitialValue)
        point.observers.append(publish)


POINTS = {True: "Pins", False: "Registers"}  # Folders of bits and of numbers.


class AxisNodes:
    """The variables and methods of an axis.  Positions are in the unit of the axis."""

    def __init__(self, space: AddressSpace, axis: DrivenAxis) -> None:
        self._space, self._axis = space, axis
        self._scale = Scale(float(axis.units.per), axis.units.of)
        self._nodes: dict[str, tuple[Node, ua.VariantType]] = {}
        self._published: dict[str, tuple[Any, int]] = {}
        self._error = ""
        self._last: Goal | None = None

    async def build(self, axes: Node, station: str, name: str) -> None:
        space, names = self._space, (station, "Axes", name)
        parent = await axes.add_object(ua.NodeId(f"{station}.{name}", space._index), f"{space._index}:{name}")
        core, per = self._axis.core, abs(self._scale.counts_per_unit)
        for title, value in self._values().items():
            kind = _kind(value[0])
            self._nodes[title] = (await space.add_variable(parent, (*names, title), kind, value[0]), kind)
        writable = {
            "Speed": (core.velocity / per, self._set_speed),
            "Acceleration": (core.acceleration / per, self._set_acceleration),
        }
        for title, (start, write) in writable.items():
            await space.add_variable(parent, (*names, title), DOUBLE, start, write)
        unit = ua.EUInformation(DisplayName=ua.LocalizedText(self._scale.unit))
        await self._nodes["Position"][0].add_property(0, "EngineeringUnits", unit)
        methods: dict[str, tuple[Callable[..., Awaitable[None]], tuple[str, ...]]] = {
            "MoveTo": (self._move_to, ("Position",)), "MoveBy": (self._move_by, ("Distance",)),
            "MoveAt": (self._move_at, ("Velocity",)), "Home": (self._home, ("Direction",)),
            "Stop": (self._axis.stop, ()), "Abort": (lambda: self._axis.stop(abort=True), ()),
            "SetPosition": (self._set_position, ("Position",)), "ClearFaults": (self._axis.clear_faults, ()),
        }  # fmt: skip
        for title, (act, arguments) in methods.items():
            await space.add_method(parent, (*names, title), act, *arguments)
        self._axis.changed = self._publish
        await self._publish()

    # Values

    def _values(self) -> dict[str, tuple[Any, int]]:
        axis = self._axis
        status = self._scale.status(axis.status)
        code = NO_ANSWER if axis.error else LOST if status.lost else ESTIMATED if status.estimated else GOOD
        state = NO_ANSWER if axis.error else GOOD
        goal = axis.goal or axis.ended
        if goal is not None and goal.failure:
            self._error = goal.failure
        ended = axis.ended
        arrived = ended is not None and (ended.target is not None or ended.homing) and not ended.failure
        return {
            "Position": (float(self._units(axis.status.position)), code),
            "Target": (float(status.setpoint), state),
            "Velocity": (float(status.velocity), state),
            "Moving": (status.moving, state),
            "LimitPlus": (status.limit_plus, state),
            "LimitMinus": (status.limit_minus, state),
            "AtHome": (status.at_home, state),
            "Faults": ([str(fault) for fault in status.faults] + ([status.lost] if status.lost else []), state),
            "LastError": (axis.error or self._error, GOOD),
            "Arrived": (arrived and not axis.busy and not status.missed, state),
            "Busy": (axis.busy, state),  # the last one: what a client reads when it is false is final
        }

    def _units(self, counts: float) -> float:
        return self._axis.units.value(counts)

    async def _publish(self) -> None:
        for title, value in self._values().items():
            if self._published.get(title) != value:
                self._published[title] = value
                node, kind = self._nodes[title]
                await self._space.publish(node, kind, *value)

    # Methods

    async def _begin(self, goal: Goal) -> None:
        """Request a motion, and wait shortly for its start; another axis may delay it for longer."""
        self._error = ""
        self._axis.status.known_position() if goal.target is not None else None
        await self._axis.begin(goal)
        try:
            async with asyncio.timeout(BEGIN_S):
                await goal.begun.wait()
        except TimeoutError:
            return
        if reason := goal.failure:
            self._error = reason
            await self._publish()
            raise RefusedError(f"the motion failed: {reason}")

    def _counts(self, position: float) -> int:
        counts, limit = self._scale.counts(position), self._axis.core.max_position
        if abs(counts) > limit:
            raise ValueError(f"position {position:g} is out of range: expected at most {self._units(limit):g}")
        return counts

    async def _move_to(self, position: float) -> None:
        target = self._counts(position)
        await self._begin(Goal(lambda: self._axis.core.move_to(target), target))

    async def _move_by(self, distance: float) -> None:
        await self._move_to(self._units(self._axis.status.position) + distance)

    async def _move_at(self, velocity: float) -> None:
        counts = velocity * self._scale.counts_per_unit
        if not abs(counts) <= self._axis.core.max_velocity:
            raise ValueError(f"velocity {velocity:g} is out of range: expected at most the maximum of the axis")
        await self._begin(Goal(lambda: self._axis.core.move_at(counts)))

    async def _home(self, direction: float) -> None:
        if direction not in (1, -1):
            raise ValueError(f"invalid direction {direction}: expected 1 or -1")
        sign = int(direction) if self._scale.counts_per_unit > 0 else -int(direction)
        await self._begin(Goal(lambda: self._axis.core.home(sign), homing=True))

    async def _set_position(self, position: float) -> None:
        await self._axis.set_position(self._counts(position))

    async def _set_speed(self, value: float) -> None:
        self._axis.core.velocity = self._rate(value, self._axis.core.max_velocity)

    async def _set_acceleration(self, value: float) -> None:
        self._axis.core.acceleration = self._rate(value, 2**31 - 1)

    def _rate(self, value: float, limit: float) -> float:
        rate = self._scale.rate(value)
        if not (value > 0 and rate <= limit):
            raise ValueError(f"{value:g} is out of range: expected more than 0, and at most {limit:g} in counts")
        return rate


def _kind(value: Any) -> ua.VariantType:
    return BOOL if isinstance(value, bool) else DOUBLE if isinstance(value, float) else TEXT
