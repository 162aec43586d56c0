"""Chapter Communication lockout commands."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from axistwin.controllers.digiplan.interface import Interface


def lock(interface: "Interface") -> None:
    """Command [: from now on only status requests and `]` are obeyed; communication is not checked.

    In an IF2 parameters, sequence, baud rate and data format now survive power-off.
    Chapters Communication lockout commands, Storing a sequence in the IF2.
    """
    interface.set_locked(True)


def unlock(interface: "Interface") -> None:
    """Command ]: all commands are obeyed again, if it comes in the same format as [.

    Baud rate, number of bits and parity must be those of the lock command.  Chapter Communication lockout commands.
    """
    same = interface.lock in (None, interface.message_format)
    if interface.locked and (same or interface.options.unlock == "any format"):
        interface.set_locked(False)
