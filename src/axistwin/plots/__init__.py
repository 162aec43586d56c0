"""Draw pictures of a run or of a trace."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.plots.chart import Chart, Curve, Fault
    from axistwin.plots.diff_chart import of_difference
    from axistwin.plots.picture import save, show
    from axistwin.plots.trace_chart import messages, of_trace
else:
    __getattr__ = lazy(
        __name__,
        chart="Chart Curve Fault",
        diff_chart="of_difference",
        picture="save show",
        trace_chart="messages of_trace",
    )

__all__ = ["Chart", "Curve", "Fault", "messages", "of_difference", "of_trace", "save", "show"]
