"""Perform the buttons of a state (`condition.py`), and make a controller ready."""

from axistwin.bench import Say, Wait
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
            for act in button.acts:
                if isinstance(act, Say):
                    session.say(act.controller, act.data)
                else:
                    session.do(act.controller, act.target, act.value)
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
    acts = reasons_of(session.bench[name], Remedies()).initialisation()
    needed = False
    while (act := session.inspect(lambda: next(acts, None))) is not None:
        needed = True
        if isinstance(act, Say):
            session.say(name, act.data)
        elif isinstance(act, Wait):
            await session.advance_to(session.seconds + to_seconds(act.ns))
    return needed
