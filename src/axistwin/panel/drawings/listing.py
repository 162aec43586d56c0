"""A listing with line numbers; the browser builds the lines once, and then changes only marks."""

from collections.abc import Callable, Collection
from typing import Any

from nicegui.element import Element
from nicegui.events import GenericEventArguments

from axistwin.controllers.product import Listing


class Lines(Element, component="listing.js"):
    """A stored program.  `toggle(index)` is called after a click or Enter on a line's number."""

    def __init__(self, toggle: Callable[[int], None]) -> None:
        super().__init__()
        self.lines: tuple[str, ...] | None = None
        """Lines on the page; None: not shown yet."""
        self.running: int | None = None
        self.on_breaks: tuple[int, ...] = ()
        self.off_breaks: tuple[int, ...] = ()
        self._toggle, self._follow = toggle, True
        self._props["lines"], self._props["silent"], self._props["label"] = [], [], ""
        self.on("toggle", self._toggled, ["line"])
        self.on("ready", self._begin_again, [])

    def show(self, listing: Listing, *, follow: bool) -> None:
        """Show these lines, and mark the running line; `follow`: scroll to that line."""
        if listing.lines is not self.lines and listing.lines != self.lines:
            self._props["lines"], self._props["silent"] = list(listing.lines), sorted(listing.silent)
            self._props["label"] = listing.title
            self.update()
        self.lines = listing.lines
        if (listing.running, follow) != (self.running, self._follow):
            self.running, self._follow = listing.running, follow
            self.run_method("run", self.running, follow)

    def set_breaks(self, on: Collection[int], off: Collection[int]) -> None:
        """Set the indices of lines with a breakpoint, and of lines with a disabled breakpoint."""
        wanted = tuple(sorted(on)), tuple(sorted(off))
        if wanted != (self.on_breaks, self.off_breaks):
            self.on_breaks, self.off_breaks = wanted
            self.run_method("breaks", *wanted)

    def _toggled(self, event: GenericEventArguments) -> None:
        line = event.args.get("line") if isinstance(event.args, dict) else None
        if type(line) is int and self.lines is not None and 0 <= line < len(self.lines):
            self._toggle(line)

    def _begin_again(self) -> None:
        """Send the marks after the browser has built the lines."""
        self.run_method("run", self.running, self._follow)
        self.run_method("breaks", self.on_breaks, self.off_breaks)

    def _displayed_contents(self, *, only_visible: bool) -> list[Any]:
        return [*super()._displayed_contents(only_visible=only_visible), *(self.lines or ())]
