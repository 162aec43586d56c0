"""A view on a page as NiceGUI simulates one: no web server, no browser, and as many frames as one asks for."""

import asyncio
from inspect import isawaitable

from nicegui.testing.user_simulation import user_simulation

from axistwin import Bench
from axistwin.panel.look import Common, Look
from axistwin.panel.people import People
from axistwin.sessions.session import Session


def bench_of(*models, **options):
    """What makes a bench with one controller of each of these models, each called like its model."""

    def build():
        bench = Bench()
        for model in models:
            bench.add(model, model, **options)
        return bench

    return build


class Visit:
    """Somebody at a page; `look` is the person's."""

    def __init__(self, user, look, refresh):
        self.user, self.look, self._refresh = user, look, refresh

    @property
    def bench(self):
        return self.look.bench

    def frame(self):
        """The view is brought up to date."""
        with self.user.client:
            self._refresh()

    def run(self, seconds):
        """Virtual time passes, and then there is a frame."""
        self.bench.run(seconds)
        self.frame()

    def found(self, mark):
        """The one element that is called so."""
        (element,) = self.user.find(marker=mark).elements
        return element

    def press(self, mark):
        """A click, and a frame."""
        self.user.find(marker=mark).click()
        self.frame()

    def trigger(self, mark, event, arguments=None):
        """Any event, and a frame."""
        self.user.find(marker=mark).trigger(event, arguments)
        self.frame()

    def choose(self, mark, value):
        """Another value for a field."""
        with self.user.client:
            self.found(mark).value = value

    def lit(self, mark):
        """Whether a lamp is lit, as those are told who cannot see it, and those who can."""
        lamp = self.found(mark)
        told = lamp.props["aria-label"].endswith(": on")
        assert told is ("lit" in lamp.classes)
        return told

    def pressed(self, *marks):
        """Those of the keys that are pressed."""
        return [mark for mark in marks if self.found(mark).props["aria-pressed"] == "true"]

    async def until(self, came_true):
        """Frames, until this is true; the loop has its turn in between."""
        for _ in range(1000):
            if came_true():
                return
            await asyncio.sleep(0)
            self.frame()
        raise AssertionError("it never came true")

    @property
    def messages(self):
        """What has been told."""
        return self.user.notify.messages


def show(build, view, play):
    """`play(visit)` at a page with this view, `view(look)`; the first visitor, who drives.  It may be asynchronous."""

    async def simulated():
        session, people = Session(build, None), People()
        look, made = Look(Common(session), people, people["somebody"]), []
        async with user_simulation(lambda: made.append(view(look))) as user:
            await user.open("/")
            visit = Visit(user, look, made[-1])
            visit.frame()
            played = play(visit)
            if isawaitable(played):
                await played

    asyncio.run(simulated())
