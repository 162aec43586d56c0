"""Subscriptions to the beginning of program lines."""

from axistwin.sim.progress import Progress


def test_everybody_is_told_what_he_wants_to_know():
    progress = Progress()
    every, one = [], []
    progress.subscribe(lambda *line: every.append(line))
    progress.subscribe(lambda *line: one.append(line), ("a", 2))
    for line in ("a", 1), ("a", 2), ("b", 2), ("a", 2):
        progress.report(*line)
    assert every == [("a", 1), ("a", 2), ("b", 2), ("a", 2)] and one == [("a", 2), ("a", 2)]


def test_what_is_wanted_is_told_to_the_device():
    seen = []
    progress = Progress(lambda: seen.append(progress.wanted))
    assert progress.wanted == frozenset()
    first = progress.subscribe(print, ("a", 1))
    again = progress.subscribe(print, ("a", 1))
    every = progress.subscribe(print)
    first()
    every()
    again()
    one, all_ = frozenset({("a", 1)}), None
    assert seen == [one, one, all_, all_, one, frozenset()]


def test_a_watcher_may_leave_when_it_is_told():
    progress, found = Progress(), []
    look_away = progress.subscribe(lambda *line: (found.append(line), look_away()))
    progress.subscribe(lambda *line: found.append(line))
    progress.report("a", 0)
    progress.report("a", 1)
    assert found == [("a", 0), ("a", 0), ("a", 1)]
