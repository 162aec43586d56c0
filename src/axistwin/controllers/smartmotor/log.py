"""What a trace follows inside the motor's processor: numbers that are looked at after every sample.

The kernel writes changes into an array of integers, which the processor's core reads when a block has become the truth:

    FOLLOWED  how many numbers are followed; 0: nobody looks
    USED      how many changes have been written
    ROOM      how many there is room for
    HEAD …    for each number: an operation of the interpreter (SLOT, VARIABLE or COMPUTED), its place, its last value
    then      for each change: the sample, the number's index, its value
"""

from array import array
from collections.abc import Mapping, Sequence

from axistwin.controllers.smartmotor.interpreter import COMPUTED, SLOT, VARIABLE, Ints, computed
from axistwin.controllers.smartmotor.jit import sampled
from axistwin.controllers.smartmotor.state import SAMPLE

FOLLOWED, USED, ROOM, HEAD = range(4)
FIELDS = 3
KINDS = SLOT, VARIABLE, COMPUTED
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
def note(i: Ints, v: Ints, log: Ints) -> None:
    """Write down what has changed since the last time."""
    for k in range(log[FOLLOWED]):
        at = HEAD + FIELDS * k
        now = value(i, v, log[at], log[at + 1])
        if now != log[at + 2]:
            log[at + 2] = now
            to = HEAD + FIELDS * (log[FOLLOWED] + log[USED])
            log[to], log[to + 1], log[to + 2] = i[SAMPLE], k, now
            log[USED] += 1


def empty() -> "array[int]":
    """Nobody follows anything."""
    return array("q", [0, 0, 0])


def following(
    numbers: Sequence[tuple[int, int]], i: Ints, v: Ints, before: Mapping[tuple[int, int], int]
) -> "array[int]":
    """A log of these numbers, each an operation and a place, as they are now, or as another log had them `before`."""
    log = array("q", [len(numbers), 0, max(CHANGES, len(numbers))])
    for operation, place in numbers:
        last = before.get((operation, place))
        log.extend((operation, place, value(i, v, operation, place) if last is None else last))
    log.extend([0] * (FIELDS * log[ROOM]))
    return log


def known(log: "array[int]") -> dict[tuple[int, int], int]:
    """How the numbers are, as far as this log has been told."""
    heads = range(HEAD, HEAD + FIELDS * log[FOLLOWED], FIELDS)
    return {(log[at], log[at + 1]): log[at + 2] for at in heads}


class Look:
    """How these numbers are, all at once: what `note` does one by one, for Python, which is asked at every event."""

    def __init__(self, numbers: Sequence[tuple[int, int]]) -> None:
        of_kind = {kind: [k for k, (operation, _) in enumerate(numbers) if operation == kind] for kind in KINDS}
        self._order = [k for kind in KINDS for k in of_kind[kind]]
        self._slots, self._variables, self._computed = (
            [place for operation, place in numbers if operation == kind] for kind in KINDS
        )

    def changed(self, i: Ints, v: Ints, log: "array[int]") -> tuple[list[int], list[int]]:
        """Which numbers are not as the log has them, and how they are now; the log then has them so."""
        now = [i[place] for place in self._slots]
        now += [v[place] for place in self._variables]
        now += [computed(i, place) for place in self._computed]
        known = log[HEAD + 2 : HEAD + FIELDS * len(now) : FIELDS]
        found = sorted((k, at) for k, at in zip(self._order, now, strict=True) if known[k] != at)
        for k, at in found:
            log[HEAD + FIELDS * k + 2] = at
        return [k for k, _ in found], [at for _, at in found]


def head(log: "array[int]") -> slice:
    """The part of a log that says how things are."""
    return slice(0, HEAD + FIELDS * log[FOLLOWED])


def changes(log: "array[int]") -> "tuple[array[int], array[int], array[int]]":
    """What has been written: samples, which of the numbers, and their values from there on."""
    first = HEAD + FIELDS * log[FOLLOWED]
    written = log[first : first + FIELDS * log[USED]]
    return written[0::FIELDS], written[1::FIELDS], written[2::FIELDS]
