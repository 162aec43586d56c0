"""Parameters and targets that commands share."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.cli.common.target import bench_for
    from axistwin.cli.common.working import RunProgress
else:
    __getattr__ = lazy(
        __name__,
        target="bench_for",
        working="RunProgress",
    )

__all__ = ["RunProgress", "bench_for"]
