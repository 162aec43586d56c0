"""Several panels in one process, one after the other."""

import asyncio

import httpx

from axistwin import Bench, Session
from axistwin.panel import Address, Panel

from .showing import stage


async def title_of_a_panel(title):
    session = Session(Bench)
    panel = Panel(title, session, Address.read("0", None))
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
