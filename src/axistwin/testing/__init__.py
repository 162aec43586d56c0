"""Tests of host software against virtual controllers: `serve()` and the pytest plug-in."""

from typing import TYPE_CHECKING

from axistwin.core.lazy import lazy

if TYPE_CHECKING:
    from axistwin.testing.properties import device_checks
    from axistwin.testing.twin import Twin, serve
else:
    __getattr__ = lazy(__name__, properties="device_checks", twin="Twin serve")

__all__ = ["Twin", "device_checks", "serve"]
