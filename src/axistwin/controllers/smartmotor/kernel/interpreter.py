"""The interpreter (7 and 8 of the base language): executes one statement of a program, or computes one expression.

A program is a flat list of integers.  A statement consists of an operation, the number of the statement, the place of
the next statement, and the operands.  An expression is in postfix order and ends in RESULT.  `expressions.py` and
`program.py` write this code.  `statement` and `evaluate` run in every sample, so they use only integers in arrays.

Arithmetic is that of signed 32-bit integers.  A result that does not fit, and a division by zero, set Bd.  An index
outside the array sets Bu.  Text that is not an expression sets Bs (NO_VALUE).  In each case the statement is
abandoned, and a condition counts as false.
"""

from collections.abc import MutableSequence, Sequence

from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.jit import sampled
from axistwin.controllers.smartmotor.kernel.position import actual_position, following_error, wrapped

Ints = MutableSequence[int]

LOWEST, HIGHEST = -(1 << 31), (1 << 31) - 1
STACK = 64  # Number of intermediate results that an expression can have at once.

# Results of the execution of one program statement
DONE, TRAP, HELD, FETCH = range(4)

# Operation codes of expressions; the operators with two operands, e.g. a+b, have the highest codes.
RESULT, CONSTANT, SLOT, VARIABLE, BYTE, WORD, LONG, COMPUTED, PIN, NEGATIVE, OVERFLOW, NO_VALUE, TAKEN_PIN = range(13)
(
    ADD, SUBTRACT, MULTIPLY, DIVIDE, REMAINDER, POWER, AND, OR, EXCLUSIVE_OR,
    EQ, NE, LT, GT, LE, GE,
) = range(13, 28)  # fmt: skip

# System variables that are computed whenever they are read, e.g. the present position
POSITION, POSITION_ERROR, CLOCK, INDEX_POSITION, STATUS_WORD, STATUS_BYTE, PIN_WORD, AT_STATEMENT, MODE_REPORTED = (
    range(9)
)

# Operation codes of program statements, e.g. IF or WAIT
(
    S_IF, S_JUMP, S_LET, S_TRAP, S_ELEMENT, S_WAIT, S_TWAIT, S_SWITCH, S_CASE, S_GOSUB,
    S_RETURN, S_RETURNI, S_STACK, S_END, S_FETCH,
) = range(15)  # fmt: skip
HEAD = 3  # Length of a statement's head: operation, number, and the place of the next statement after an error.

CALL_C2 = 64  # The function of F that lets pin G call C2 (table 7.1).
MOST_POWER = 4


@sampled
def computed(i: Ints, what: int) -> int:
    """Return @P, CLK or another computed variable.  Reading `I` clears Bi and enables the next capture."""
    if what == POSITION:
        return actual_position(i)
    if what == POSITION_ERROR:
        return following_error(i)
    if what == CLOCK:
        return wrapped(i[s.SAMPLE] - i[s.CLK_ZERO])
    if what == INDEX_POSITION:
        i[s.BI], i[s.INDEX_ARMED] = 0, 1
        return i[s.INDEX]
    if what == PIN_WORD:
        return i[s.PINS] & 0x7F
    if what == AT_STATEMENT:
        return 0 if i[s.PROGRAM] == s.STOPPED else i[s.STATEMENT] + 1
    if what == MODE_REPORTED:
        return s.M_RELATIVE if i[s.MODE] == s.M_POSITION and i[s.FACTOR] else i[s.MODE]
    bits = 16 if what == STATUS_WORD else 8
    word = 0
    for bit in range(bits):
        word |= i[s.BT + bit] << bit
    return word


@sampled
def taken(i: Ints, bit: int) -> int:
    """Return the level of a pin that an assignment reads; set BRAKE_READ if the pin carries the brake signal (5.1)."""
    if i[s.BRAKE_PIN] == 1 << bit:
        i[s.BRAKE_READ] = 1
    return (i[s.PINS] >> bit) & 1


@sampled
def system_value(i: Ints, operation: int, place: int) -> int:
    """Return the level of a pin, or the value of a system variable that is calculated on demand, e.g. CLK."""
    if operation == PIN:
        return (i[s.PINS] >> place) & 1
    return taken(i, place) if operation == TAKEN_PIN else computed(i, place)


@sampled
def element(i: Ints, v: Ints, kind: int, index: int) -> int:
    """Return an element of ab[], aw[] or al[] at a valid index; bytes are big-endian within the longs (table 8.1)."""
    if kind == LONG:
        return v[i[s.ARRAY_BASE] + index]
    if kind == WORD:
        half = v[i[s.ARRAY_BASE] + (index >> 1)] >> (16 - 16 * (index & 1))
        return ((half + 0x8000) & 0xFFFF) - 0x8000
    part = v[i[s.ARRAY_BASE] + (index >> 2)] >> (24 - 8 * (index & 3))
    return ((part + 0x80) & 0xFF) - 0x80


@sampled
def set_element(i: Ints, v: Ints, kind: int, index: int, value: int) -> None:
    """Set an array element at a valid index; ab[] stores the low 8 bits, and aw[] the low 16 bits."""
    if kind == LONG:
        v[i[s.ARRAY_BASE] + index] = value
        return
    where, shift, mask = i[s.ARRAY_BASE] + (index >> 2), 24 - 8 * (index & 3), 0xFF
    if kind == WORD:
        where, shift, mask = i[s.ARRAY_BASE] + (index >> 1), 16 - 16 * (index & 1), 0xFFFF
    v[where] = wrapped((v[where] & ~(mask << shift)) | ((value & mask) << shift))


@sampled
def outside(kind: int, index: int) -> bool:
    """True if an index is out of range (8.2): ab[0…203], aw[0…101], al[0…50]."""
    size = s.BYTES if kind == BYTE else s.WORDS if kind == WORD else s.LONGS
    return index < 0 or index >= size


@sampled
def power(base: int, exponent: int) -> int:
    """Return a power; beyond 32 bits after an overflow, or for an exponent other than 0 to 4."""
    if exponent < 0 or exponent > MOST_POWER:
        return HIGHEST + 1
    value = 1
    for _ in range(exponent):
        value *= base
        if value > HIGHEST or value < LOWEST:
            return HIGHEST + 1
    return value


@sampled
def quotient(left: int, right: int) -> int:
    """Return the quotient of two integers, truncated towards zero.  `right` is not 0."""
    value = abs(left) // abs(right)
    return value if (left < 0) == (right < 0) else -value


@sampled
def combined(operation: int, left: int, right: int) -> int:
    """Apply an operator to two values; a number beyond 32 bits means that no result exists."""
    if operation == ADD:
        return left + right
    if operation == SUBTRACT:
        return left - right
    if operation == EQ:
        return int(left == right)
    if operation == NE:
        return int(left != right)
    if operation == LT:
        return int(left < right)
    if operation == GT:
        return int(left > right)
    if operation == LE:
        return int(left <= right)
    if operation == GE:
        return int(left >= right)
    if operation == AND:
        return left & right
    if operation == OR:
        return left | right
    if operation == EXCLUSIVE_OR:
        return left ^ right
    if operation == MULTIPLY:
        return left * right
    if operation == POWER:
        return power(left, right)
    if right == 0:
        return HIGHEST + 1
    if operation == DIVIDE:
        return quotient(left, right)
    return left - right * quotient(left, right)


@sampled
def evaluate(i: Ints, v: Ints, stack: Ints, code: Sequence[int], at: int) -> int:
    """Evaluate an expression into stack[0]; return the place after it, or -1 after an error (Bd, Bu or Bs is set)."""
    top = -1
    while True:
        operation = code[at]
        if operation == RESULT:
            return at + 1
        if operation == CONSTANT:
            value = code[at + 1]
        elif operation == VARIABLE:
            value = v[code[at + 1]]
        elif operation == SLOT:
            value = i[code[at + 1]]
        elif operation in (PIN, TAKEN_PIN, COMPUTED):
            value = system_value(i, operation, code[at + 1])
        else:
            if BYTE <= operation <= LONG:
                if outside(operation, stack[top]):
                    i[s.BU] = 1
                    return -1
                value = element(i, v, operation, stack[top])
            elif operation == NO_VALUE:
                i[s.BS] = 1
                return -1
            elif operation == NEGATIVE:
                value = -stack[top]
            elif operation == OVERFLOW:
                value = HIGHEST + 1
            else:
                top -= 1
                value = combined(operation, stack[top], stack[top + 1])
            if value > HIGHEST or value < LOWEST:
                i[s.BD] = 1
                return -1
            stack[top] = value
            at += 1
            continue
        top += 1
        stack[top] = value
        at += 2


@sampled
def store(i: Ints, v: Ints, stack: Ints, code: Sequence[int], at: int) -> None:
    """Execute an assignment to an array, coded as number of values, array, first index and values."""
    count, kind = code[at], code[at + 1]
    at = evaluate(i, v, stack, code, at + 2)
    index = stack[0]
    while at >= 0 and count > 0:
        at = evaluate(i, v, stack, code, at)
        if at >= 0:
            if outside(kind, index):
                i[s.BU] = 1
                return
            set_element(i, v, kind, index, stack[0])
            index += 1
            count -= 1


@sampled
def call_again(i: Ints) -> None:
    """Return from C1, and call C1 again if a fault has occurred within C1."""
    if i[s.FAULT_AGAIN] != 0:
        i[s.FAULT_AGAIN] = 0
        i[s.PENDING] |= s.CALL_FAULT


@sampled
def go_back(i: Ints) -> None:
    """RETURN: continue at the return address on top of the stack.

    The program ends if the stack is empty, or if the address is that of a stopped program.  RETURN without a GOSUB sets
    Bs.
    """
    if i[s.DEPTH] == 0:
        i[s.BS] = 1
        i[s.PROGRAM] = s.STOPPED
        return
    i[s.DEPTH] -= 1
    if i[s.RETURNS + i[s.DEPTH]] & 3 == s.CALL_FAULT:
        call_again(i)
    i[s.PC] = i[s.RETURNS + i[s.DEPTH]] >> 2
    if i[s.PC] < 0:
        i[s.PC] = 0
        i[s.PROGRAM] = s.STOPPED


@sampled
def call(i: Ints, target: int, back: int, kind: int) -> bool:
    """Call the subroutine at `target`; a full stack only sets Bs.  `back`: return address, -1 if stopped."""
    if i[s.DEPTH] >= s.DEPTH_MOST:
        i[s.BS] = 1
        return False
    i[s.RETURNS + i[s.DEPTH]] = (back << 2) | kind
    i[s.DEPTH] += 1
    i[s.PC] = target
    if target == i[s.C2_PLACE] and (kind == s.CALL_INPUT or i[s.F] & CALL_C2):
        i[s.C2_CALLED] = 1
    return True


@sampled
def forget(i: Ints) -> None:
    """STACK: discard all return addresses (manual, chapter 7).  Pin G may then call C2 again."""
    i[s.DEPTH] = 0
    i[s.C2_CALLED] = 0
    call_again(i)


@sampled
def statement(i: Ints, v: Ints, stack: Ints, code: Sequence[int]) -> int:
    """Execute the statement at i[PC].

    Return DONE; TRAP: Python must execute the statement; HELD: TWAIT holds the program; FETCH: Python must fetch
    external values, and then execute the statement at once.
    """
    if i[s.TWAITING] != 0:
        if i[s.BT] != 0:
            return HELD
        i[s.TWAITING] = 0
    pc = i[s.PC]
    operation = code[pc]
    i[s.STATEMENT] = code[pc + 1]
    i[s.PC] = code[pc + 2]
    if operation == S_IF:
        at = evaluate(i, v, stack, code, pc + HEAD)
        if at >= 0 and stack[0] != 0:
            i[s.PC] = at
    elif operation == S_JUMP:
        pass
    elif operation == S_LET:
        at = evaluate(i, v, stack, code, pc + HEAD + 1)
        if at >= 0:
            v[code[pc + HEAD]] = stack[0]
    elif operation == S_TRAP:
        return TRAP
    elif operation == S_ELEMENT:
        store(i, v, stack, code, pc + HEAD)
    elif operation == S_FETCH:
        return FETCH
    elif operation == S_CASE:
        if i[s.SWITCHES + i[s.DEPTH]] == code[pc + HEAD]:
            i[s.PC] = code[pc + HEAD + 1]
    else:
        return seldom(i, v, stack, code, pc)
    return DONE


@sampled
def seldom(i: Ints, v: Ints, stack: Ints, code: Sequence[int], pc: int) -> int:
    """Execute one of the less frequent statements; i[PC] is already the place of the next statement."""
    operation = code[pc]
    if operation == S_SWITCH:
        at = evaluate(i, v, stack, code, pc + HEAD)
        if at >= 0:
            i[s.SWITCHES + i[s.DEPTH]] = stack[0]
            i[s.PC] = at
    elif operation == S_GOSUB:
        call(i, code[pc + HEAD], i[s.PC], s.CALL_GOSUB)
    elif operation == S_RETURN:
        go_back(i)
    elif operation == S_RETURNI:
        i[s.C2_CALLED] = 0
        go_back(i)
    elif operation == S_STACK:
        forget(i)
    elif operation == S_WAIT:
        at = evaluate(i, v, stack, code, pc + HEAD)
        if at >= 0:
            i[s.WAIT_UNTIL] = i[s.SAMPLE] + 1 + stack[0] * i[s.PID_RATE]
    elif operation == S_TWAIT:
        if i[s.BT] != 0:
            i[s.TWAITING] = 1
            return HELD
    else:  # The program stops at the command END and at the end of its code.
        forget(i)
        i[s.PROGRAM] = s.STOPPED
    return DONE
