"""A program listing with line numbers; after the listing has been sent, only marks of lines are sent."""

from collections.abc import Callable, Collection
from typing import Any

from nicegui.element import Element
from nicegui.events import GenericEventArguments

from axistwin.controllers.product import Listing


class Lines(Element, component="listing.js"):
    """Shows the listing of a program; `toggle(index)` is called for a click on a line number."""

    def __init__(self, toggle: Callable[[int], None]) -> None:
        super().__init__()
        self.lines: tuple[str, ...] | None = None  # Lines that the page shows; None before the first `show`.
        self.running: int | None = None
        self.on_breaks: tuple[int, ...] = ()
        self.off_breaks: tuple[int, ...] = ()
        self._toggle, self._follow = toggle, True
        self._props["lines"], self._props["silent"], self._props["label"] = [], [], ""
        self.on("toggle", self._toggled, ["line"])
        self.on("ready", self._begin_again, [])

    def show(self, listing: Listing, *, follow: bool) -> None:
        """Show a program, and mark its running line; `follow`: scroll to this line."""
        if listing.lines is not self.lines and listing.lines != self.lines:
            self._props["lines"], self._props["silent"] = list(listing.lines), sorted(listing.silent)
            self._props["label"] = listing.title
            self.update()
        self.lines = listing.lines
        if (listing.running, follow) != (self.running, self._follow):
            self.running, self._follow = listing.running, follow
            self.run_method("run", self.running, follow)

    def set_breaks(self, on: Collection[int], off: Collection[int]) -> None:
        """Mark the lines that have an enabled breakpoint (`on`) or a disabled breakpoint (`off`)."""
        wanted = tuple(sorted(on)), tuple(sorted(off))
        if wanted != (self.on_breaks, self.off_breaks):
            self.on_breaks, self.off_breaks = wanted
            self.run_method("breaks", *wanted)

    def _toggled(self, event: GenericEventArguments) -> None:
        line = event.args.get("line") if isinstance(event.args, dict) else None
        if type(line) is int and self.lines is not None and 0 <= line < len(self.lines):
            self._toggle(line)

    def _begin_again(self) -> None:
        self.run_method("run", self.running, self._follow)
        self.run_method("breaks", self.on_breaks, self.off_breaks)

    def _displayed_contents(self, *, only_visible: bool) -> list[Any]:
        return [*super()._displayed_contents(only_visible=only_visible), *(self.lines or ())]
