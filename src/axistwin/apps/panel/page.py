"""The page: which views there are and where, and the frames in which they are brought up to date."""

import asyncio
from importlib import resources

from nicegui import Client, background_tasks, ui

from axistwin.apps.panel.look import Look, Refresh
from axistwin.apps.panel.views.clock import clock
from axistwin.apps.panel.views.scope import scope

FRAME_S = 0.05
"""At most so often is a page brought up to date."""
PATIENCE_S = 30.0
"""A browser that has drawn nothing for so long is asked again."""
DRAWN = "await new Promise(requestAnimationFrame)"


def page(look: Look) -> None:
    """Everything there is, for one person; called for each visit."""
    ui.add_css((resources.files(__package__) / "panel.css").read_text())
    views = [*_header(look), *_body(look)]
    background_tasks.create(_keep_showing(ui.context.client, look, views), name="panel")


def _header(look: Look) -> list[Refresh]:
    with ui.header().classes("items-center"):
        ui.label("VIRTUAL").classes("virtual").tooltip("There is no hardware here")
        return [clock(look)]


def _body(look: Look) -> list[Refresh]:
    found: list[Refresh] = []
    with ui.element("main").classes("bench"):
        for name in look.bench.controllers:
            with ui.card().classes("machine"):
                ui.label(name)
    found.append(scope(look))
    return found


async def _keep_showing(client: Client, look: Look, views: list[Refresh]) -> None:
    """Frame by frame.  A browser that is slow gets fewer, and always the latest; a hidden one none."""
    loop = asyncio.get_running_loop()
    await client.connected(timeout=PATIENCE_S)
    look.person.pages += 1
    try:
        while not client.is_deleted:
            began_s = loop.time()
            with client:
                for refresh in views:
                    refresh()
                await _drawn(client)
            await asyncio.sleep(max(0.0, began_s + FRAME_S - loop.time()))
    finally:
        look.person.pages -= 1


async def _drawn(client: Client) -> None:
    """Until the browser has shown what it was sent."""
    try:
        await client.run_javascript(DRAWN, timeout=PATIENCE_S)
    except TimeoutError:
        return
