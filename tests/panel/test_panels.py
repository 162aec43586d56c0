"""Several panels in one process, one after the other."""

import asyncio

import httpx
import pytest

from axistwin import Bench, Session
from axistwin.ui.panel import web
from axistwin.ui.panel.address import Address
from axistwin.ui.panel.web import Panel

from .showing import stage


async def title_of_a_panel(title):
    panel = Panel(title, Session(Bench), Address.read("0", None))
    address = await panel.open()
    try:
        async with httpx.AsyncClient() as browser:
            answer = await browser.get(address)
    finally:
        await panel.close()
    return answer.text.partition("<title>")[2].partition("</title>")[0]


def test_two_panels_in_a_row_each_with_its_own_bench():
    async def both():
        return [await title_of_a_panel(title) for title in ("one", "two")]

    stage.close()  # a process can have only one NiceGUI server at a time
    assert asyncio.run(both()) == ["VIRTUAL: one", "VIRTUAL: two"]


@pytest.mark.parametrize(("host", "compressed"), [("0", False), ("[::1]:0", False), ("0.0.0.0:0", True)])
def test_pages_are_compressed_only_for_other_machines(host, compressed, monkeypatch):
    given = {}
    monkeypatch.setattr(web.ui, "run_with", lambda application, **options: given.update(options))
    web._application(Panel("one", Session(Bench), Address.read(host, None)), "one")
    assert (given["gzip_middleware_factory"] is not None) is compressed
