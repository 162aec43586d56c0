"""Perform the buttons of a state (`condition.py`), and make a controller ready."""

from collections.abc import Iterator

from axistwin.bench import Do, Say, Wait
from axistwin.bench.acts import Act
from axistwin.core.units import to_seconds
from axistwin.scenes.reasons.families import reasons_of
from axistwin.scenes.reasons.remedies import Remedies
from axistwin.scenes.sessions.condition import Button
from axistwin.scenes.sessions.session import Session


async def perform(session: Session, button: Button, name: str = "") -> None:
    """Do what a button says; `name`: the controller of the state.  Raises AxistwinError.

    `lessons` is left to the page.
    """
    match button.does:
        case "do":
            await follow(session, name, iter(button.acts))
        case "go":
            await session.advance_to(button.at_s)
        case "initialise":
            await initialise(session, name)
        case "live":
            session.forget_rest()
        case "restart":
            session.restart()
        case "run":
            session.run()
        case "stop":
            session.give_up()


async def initialise(session: Session, name: str) -> bool:
    """Make a controller ready, at full speed.  Returns False if it is ready already.  Raises AxistwinError."""
    return await follow(session, name, reasons_of(session.bench[name], Remedies()).initialisation())


async def follow(session: Session, name: str, acts: Iterator[Act]) -> bool:
    """Perform acts one after the other, at full speed.  Returns False if there are none.  Raises AxistwinError."""
    some = False
    while (act := session.inspect(lambda: next(acts, None))) is not None:
        some = True
        if wait_ns := carry_out(session, name, act):
            await session.advance_to(session.seconds + to_seconds(wait_ns))
    return some


def carry_out(session: Session, name: str, act: Act) -> int:
    """Say or do what an act says, now.  Returns the time in ns until the next act: that of a `Wait`, else 0."""
    if isinstance(act, Say):
        session.say(act.controller or name, act.data)
    elif isinstance(act, Do):
        session.do(act.controller or name, act.target, act.value)
    return act.ns if isinstance(act, Wait) else 0
