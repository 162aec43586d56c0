"""Who drives."""

from axistwin.apps.panel import people
from axistwin.apps.panel.people import People


def test_the_first_to_come_drives_and_comes_back_as_the_driver():
    those = People()
    first, second = those["a"], those["b"]
    assert those.driver is first
    assert those["a"] is first
    assert [first.name, second.name] == ["visitor 1", "visitor 2"]


def test_taking_over_is_told_to_everybody_once():
    those, told = People(), []
    _, second = those["a"], those["b"]
    end = those.listen(told.append)
    those.take_over(second)
    those.take_over(second)
    end()
    those.take_over(those["a"])
    assert told == ["visitor 2 drives now"]
    assert those.driver is those["a"]


def test_a_driver_who_has_gone_for_long_is_replaced_by_who_comes(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(people, "monotonic", lambda: now[0])
    those = People()
    first = those["a"]
    first.came()
    now[0] = 1000.0
    assert those["b"].name == "visitor 2"
    assert those.driver is first  # who is looking on
    first.left()
    now[0] = 1000.0 + people.GONE_S
    assert those["b"] is not those.driver
    now[0] += 0.1
    assert those["b"] is those.driver


def test_a_reload_within_that_time_keeps_the_wheel(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(people, "monotonic", lambda: now[0])
    those = People()
    first = those["a"]
    first.came()
    first.left()
    now[0] = 5.0
    assert those["a"] is first
    first.came()
    now[0] = 500.0
    those["b"].came()
    assert those.driver is first
    assert [person.name for person in those.there] == ["visitor 1", "visitor 2"]


def test_names_can_be_changed_but_not_to_nothing():
    those = People()
    person = those["a"]
    those.rename(person, "  Anna   Berg ")
    assert person.name == "Anna Berg"
    those.rename(person, "   ")
    assert person.name == "Anna Berg"
    those.rename(person, "x" * 200)
    assert len(person.name) == people.LONGEST_NAME
