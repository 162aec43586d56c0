"""The journal of external input: compact moments, in limited memory."""

from hypothesis import given
from hypothesis import strategies as st

from axistwin.bench import Do, Say
from axistwin.core.units import MS
from axistwin.scenes.sessions.journal import Cursor, Journal, Moment

POLL = Say(b"R\r", controller="if1")


@given(st.lists(st.tuples(st.integers(0, 10**12), st.booleans(), st.sampled_from("abcd"))))
def test_what_goes_in_comes_out(told):
    journal, wanted, time_ns, clock_pass = Journal(), [], 0, 0
    for ns, anew, word in told:
        act = Do("input1", word, controller="if1")
        if anew or not wanted:
            time_ns, clock_pass = time_ns + ns, clock_pass + 1
            wanted.append(Moment(time_ns, ()))
        journal.add(time_ns, clock_pass, act)
        wanted[-1] = Moment(wanted[-1].time_ns, (*wanted[-1].acts, act))
    assert list(journal) == wanted


def test_a_host_that_polls_takes_five_bytes_a_poll():
    journal, polls = Journal(), 20_000
    for n in range(polls):
        journal.add(n * 50 * MS, n, POLL)
    assert journal.bytes < 5.1 * polls and sum(len(moment.acts) for moment in journal) == polls


def test_what_is_forgotten_has_never_been():
    journal = Journal()
    for n in range(3):
        journal.add(n * MS, n, Say(b"%d" % n, controller="if1"))
    first, cursor = journal.moment(Cursor())
    journal.truncate(cursor)
    journal.add(5 * MS, 2, POLL)
    assert list(journal) == [first, Moment(5 * MS, (POLL,))]


def test_a_full_journal_keeps_no_more_and_says_since_when():
    journal = Journal(max_bytes=1000)
    kept = [journal.add(n * MS, n, Say(b"%d" % n, controller="if1")) for n in range(10)]
    assert kept == [True] * 3 + [False] * 7
    assert journal.full_ns == 3 * MS and len(list(journal)) == 3
    journal.truncate(Cursor())
    assert journal.full_ns is None


def test_what_is_forgotten_takes_no_room():
    journal = Journal(max_bytes=1000)
    journal.add(0, 0, POLL)
    _, cursor = journal.moment(Cursor())
    kept = journal.bytes
    for n in range(1, 10):
        journal.add(n * MS, n, Say(b"%d" % n, controller="if1"))
    journal.truncate(cursor)
    assert journal.bytes == kept and [journal.add(n * MS, n, POLL) for n in range(1, 4)] == [True] * 3
    assert list(journal) == [Moment(n * MS, (POLL,)) for n in range(4)]
