"""Program flow: start, continuation and end of a program (section 8 of the base language, changed by chapters 4 and 7).

In a program, the interpreter executes the statements of program flow.  This module executes them as commands of a host,
and calls C1 and C2.
"""

from axistwin.controllers.smartmotor.kernel import interpreter
from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.processor import Processor

NOWHERE = -1  # The return address of a subroutine that is called while no program runs.


def begin(motor: Processor, by_run: bool = False) -> None:
    """Start the stored program from the top, at power-up or by RUN; nothing without a program."""
    if motor.program.statements:
        interpreter.forget(motor.i)
        motor.i[s.RUN_GIVEN] = int(by_run)
        _go(motor, 0)


def run(motor: Processor) -> None:
    """RUN: start the stored program from the top; ignored without a program, and with Be or Bh (4.1).

    The return stack is emptied; variables and motion do not change.
    """
    if not (motor.i[s.BE] or motor.i[s.BH]):
        begin(motor, by_run=True)


def run_wait(motor: Processor) -> None:
    """RUN?: end a program that was started at power-up; one that RUN has started continues."""
    if not motor.i[s.RUN_GIVEN]:
        end(motor)


def end(motor: Processor) -> None:
    """END: end the program and clear the stack; the motion continues, and pin G may call C2 again (7)."""
    interpreter.forget(motor.i)
    motor.i[s.PROGRAM] = s.STOPPED
    _wait_no_more(motor)


NO_LABEL = "the stored program has no label C{}: load one that has"


def goto(motor: Processor, label: int) -> None:
    """GOTOn: continue, or start, at label n, 0…999.  An unknown label sets Bs."""
    target = motor.program.labels.get(label)
    if target is None:
        motor.syntax_error(NO_LABEL.format(label))
    else:
        _go(motor, target)


def gosub(motor: Processor, label: int) -> None:
    """GOSUBn: execute the subroutine at label n, 0…999; without a running program, stop after it.

    A statement that takes time (WAIT, TWAIT, PRINT) is finished first.  An unknown label, or ten return addresses on
    the stack, sets Bs.
    """
    target = motor.program.labels.get(label)
    if target is None:
        motor.syntax_error(NO_LABEL.format(label))
    else:
        _call(motor, target, s.CALL_GOSUB)


def call(motor: Processor, label: int, kind: int) -> bool:
    """Call the subroutine C1 or C2.  Returns True if the call was possible.

    C1 is called after a fault, C2 after a falling edge of pin G.  C2 ends a WAIT early, and cannot be called again
    before RETURNI, STACK or END.  Nothing changes if the program has no such label; a full return stack sets Bs.
    """
    target = motor.program.labels.get(label)
    if target is None or (kind == s.CALL_INPUT and within(motor, kind)) or not _call(motor, target, kind):
        return False
    if kind == s.CALL_INPUT:
        motor.i[s.WAIT_UNTIL] = 0
    return True


def within(motor: Processor, kind: int) -> bool:
    """True if a call of this kind (GOSUB, C1 or C2) is in progress.  Only RETURNI, STACK and END end a C2 call."""
    if kind == s.CALL_INPUT:
        return bool(motor.i[s.C2_CALLED])
    return any(motor.i[s.RETURNS + number] & 3 == kind for number in range(motor.i[s.DEPTH]))


def return_(motor: Processor) -> None:
    """RETURN: return from a GOSUB.  Without a GOSUB in progress, RETURN sets Bs and ends the program."""
    interpreter.go_back(motor.i)


def return_fault(motor: Processor) -> None:
    """RETURNF: return from the fault routine, which begins at label C1 (manual, chapter 7)."""
    interpreter.go_back(motor.i)


def return_interrupt(motor: Processor) -> None:
    """RETURNI: return from C2, the interrupt routine of pin G, which may then call it again (chapter 7)."""
    motor.i[s.C2_CALLED] = 0
    interpreter.go_back(motor.i)


def stack(motor: Processor) -> None:
    """STACK: discard all return addresses (manual, chapter 7).  Pin G may then call C2 again."""
    interpreter.forget(motor.i)


def wait(motor: Processor, value: int) -> None:
    """WAIT=exp: pause for `value` samples (4069: one second), after PIDn n times as many; only C2 ends it early."""
    motor.i[s.WAIT_UNTIL] = motor.i[s.SAMPLE] + 1 + value * motor.i[s.PID_RATE]


def twait(motor: Processor) -> None:
    """TWAIT: pause the program while a trajectory is in progress."""
    motor.i[s.TWAITING] = 1


def pause(motor: Processor) -> None:
    """!: pause the program until a character arrives on a serial channel."""
    motor.i[s.PROGRAM] = s.BLOCKED
    motor.i[s.PAUSED] = 1


def reset(motor: Processor) -> None:
    """Z: restart the motor as at power-up."""
    motor.reset()


def part_of_block(motor: Processor) -> None:
    """IF, WHILE, etc.: set Bs: from a host they are invalid; in a program, the compiler has replaced them."""
    motor.syntax_error()


def _go(motor: Processor, pc: int) -> None:
    motor.i[s.PC] = pc
    _start(motor)


def _start(motor: Processor) -> None:
    motor.i[s.PROGRAM] = s.RUNNING
    motor.i[s.STATEMENT], motor.statement_before = motor.program.number_at(motor.i[s.PC]), s.NOTHING_YET
    _wait_no_more(motor)


def _wait_no_more(motor: Processor) -> None:
    motor.i[s.WAIT_UNTIL] = motor.i[s.TWAITING] = motor.i[s.PAUSED] = 0


def _call(motor: Processor, target: int, kind: int) -> bool:
    standing = motor.i[s.PROGRAM] == s.STOPPED
    called = interpreter.call(motor.i, target, NOWHERE if standing else motor.i[s.PC], kind)
    if called and standing:
        _start(motor)
    return called
