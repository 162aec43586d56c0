"""Program flow (8 of the base language), and what chapters 4 and 7 change: where a program begins, goes on and ends.

The interpreter carries these statements out itself where they stand in the program.  Here is what a host makes of them,
and the calls of C1 and C2.
"""

from typing import TYPE_CHECKING

from axistwin.controllers.smartmotor.kernel import interpreter
from axistwin.controllers.smartmotor.kernel.state import (
    BE,
    BH,
    BLOCKED,
    C2_CALLED,
    CALL_GOSUB,
    CALL_INPUT,
    DEPTH,
    NOTHING_YET,
    PAUSED,
    PC,
    PID_RATE,
    PROGRAM,
    RETURNS,
    RUN_GIVEN,
    RUNNING,
    SAMPLE,
    STATEMENT,
    STOPPED,
    TWAITING,
    WAIT_UNTIL,
)

if TYPE_CHECKING:
    from axistwin.controllers.smartmotor.motor import Motor

NOWHERE = -1
"""The return address of what is called while no program runs."""


def begin(motor: "Motor", by_run: bool = False) -> None:
    """Start the stored program from the top; at power-up, or by RUN.  Nothing happens if there is none."""
    if motor.program.statements:
        interpreter.forget(motor.i)
        motor.i[RUN_GIVEN] = int(by_run)
        _go(motor, 0)


def run(motor: "Motor") -> None:
    """RUN: start the stored program from the top; variables and motion stay as they are, the return stack is cleared.

    Ignored while there is a motor protection fault, Be or Bh (4.1), and without a program.
    """
    if not (motor.i[BE] or motor.i[BH]):
        begin(motor, by_run=True)


def run_wait(motor: "Motor") -> None:
    """RUN?: a program that was started by power-up ends here; RUN starts it from the top, and then passes over this."""
    if not motor.i[RUN_GIVEN]:
        end(motor)


def end(motor: "Motor") -> None:
    """END: the program ends; motion goes on.  The return stack is cleared, and C2 may be called again (7, F=64)."""
    interpreter.forget(motor.i)
    motor.i[PROGRAM] = STOPPED
    _wait_no_more(motor)


def goto(motor: "Motor", label: int) -> None:
    """GOTOn: the program goes on at label n, 0…999, also one that stands still.  Unknown label: Bs."""
    target = motor.program.labels.get(label)
    if target is None:
        motor.syntax_error()
    else:
        _go(motor, target)


def gosub(motor: "Motor", label: int) -> None:
    """GOSUBn: carry out the subroutine at label n, 0…999, and then go on; without a running program, stop there.

    A statement that takes time (WAIT, TWAIT, PRINT) is finished first.  Unknown label, or ten returns waiting: Bs.
    """
    target = motor.program.labels.get(label)
    if target is None:
        motor.syntax_error()
    else:
        _call(motor, target, CALL_GOSUB)


def call(motor: "Motor", label: int, kind: int) -> bool:
    """Call C1 because of a fault (F=32), or C2 because of pin G (F=64).  Whether it has been called.

    C2 cuts a WAIT short, and is not called again before RETURNI, STACK or END.  A program without the label is left
    alone; a full return stack sets Bs.
    """
    target = motor.program.labels.get(label)
    if target is None or (kind == CALL_INPUT and within(motor, kind)) or not _call(motor, target, kind):
        return False
    if kind == CALL_INPUT:
        motor.i[C2_CALLED] = 1
        motor.i[WAIT_UNTIL] = 0
    return True


def within(motor: "Motor", kind: int) -> bool:
    """Whether a call of this kind has not been completed: C2 is by RETURNI, STACK or END alone."""
    if kind == CALL_INPUT:
        return bool(motor.i[C2_CALLED])
    return any(motor.i[RETURNS + number] & 3 == kind for number in range(motor.i[DEPTH]))


def return_(motor: "Motor") -> None:
    """RETURN: go back behind the GOSUB.  Where there was none, Bs is set and the program ends."""
    interpreter.go_back(motor.i)


def return_fault(motor: "Motor") -> None:
    """RETURNF: go back to where C1 was called because of a fault (7, F=32)."""
    interpreter.go_back(motor.i)


def return_interrupt(motor: "Motor") -> None:
    """RETURNI: go back to where C2 was called because of pin G, which may then call it again (7, F=64)."""
    motor.i[C2_CALLED] = 0
    interpreter.go_back(motor.i)


def stack(motor: "Motor") -> None:
    """STACK: forget all return addresses; C2 may be called again (7, F=64)."""
    interpreter.forget(motor.i)


def wait(motor: "Motor", value: int) -> None:
    """WAIT=exp: the next statement is carried out `value` samples after this one; only a call of C2 cuts it short."""
    motor.i[WAIT_UNTIL] = motor.i[SAMPLE] + 1 + value * motor.i[PID_RATE]


def twait(motor: "Motor") -> None:
    """TWAIT: no statement while Bt is 1."""
    motor.i[TWAITING] = 1


def pause(motor: "Motor") -> None:
    """!: the program pauses until a serial character arrives (channel.py)."""
    motor.i[PROGRAM] = BLOCKED
    motor.i[PAUSED] = 1


def reset(motor: "Motor") -> None:
    """Z: total reset, all as at power-up."""
    motor.reset()


def part_of_block(motor: "Motor") -> None:
    """IF, WHILE, SWITCH and what belongs to them; labels: the compiler makes jumps of them."""
    motor.syntax_error()


def _go(motor: "Motor", pc: int) -> None:
    motor.i[PC] = pc
    _start(motor)


def _start(motor: "Motor") -> None:
    """The program runs from where PC is; the statement there is the next one."""
    motor.i[PROGRAM] = RUNNING
    motor.i[STATEMENT], motor.statement_before = motor.program.number_at(motor.i[PC]), NOTHING_YET
    _wait_no_more(motor)


def _wait_no_more(motor: "Motor") -> None:
    motor.i[WAIT_UNTIL] = motor.i[TWAITING] = motor.i[PAUSED] = 0


def _call(motor: "Motor", target: int, kind: int) -> bool:
    standing = motor.i[PROGRAM] == STOPPED
    called = interpreter.call(motor.i, target, NOWHERE if standing else motor.i[PC], kind)
    if called and standing:
        _start(motor)
    return called
