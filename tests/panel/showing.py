"""Show views on simulated pages of NiceGUI, without web server and browser; the test draws each frame.

NiceGUI is started once in a process, and so is the event loop.  Each test has a page, a bench and a session of its own.
"""

import asyncio
from contextlib import AsyncExitStack
from functools import partial, wraps
from inspect import isawaitable, signature

from nicegui import Client
from nicegui.testing.user import User
from nicegui.testing.user_simulation import user_simulation

from axistwin import Session
from axistwin.ui.conversation.conversation import Conversation
from axistwin.ui.panel.context import Common, Context
from axistwin.ui.panel.people import People

from ..benches import bench_of


class Visit:
    """A simulated page with one view, and the `Context` of its user."""

    def __init__(self, user, context, made):
        self.user, self.context, self._made = user, context, made

    @property
    def bench(self):
        return self.context.bench

    @property
    def _refresh(self):
        return self._made[-1]

    def frame(self):
        """Update the view, and build parts that have become visible."""
        with self.user.client:
            self._refresh()
            while self.context.unbuilt:
                self.context.unbuilt.pop()()
                self._refresh()

    async def reload(self):
        await self.user.open("/")
        self.frame()

    def run(self, seconds):
        self.bench.run(seconds)
        self.frame()

    def found(self, mark):
        """Return the element with this mark; there must be exactly one."""
        (element,) = self.user.find(marker=mark).elements
        return element

    def press(self, mark):
        self.user.find(marker=mark).click()
        self.frame()

    def trigger(self, mark, event, arguments=None):
        self.user.find(marker=mark).trigger(event, arguments)
        self.frame()

    def choose(self, mark, value):
        with self.user.client:
            self.found(mark).value = value

    def told(self, name, last=1000):
        """Return the last entries of a terminal's list as text, each with its notes below it."""
        entries = self.context.common(Conversation).log.since(name, 0)[1][-last:]
        return "\n".join(line for each in entries for line in (f"{each.who} {each.text}", *each.notes))

    def lit(self, mark):
        """Return True if a lamp is lit; its CSS class and its label for screen readers must be equal."""
        lamp = self.found(mark)
        told = lamp.props["aria-label"].endswith(": on")
        assert told is ("lit" in lamp.classes)
        return told

    def pressed(self, *marks):
        """Return the names of the keys that are shown as pressed."""
        return [mark for mark in marks if self.found(mark).props["aria-pressed"] == "true"]

    async def until(self, came_true):
        """Draw frames until a condition is true; the event loop runs between two frames."""
        for _ in range(1000):
            if came_true():
                return
            await asyncio.sleep(0)
            self.frame()
        raise AssertionError("it never came true")

    @property
    def messages(self):
        return self.user.notify.messages


class Stage:
    """The simulated NiceGUI server.  The first `play` starts it, and `close` ends it."""

    def __init__(self):
        self._runner = self._ending = self._http = None
        self._root = None

    def play(self, root, played):
        """Return the result of `await played(user)`; the user visits a web site whose pages `root()` builds.

        Afterwards its pages are deleted and its tasks are cancelled.
        """
        if self._runner is None:  # starting NiceGUI removes the pages of earlier panels
            self._runner, self._ending = asyncio.Runner(), AsyncExitStack()
            self._runner.run(self._begin())
        assert not Client.page_routes, (
            "a panel has been opened since NiceGUI was started here: call `stage.close` first"
        )
        self._root = root
        return self._runner.run(self._played(played))

    def close(self):
        if self._runner is not None:
            self._runner.run(self._ending.aclose())
            self._runner.close()
            self._runner = None

    async def _begin(self):
        user = await self._ending.enter_async_context(user_simulation(lambda: self._root()))
        self._http = user.http_client

    async def _played(self, played):
        before, kept = asyncio.all_tasks(), set(Client.instances)
        try:
            return await played(User(self._http))
        finally:
            for name in set(Client.instances) - kept:
                Client.instances[name].delete()
            tasks = asyncio.all_tasks() - before
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)


stage = Stage()
"""The server that all tests in this process share."""


def shown(view, *names, build=None, after=0, **options):
    """Make a test of a driver's page: it gets a `Visit`, and may be asynchronous.

    The page shows `view(context)` or `view(context, NAME)`, where NAME is the first of `names`, or the test's argument
    `model`.  Its bench is that of the test's argument `context`, or `build()`, or has a controller of each name with
    these options; it has run for `after` seconds.
    """

    def decorate(test):
        arguments = signature(test)

        @wraps(test)
        def run(**given):
            there = names or (given.get("model"),)
            of_controller = len(signature(view).parameters) > 1
            show_to(
                given.get("context") or driver_of(build or bench_of(*there, **options)),
                (lambda context: view(context, there[0])) if of_controller else view,
                partial(begin, **given),
            )

        def begin(visit, **given):
            if after:
                visit.run(after)
            return test(visit, **given)

        run.__signature__ = arguments.replace(parameters=list(arguments.parameters.values())[1:])
        return run

    return decorate


def driver_of(build):
    people = People()
    return Context(Common(Session(build, None)), people, people["somebody"])


def show(build, view, play):
    """Call `play(visit)`, which may be asynchronous, for a driver's page with the view `view(context)`.

    Returns what `play` returns.
    """
    return show_to(driver_of(build), view, play)


def show_to(context, view, play):
    """Call `play(visit)` for the page of `context`."""
    made = []

    async def played(user):
        await user.open("/")
        visit = Visit(user, context, made)
        visit.frame()
        found = play(visit)
        return await found if isawaitable(found) else found

    return stage.play(lambda: made.append(view(context)), played)
