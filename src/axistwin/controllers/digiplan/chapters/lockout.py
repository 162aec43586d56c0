"""Chapter Communication lockout commands."""

from axistwin.controllers.digiplan.state import State


def lock(state: State) -> None:
    """Command `[`: lock the communication, so that the interface obeys only status requests and the command `]`.

    While locked, communication errors are not flagged.  From then on an IF2 keeps parameters, sequence, baud rate and
    data format without power.  Chapters Communication lockout commands, Storing a sequence in the IF2.
    """
    state.set_locked(True)


def unlock(state: State) -> None:
    """Command `]`: obey all commands again; valid only in the baud rate, bits and parity of the lock.

    Chapter Communication lockout commands.
    """
    same = state.lock in (None, state.message_format)
    if state.locked and (same or state.options.unlock == "any format"):
        state.set_locked(False)
