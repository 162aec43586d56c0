"""The stored programs of a controller: listing, running line, breakpoints, loading, start and stop."""

import re
from collections.abc import Mapping
from functools import partial
from pathlib import PurePath

from nicegui import ui
from nicegui.elements.upload_files import FileUpload
from nicegui.events import GenericEventArguments, UploadEventArguments

from axistwin.bench import Controller, endpoints
from axistwin.controllers.product import Listing, Order
from axistwin.core.storage import encoding_of, split_at_end
from axistwin.ui.panel.context import Context, Refresh, seldom
from axistwin.ui.panel.drawings.listing import Lines
from axistwin.ui.panel.turns import breathe

MOST_BYTES = 1 << 18  # Largest program: ten times a real one, but less than a browser's message can contain.
TOO_LONG = f"the text is too long: expected at most {MOST_BYTES:,} characters"
EMPTY = Listing("", ())
SELDOM = 4  # Number of frames between two updates; an update is slow, because it advances the motor to find its line.


def program(context: Context, name: str) -> Refresh:
    return seldom(context, SELDOM, _View(context, name).refresh)


class _View:
    def __init__(self, context: Context, name: str) -> None:
        self.context, self.name = context, name
        self._orders: dict[str, ui.row] = {}
        with ui.element("section").classes("program"):
            with ui.element("div").classes("program-head"):
                keep = context.person.settings.__setitem__
                self._choice = ui.select([], label="program").props(_DENSE)
                self._choice.on_value_change(lambda event: keep(f"{name} program", event.value))
                self._choice.mark(f"{name} which")
                self._title = ui.label().classes("quiet").mark(f"{name} title")
                self._state = ui.label().classes("running-line").mark(f"{name} runs")
                follow = f"{name} follow"
                self._follow = ui.checkbox("follow", value=bool(context.person.settings.get(follow, True))).props(
                    "dense"
                )
                self._follow.on_value_change(lambda event: keep(follow, event.value))
                self._follow.mark(f"{name} follow")
            self._lines = Lines(self._toggle).mark(f"{name} listing").props(f'data-test="listing {name}"')
            breathe()
            self._none = ui.label("Nothing is stored.").classes("quiet")
            self._buttons()

    @property
    def _controller(self) -> Controller:
        return self.context.bench[self.name]

    def refresh(self) -> None:
        programs = self._controller.programs
        self._offer(programs)
        which = self._which(programs)
        listing = programs.get(which, EMPTY)
        self._title.text = listing.title
        self._state.text = "" if listing.running is None else f"line {listing.running + 1} runs"
        self._none.visible = not listing.lines
        self._lines.visible = bool(listing.lines)
        self._lines.show(listing, follow=bool(self._follow.value))
        self._show_breaks(which)
        for each, row in self._orders.items():
            row.visible = each == which

    # Selection of the program that the page shows

    def _offer(self, programs: Mapping[str, Listing]) -> None:
        names = list(programs)
        if names != self._choice.options:
            self._choice.set_options(names)
        self._choice.visible = len(names) > 1

    def _which(self, programs: Mapping[str, Listing]) -> str:
        wanted = self.context.person.settings.get(f"{self.name} program")
        if self._follow.value or wanted not in programs:
            running = (each for each, listing in programs.items() if listing.running is not None)
            wanted = next(running, wanted if wanted in programs else next(iter(programs), ""))
        if programs:
            self._choice.value = wanted
        return str(wanted)

    # Breakpoints

    def _toggle(self, index: int) -> None:
        session, sentence = self.context.session, f"{self.name} runs {self._place(index)}"
        there = next((each for each in session.breaks if each.sentence == sentence), None)
        if there is not None:
            self.context.touch(partial(session.remove_break, there))
        else:
            self.context.touch(lambda: session.add_break(sentence))

    def _place(self, index: int) -> str:
        """Format a line number for a breakpoint: `12`, or `3:12` for line 12 of sequence 3."""
        return f"{self._number(str(self._choice.value))}{index + 1}"

    def _number(self, which: str) -> str:
        return f"{which.split()[-1]}:" if len(self._controller.product.programs) > 1 and which else ""

    def _show_breaks(self, which: str) -> None:
        sentence = re.compile(rf"{re.escape(self.name)} runs {self._number(which)}(?P<line>\d+)", re.ASCII)
        found = [(int(match["line"]) - 1, each.on) for each in self.context.session.breaks
                 if (match := sentence.fullmatch(each.sentence))]  # fmt: skip
        self._lines.set_breaks({line for line, on in found if on}, {line for line, on in found if not on})

    # Buttons

    def _buttons(self) -> None:
        controller = self._controller
        reached = self.name in endpoints.names(self.context.bench)
        with ui.element("div").classes("program-foot"):
            for which in controller.product.programs if reached else ():
                with ui.row().classes("orders") as self._orders[which]:
                    for order in controller.product.orders(which):
                        self._order(order)
                breathe()
            load = _Loading(self.context, self.name)
            breathe()
            ui.button("Load\u2026", icon="upload_file", on_click=load.open).props(_FLAT).mark(f"{self.name} load")
            cycle = ui.button("Off and on", icon="power_settings_new", on_click=self._power_cycle).props(_FLAT)
            cycle.mark(f"{self.name} power-cycle").tooltip(
                "switch the power off and on; only non-volatile memory is kept"
            )

    def _order(self, order: Order) -> None:
        say = partial(self.context.session.say, self.name, order.says)
        button = ui.button(order.label, on_click=lambda: self.context.touch(say)).props(_FLAT)
        button.mark(f"{self.name} {order.label}").tooltip(order.doc)

    def _power_cycle(self) -> None:
        def cycle() -> None:
            for level in ("off", "on"):
                self.context.session.do(self.name, "power", level)

        self.context.touch(cycle)


class _Loading:
    def __init__(self, context: Context, name: str) -> None:
        self.context, self.name = context, name
        suffix = context.bench[name].product.suffix
        with ui.dialog() as self._dialog, ui.card().classes("loading"):
            ui.label(f"A program for {name}").classes("title")
            self._upload = ui.upload(
                label=f"a file ({suffix})", max_file_size=MOST_BYTES, auto_upload=True,
                on_upload=self._come, on_rejected=self._refuse,
            )  # fmt: skip
            self._upload.props(f'accept="{suffix}" flat bordered').classes("upload").mark(f"{name} file")
            breathe()
            self._file = ui.input("called", value=f"program{suffix}").props("dense").mark(f"{name} called")
            self._text = ui.textarea("or its text").props("outlined").classes("pasted").mark(f"{name} text")
            breathe()
            with ui.row():
                shown = f"() => emit(document.getElementById('{self._text.html_id}').value.length)"
                ui.button("Load").on("click", self._load, js_handler=shown).mark(f"{name} loading")
                ui.button("Cancel", on_click=self._dialog.close).props("flat")

    def open(self) -> None:
        self._upload.reset()
        self._text.value = ""
        self._dialog.open()

    def _refuse(self) -> None:
        self._text.value = ""
        ui.notify(TOO_LONG, type="negative")

    async def _come(self, event: UploadEventArguments) -> None:
        self._text.value = await _read(event.file)
        self._file.value = PurePath(event.file.name).name

    def _load(self, event: GenericEventArguments) -> None:
        text, file = str(self._text.value or ""), str(self._file.value or "")
        if max(len(text), event.args if type(event.args) is int else 0) > MOST_BYTES:
            self._refuse()
            return

        def load() -> None:
            self.context.session.load(self.name, file, text)
            self._dialog.close()

        self.context.touch(load)


async def _read(file: FileUpload) -> str:
    data, _ = split_at_end(await file.read())
    return data.decode(encoding_of(data), "replace")


_DENSE = "dense options-dense outlined"
_FLAT = "flat dense no-caps"
