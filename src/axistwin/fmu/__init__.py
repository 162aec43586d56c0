"""FMUs: scenes as components of Simulink, Dymola, OpenModelica and other simulation tools, by FMI 3.0."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.fmu.archive import export
    from axistwin.fmu.machine import Machine
else:
    __getattr__ = lazy(
        __name__,
        archive="export",
        machine="Machine",
    )

__all__ = ["Machine", "export"]
