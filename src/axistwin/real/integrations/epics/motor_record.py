"""A motor record on an axis: what a write does, and what a poll changes.

Positions: user = dial × (1 or -1, DIR) + OFF; dial = counts × MRES.  The counts per unit are an exact fraction, so that
a position that was written as 0.3 is read as 0.3.
"""

from collections.abc import Awaitable, Callable
from fractions import Fraction
from functools import partial
from math import ceil, floor
from typing import Any

from axistwin.drivers.axis import Status
from axistwin.drivers.errors import RefusedError
from axistwin.real.integrations.driven_axis import DrivenAxis, Goal
from axistwin.real.integrations.epics.fields import GO, MOST, MOTOR, MOVE, PAUSE, STOP, checked, decimals
from axistwin.real.integrations.epics.state import SILENT, Alarm, alarm_of, status_bits

SCALED = ("VMAX", "VELO", "JVEL", "HVEL", "BVEL", "TWV", "JAR", "DHLM", "DLLM")  # Fields that are scaled with MRES.
LIMITS = ("limit", "positive limit", "negative limit")  # Names of the faults of limit switches.
FINEST = 10**9  # Largest denominator of MRES as a fraction.


Post = Callable[[str, Any], Awaitable[None]]
Put = Callable[["MotorRecord", Any], Awaitable[None]]


class MotorRecord:
    """The fields of a motor record; `observers` get each changed field, "" for alarm and metadata."""

    def __init__(self, axis: DrivenAxis, name: str, description: str) -> None:
        self.axis, self.name = axis, name
        self.values: dict[str, Any] = {field: found.value for field, found in MOTOR.items()}
        self.alarm = Alarm("UDF", "INVALID")
        self.observers: list[Post] = []
        self._per = axis.units.per
        self._homed = False
        self._jogging: str | None = None
        self._set_up(description)
        axis.changed = self._update

    def _set_up(self, description: str) -> None:
        core, values = self.axis.core, self.values
        values.update(NAME=self.name, RTYP="motor", DESC=description[:40], DTYP="axistwin", STAT="UDF", UDF=1)
        values.update(OUT=f"@{self.axis.station.driver.url}"[:39], EGU=self.axis.units.of, VERS=1.0, SEVR=3)
        values["PREC"] = decimals(self._per)
        unit = 1 / float(abs(self._per))
        values.update(VELO=core.velocity * unit, ACCL=core.velocity / core.acceleration, VMAX=core.max_velocity * unit)
        values.update(JVEL=values["VELO"], HVEL=values["VELO"], BVEL=values["VELO"], TWV=values["VELO"] / 10)
        values.update(JAR=core.acceleration * unit, BACC=values["ACCL"])
        ends = sorted(self._dial(end) for end in self.axis.travel() or (-core.max_position, core.max_position))
        values.update(LLM=ends[0], DLLM=ends[0], HLM=ends[1], DHLM=ends[1])
        self._set_resolution()

    def _set_resolution(self) -> None:
        values = self.values
        values["MRES"] = values["ERES"] = float(1 / self._per)
        values["RDBD"] = values["UREV"] = abs(values["MRES"])
        values.update(S=values["VELO"] / values["UREV"], SMAX=values["VMAX"] / values["UREV"])

    # Positions

    @property
    def _sign(self) -> int:
        return -1 if self.values["DIR"] else 1

    def _dial(self, counts: float) -> float:
        return float(Fraction(counts) / self._per)

    def _user(self, dial: float) -> float:
        return float(dial * self._sign + self.values["OFF"])

    def _dial_of(self, user: float) -> float:
        return float((user - self.values["OFF"]) * self._sign + 0.0)

    def _counts(self, dial: float) -> int:
        return round(Fraction(dial) * self._per)

    def _outside(self, dial: float) -> bool:
        low, high = self.values["DLLM"], self.values["DHLM"]
        return bool(low != high and not low <= dial <= high)

    # Writes

    def writable(self, field: str) -> bool:
        return field in PUTS

    async def put(self, field: str, value: Any) -> None:
        """Write a field; a motion returns when the axis is at rest.  Raises DriverError if the write fails."""
        if field not in PUTS:
            raise RefusedError(f"{field} cannot be written: expected a writable field, e.g. VAL")
        await PUTS[field](self, checked(field, value))

    async def _post(self, field: str, value: Any) -> None:
        for observer in self.observers:
            await observer(field, value)

    async def _set(self, **changed: Any) -> None:
        for field, value in changed.items():
            if self.values[field] != value:
                self.values[field] = value
                await self._post(field, value)

    async def _move(self, user: float) -> None:
        """Move to a position in user coordinates; in SET mode, give the present position this coordinate."""
        dial = self._dial_of(user)
        if self.values["SET"]:
            await self._define(user, dial)
            return
        self._allowed()
        if self._outside(dial):
            await self._set(LVIO=1)
            low, high = self.values["LLM"], self.values["HLM"]
            raise RefusedError(f"position {user:g} is outside the limits: expected {low:g} to {high:g}")
        self.axis.status.known_position()
        await self._set(LVIO=0, VAL=user, DVAL=dial, RVAL=float(self._counts(dial)), MISS=0)
        await self._leave_switch()
        self._apply_profile(self.values["VELO"], self.values["ACCL"])
        await self.axis.move_to(self._counts(dial))

    async def _leave_switch(self) -> None:
        """Clear the fault of a limit switch, as clients of a motor record expect to move away from a switch."""
        faults = self.axis.status.faults
        if faults and all(fault.name in LIMITS for fault in faults):
            await self.axis.clear_faults()

    def _allowed(self) -> None:
        if self.values["SPMG"] == STOP:
            raise RefusedError("the field SPMG is Stop: set SPMG to Go before a motion")

    async def _define(self, user: float, dial: float) -> None:
        if self.values["FOFF"] or self.axis.status.lost:
            await self.axis.set_position(self._counts(dial))
        else:
            await self._offset(user - self._dial(self.axis.status.position) * self._sign)
        await self._follow_readback()

    async def _offset(self, offset: float) -> None:
        """Change OFF; the dial positions stay."""
        await self._set(OFF=offset)
        await self._refresh_limits()
        await self._follow_readback()
        await self._update()

    async def _refresh_limits(self) -> None:
        ends = [self._user(self.values[name]) for name in ("DLLM", "DHLM")]
        low, high = ends if self._sign > 0 else reversed(ends)
        await self._set(LLM=low, HLM=high)
        await self._post("", None)

    async def _follow_readback(self) -> None:
        position = self.axis.status.position
        dial = self._dial(position)
        await self._set(VAL=self._user(dial), DVAL=dial, RVAL=float(round(position)))

    def _apply_profile(self, velocity: float, seconds: float) -> None:
        core = self.axis.core
        counts = velocity * float(abs(self._per))
        if not counts / seconds < MOST:
            raise RefusedError(f"ACCL={seconds:g} is out of range: expected a longer time")
        core.velocity, core.acceleration = counts, counts / seconds

    async def _jog(self, field: str, on: int) -> None:
        if not on:
            if self._jogging == field:
                await self.axis.stop()
            return
        self._allowed()
        direction = (1 if field == "JOGF" else -1) * self._sign
        goal = self._jog_goal(direction)
        if goal is None:
            await self._set(LVIO=1)
            raise RefusedError(f"{field} would jog the axis beyond the position limit: jog in the other direction")
        await self._leave_switch()
        self._apply_profile(self.values["JVEL"], self.values["ACCL"])
        self._jogging = field
        await self._set(LVIO=0, **{field: 1})
        try:
            await self.axis.request(goal)
            await self._set(LVIO=int(self._jog_goal(direction) is None))
        finally:
            self._jogging = None if self._jogging == field else self._jogging
            await self._set(**{field: 0})

    def _jog_goal(self, direction: int) -> Goal | None:
        """Return a jog as a move to the limit on the side `direction` (1: DHLM), to rest there; None at the limit.

        Without limits (both equal), or while the position is lost, the jog is a run.
        """
        low, high = self.values["DLLM"], self.values["DHLM"]
        core, counts = self.axis.core, direction if self._per > 0 else -direction
        if low == high or self.axis.status.lost:
            velocity = counts * self.values["JVEL"] * float(abs(self._per))
            return Goal(lambda: core.move_at(velocity))
        limit = round(Fraction(high if direction > 0 else low) * self._per, 6)  # 0.3 mm are 300 counts, not 299.99…
        position = round(self.axis.status.position)
        left = min((floor(limit) - position) if counts > 0 else position - ceil(limit), core.max_position)
        return Goal(lambda: core.move_to(position + counts * left)) if left > 0 and low < high else None

    async def _home(self, field: str, on: int) -> None:
        if not on:
            return
        self._allowed()
        await self._leave_switch()
        direction = (1 if field == "HOMF" else -1) * self._sign * (1 if self._per > 0 else -1)
        self._apply_profile(self.values["VELO"], self.values["ACCL"])
        await self._set(**{field: 1})
        try:
            await self.axis.home(direction)
            self._homed = True
        finally:
            await self._set(**{field: 0})
            await self._update()

    async def _tweak(self, sign: int, on: int) -> None:
        if on:
            await self._move(self.values["VAL"] + sign * self.values["TWV"])

    async def _stop(self, on: int) -> None:
        if on:
            await self.axis.stop()

    async def _stop_pause_move_go(self, choice: int) -> None:
        await self._set(SPMG=choice)
        if choice in (MOVE, GO):
            self.axis.resume()
        elif choice == PAUSE:
            await self.axis.pause()
        else:
            self.axis.resume()
            await self.axis.stop()

    async def _velocity(self, field: str, value: float) -> None:
        most = self.values["VMAX"] if field != "VMAX" else self.axis.core.max_velocity / float(abs(self._per))
        if not 0 < value <= most:
            raise RefusedError(f"{field}={value:g} is out of range: expected a value above 0 and at most {most:g}")
        await self._set(**{field: value})
        if field in ("VELO", "VMAX"):
            unit = self.values["UREV"]
            await self._set(S=self.values["VELO"] / unit, SMAX=self.values["VMAX"] / unit)

    async def _positive(self, field: str, value: float) -> None:
        if not value > 0:
            raise RefusedError(f"{field}={value:g} is out of range: expected a value above 0")
        await self._set(**{field: value})

    async def _user_limit(self, field: str, value: float) -> None:
        await self._dial_limit("DHLM" if (field == "HLM") == (self._sign > 0) else "DLLM", self._dial_of(value))

    async def _dial_limit(self, field: str, value: float) -> None:
        await self._set(**{field: value})
        await self._refresh_limits()
        if self._jogging:
            await self.axis.stop()  # the jog is a move to the limit as it was

    async def _direction(self, choice: int) -> None:
        self._at_rest("DIR")
        await self._set(DIR=choice)
        await self._offset(self.values["OFF"])

    async def _resolution(self, value: float) -> None:
        """Change MRES, the length of a count; velocities and limits in counts stay the same."""
        self._at_rest("MRES")
        found = Fraction(value).limit_denominator(FINEST)
        if not found:
            raise RefusedError("MRES cannot be 0: expected another number, e.g. 0.01")
        before, self._per = self._per, 1 / found
        ratio = float(abs(before / self._per))
        scaled = {name: self.values[name] * ratio for name in SCALED}
        kept = dict(self.values)
        self.values.update(scaled)
        self._set_resolution()
        changed = {field: value for field, value in self.values.items() if kept[field] != value}
        self.values = kept
        await self._set(**changed)
        await self._refresh_limits()
        await self._follow_readback()
        await self._update()

    def _at_rest(self, field: str) -> None:
        if self.axis.busy:
            raise RefusedError(f"{field} cannot be changed during a motion: stop the axis first")

    async def _keep(self, field: str, value: Any) -> None:
        await self._set(**{field: value})

    async def _shown(self, field: str, value: Any) -> None:
        await self._set(**{field: value})
        await self._post("", None)

    async def _poll(self, on: int) -> None:
        if on:
            self.axis.station.wake()
            await self.axis.station.polled()

    async def _clear(self, on: int) -> None:
        if on:
            await self.axis.clear_faults()

    async def _sync(self, on: int) -> None:
        if on and not self.axis.busy:
            await self._follow_readback()

    # Polls

    async def _update(self) -> None:
        """Publish the axis's state; at the end of a motion first the last readback, then DMOV=1."""
        axis, status = self.axis, self.axis.status
        moving = status.moving
        await self._set_alarm(status)
        if axis.busy:
            await self._set(DMOV=0)
        if axis.error:
            await self._set(MSTA=self.values["MSTA"] | SILENT)
            return
        await self._set_readback(status)
        if not axis.busy and not self.values["DMOV"]:
            await self._ended()
        await self._set(
            MOVN=int(moving), MSTA=status_bits(status, busy=axis.busy, forward=self.values["CDIR"], homed=self._homed),
            DMOV=int(not axis.busy),
        )  # fmt: skip

    async def _set_readback(self, status: Status) -> None:
        dial = self._dial(status.position)
        user = self._user(dial)
        raw = float(round(status.position))
        plus, minus = int(status.limit_plus), int(status.limit_minus)
        high, low = (plus, minus) if (self._per > 0) == (self._sign > 0) else (minus, plus)
        await self._set(RHLS=plus, RLLS=minus, HLS=high, LLS=low, ATHM=int(status.at_home))
        if status.velocity:
            forward = int(status.velocity > 0)
            await self._set(CDIR=forward, TDIR=int((forward > 0) == ((self._per > 0) == (self._sign > 0))))
        if self.values["RBV"] != user or self.values["RRBV"] != raw:
            await self._set(RBV=user, DRBV=dial, RRBV=raw)
            await self._set(DIFF=self.values["VAL"] - user, RDIF=self.values["RVAL"] - raw)

    async def _ended(self) -> None:
        """Update the record after a motion; VAL becomes the position, unless a move has reached its target."""
        goal = self.axis.ended
        if goal is None or goal.target is None or goal.failure:
            await self._follow_readback()
        await self._set(MISS=int(goal is not None and bool(goal.failure)))
        if self.values["SPMG"] == MOVE:
            await self._stop_pause_move_go(PAUSE)

    async def _set_alarm(self, status: Status) -> None:
        ended = None if self.axis.busy else self.axis.ended
        alarm, message = alarm_of(status, self.axis.error, ended.failure if ended else "")
        if (alarm, message) != (self.alarm, self.values["FAULT"]):
            self.alarm = alarm
            severity = MOTOR["SEVR"].menu.index(alarm.severity)
            await self._post("", None)
            await self._set(STAT=alarm.status, SEVR=severity, UDF=int(alarm.status == "UDF"), FAULT=message)


async def _by_raw(record: MotorRecord, value: float) -> None:
    await record._move(record._user(record._dial(round(value))))


async def _by_dial(record: MotorRecord, value: float) -> None:
    await record._move(record._user(value))


async def _by_distance(record: MotorRecord, value: float) -> None:
    await record._move(record.values["VAL"] + value)


def _with_name(function: Callable[[MotorRecord, str, Any], Awaitable[None]], names: str) -> dict[str, Put]:
    def put(record: MotorRecord, value: Any, name: str) -> Awaitable[None]:
        return function(record, name, value)

    return {name: partial(put, name=name) for name in names.split()}


PUTS: dict[str, Put] = {
    "VAL": MotorRecord._move, "DVAL": _by_dial, "RVAL": _by_raw, "RLV": _by_distance,
    **_with_name(MotorRecord._jog, "JOGF JOGR"), **_with_name(MotorRecord._home, "HOMF HOMR"),
    "TWF": lambda record, on: record._tweak(1, on), "TWR": lambda record, on: record._tweak(-1, on),
    "STOP": MotorRecord._stop, "SPMG": MotorRecord._stop_pause_move_go,
    **_with_name(MotorRecord._velocity, "VELO VMAX JVEL"), **_with_name(MotorRecord._positive, "ACCL TWV"),
    **_with_name(MotorRecord._user_limit, "HLM LLM"), **_with_name(MotorRecord._dial_limit, "DHLM DLLM"),
    "OFF": MotorRecord._offset, "DIR": MotorRecord._direction, "MRES": MotorRecord._resolution,
    **_with_name(MotorRecord._keep, "SET FOFF DESC"), **_with_name(MotorRecord._shown, "EGU PREC"),
    "STUP": MotorRecord._poll, "PROC": MotorRecord._poll, "SYNC": MotorRecord._sync, "CLEAR": MotorRecord._clear,
}  # fmt: skip
"""Writes that have an effect; all other fields can only be read."""
