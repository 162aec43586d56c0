"""EPICS: axes as motor records, pins and registers as records, by Channel Access and PV Access.

`MotorRecord` and `PointRecord` hold the fields and process writes; `channel_access` (caproto) and `pv_access` (p4p)
serve them.
"""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.integrations.epics.ioc import Ioc
    from axistwin.integrations.epics.motor_record import MotorRecord
else:
    __getattr__ = lazy(
        __name__,
        ioc="Ioc",
        motor_record="MotorRecord",
    )

__all__ = ["Ioc", "MotorRecord"]
