"""A log of changes for traces.  A trace records some values of the motor's processor: the traced values.

After every sample the kernel compares each traced value with its last value.  Only statements change variables and
buffered parameters, so these are compared only after statements.  The kernel computes a block of samples ahead, and
writes the changes into an array of integers; when virtual time reaches the block, the core reads the array:

    FOLLOWED  number of traced values; 0: no trace
    USED      number of changes written
    ROOM      number of changes that fit
    MOVING    number of traced values that change without a statement; they come first
    HEAD …    for each value: its kind (SLOT, VARIABLE or COMPUTED), its index among the values of this kind,
              its last value, its index for the trace
    then      for each change: the sample, the index for the trace, the value
"""

from array import array
from collections.abc import Mapping, Sequence

from axistwin.controllers.smartmotor.kernel.interpreter import COMPUTED, SLOT, VARIABLE, Ints, computed
from axistwin.controllers.smartmotor.kernel.jit import sampled
from axistwin.controllers.smartmotor.kernel.state import BUFFERED_FACTOR, SAMPLE, A

FOLLOWED, USED, ROOM, MOVING, HEAD = range(5)
NUMBER, CHANGE = 4, 3  # Lengths of an entry in the head of a log, and of a logged change.
KINDS = COMPUTED, SLOT, VARIABLE  # The kinds of numbers, in their order in the log.
CHANGES = 1 << 14  # Smallest number of changes in one block that the log can store.


@sampled
def value(i: Ints, v: Ints, operation: int, place: int) -> int:
    """Return the present value of a followed number; reading has no side effect."""
    if operation == SLOT:
        return i[place]
    if operation == COMPUTED:
        return computed(i, place)
    return v[place]


@sampled
def room(log: Ints) -> bool:
    """True if the log has enough space for one servo sample in which all traced values change."""
    return log[USED] + log[FOLLOWED] <= log[ROOM]


@sampled
def note(i: Ints, v: Ints, log: Ints, numbers: int) -> None:
    """Log those of the first `numbers` followed numbers that have changed since the last call."""
    to = HEAD + NUMBER * log[FOLLOWED] + CHANGE * log[USED]
    for at in range(HEAD, HEAD + NUMBER * numbers, NUMBER):
        now = value(i, v, log[at], log[at + 1])
        if now != log[at + 2]:
            log[at + 2] = now
            log[to], log[to + 1], log[to + 2] = i[SAMPLE], log[at + 3], now
            log[USED] += 1
            to += CHANGE


def empty() -> "array[int]":
    """Return an empty log, for a motor without traced values."""
    return array("q", [0] * HEAD)


def moving(operation: int, place: int) -> bool:
    """True if a value can change while no program statement is executed, e.g. the position of the shaft."""
    return operation == COMPUTED or (operation == SLOT and not A <= place <= BUFFERED_FACTOR)


def following(
    numbers: Sequence[tuple[int, int]], i: Ints, v: Ints, before: Mapping[tuple[int, int], int]
) -> "array[int]":
    """Return a log of these numbers, each an operation and a place; keep the last values of the log `before`."""
    log = array("q", [len(numbers), 0, max(CHANGES, len(numbers)), sum(moving(*number) for number in numbers)])
    order = sorted(range(len(numbers)), key=lambda k: (KINDS.index(numbers[k][0]), not moving(*numbers[k])))
    for k in order:
        last = before.get(numbers[k])
        log.extend((*numbers[k], value(i, v, *numbers[k]) if last is None else last, k))
    log.extend([0] * (CHANGE * log[ROOM]))
    return log


def last_values(log: "array[int]") -> dict[tuple[int, int], int]:
    heads = range(HEAD, head(log).stop, NUMBER)
    return {(log[at], log[at + 1]): log[at + 2] for at in heads}


class Snapshot:
    """The last values of all followed numbers; has the same effect as `note`, but is fast in plain Python."""

    def __init__(self, log: "array[int]") -> None:
        operations, places, _, self._called = (log[head(log)][HEAD + field :: NUMBER] for field in range(NUMBER))
        self._computed, self._slots, self._variables = (
            [place for operation, place in zip(operations, places, strict=True) if operation == kind] for kind in KINDS
        )

    def changed(self, i: Ints, v: Ints, log: "array[int]") -> tuple[list[int], list[int]]:
        now = array("q", [computed(i, place) for place in self._computed])
        now.extend([i[place] for place in self._slots])
        now.extend([v[place] for place in self._variables])
        values = slice(HEAD + 2, head(log).stop, NUMBER)
        last = log[values]
        if now == last:
            return [], []
        log[values] = now
        found = [(k, at) for k, before, at in zip(self._called, last, now, strict=True) if at != before]
        return [k for k, _ in found], [at for _, at in found]


def head(log: "array[int]") -> slice:
    """Return the head of a log, which is the part before the logged changes."""
    return slice(0, HEAD + NUMBER * log[FOLLOWED])


def changes(log: "array[int]") -> "tuple[array[int], array[int], array[int]]":
    """Return the logged changes: samples, indices of numbers, and new values."""
    first = head(log).stop
    written = log[first : first + CHANGE * log[USED]]
    return written[0::CHANGE], written[1::CHANGE], written[2::CHANGE]
