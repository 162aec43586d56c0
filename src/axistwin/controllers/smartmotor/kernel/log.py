"""What a trace follows inside the motor's processor: numbers that are looked at after every sample.

Those that nothing but statements changes, variables and buffered parameters, are looked at where statements have been.
The kernel writes changes into an array of integers, which the processor's core reads when a block has become the truth:

    FOLLOWED  how many numbers are followed; 0: nobody looks
    USED      how many changes have been written
    ROOM      how many there is room for
    MOVING    how many numbers a sample may change by itself; they come first
    HEAD …    for each number: an operation of the interpreter (SLOT, VARIABLE or COMPUTED), its place, its last value,
              what the follower calls it
    then      for each change: the sample, what the follower calls the number, its value
"""

from array import array
from collections.abc import Mapping, Sequence

from axistwin.controllers.smartmotor.kernel.interpreter import COMPUTED, SLOT, VARIABLE, Ints, computed
from axistwin.controllers.smartmotor.kernel.jit import sampled
from axistwin.controllers.smartmotor.kernel.state import BUFFERED_FACTOR, SAMPLE, A

FOLLOWED, USED, ROOM, MOVING, HEAD = range(5)
NUMBER, CHANGE = 4, 3
"""How long an entry is."""
KINDS = COMPUTED, SLOT, VARIABLE
"""In this order they stand there."""
CHANGES = 1 << 14
"""Changes that one block may have, at least."""


@sampled
def value(i: Ints, v: Ints, operation: int, place: int) -> int:
    """A number as it is now; reading it changes nothing."""
    if operation == SLOT:
        return i[place]
    if operation == COMPUTED:
        return computed(i, place)
    return v[place]


@sampled
def room(log: Ints) -> bool:
    """Whether a sample may change everything that is followed."""
    return log[USED] + log[FOLLOWED] <= log[ROOM]


@sampled
def note(i: Ints, v: Ints, log: Ints, numbers: int) -> None:
    """Write down which of the first `numbers` have changed since the last time."""
    to = HEAD + NUMBER * log[FOLLOWED] + CHANGE * log[USED]
    for at in range(HEAD, HEAD + NUMBER * numbers, NUMBER):
        now = value(i, v, log[at], log[at + 1])
        if now != log[at + 2]:
            log[at + 2] = now
            log[to], log[to + 1], log[to + 2] = i[SAMPLE], log[at + 3], now
            log[USED] += 1
            to += CHANGE


def empty() -> "array[int]":
    """Nobody follows anything."""
    return array("q", [0] * HEAD)


def moving(operation: int, place: int) -> bool:
    """Whether a sample may change it, though no statement is in it."""
    return operation == COMPUTED or (operation == SLOT and not A <= place <= BUFFERED_FACTOR)


def following(
    numbers: Sequence[tuple[int, int]], i: Ints, v: Ints, before: Mapping[tuple[int, int], int]
) -> "array[int]":
    """A log of these numbers, each an operation and a place, as they are now, or as another log had them `before`."""
    log = array("q", [len(numbers), 0, max(CHANGES, len(numbers)), sum(moving(*number) for number in numbers)])
    order = sorted(range(len(numbers)), key=lambda k: (KINDS.index(numbers[k][0]), not moving(*numbers[k])))
    for k in order:
        last = before.get(numbers[k])
        log.extend((*numbers[k], value(i, v, *numbers[k]) if last is None else last, k))
    log.extend([0] * (CHANGE * log[ROOM]))
    return log


def known(log: "array[int]") -> dict[tuple[int, int], int]:
    """How the numbers are, as far as this log has been told."""
    heads = range(HEAD, head(log).stop, NUMBER)
    return {(log[at], log[at + 1]): log[at + 2] for at in heads}


class Look:
    """How these numbers are, all at once: what `note` does one by one, for Python, which is asked at every event."""

    def __init__(self, log: "array[int]") -> None:
        operations, places, _, self._called = (log[head(log)][HEAD + field :: NUMBER] for field in range(NUMBER))
        self._computed, self._slots, self._variables = (
            [place for operation, place in zip(operations, places, strict=True) if operation == kind] for kind in KINDS
        )

    def changed(self, i: Ints, v: Ints, log: "array[int]") -> tuple[list[int], list[int]]:
        """Which numbers are not as the log has them, and how they are now; the log then has them so."""
        now = array("q", [computed(i, place) for place in self._computed])
        now.extend([i[place] for place in self._slots])
        now.extend([v[place] for place in self._variables])
        values = slice(HEAD + 2, head(log).stop, NUMBER)
        known = log[values]
        if now == known:
            return [], []
        log[values] = now
        found = [(k, at) for k, before, at in zip(self._called, known, now, strict=True) if at != before]
        return [k for k, _ in found], [at for _, at in found]


def head(log: "array[int]") -> slice:
    """The part of a log that says how things are."""
    return slice(0, HEAD + NUMBER * log[FOLLOWED])


def changes(log: "array[int]") -> "tuple[array[int], array[int], array[int]]":
    """What has been written: samples, which of the numbers, and their values from there on."""
    first = head(log).stop
    written = log[first : first + CHANGE * log[USED]]
    return written[0::CHANGE], written[1::CHANGE], written[2::CHANGE]
