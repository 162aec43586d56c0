"""The layout of a page, which the browser stores."""

import json
from urllib.parse import quote

import pytest

from axistwin import Session
from axistwin.ui.panel import layout
from axistwin.ui.panel.context import Common, Context
from axistwin.ui.panel.people import People
from axistwin.ui.panel.views.table import tool_choice

from .showing import bench_of, show_to


def test_a_new_user_finds_the_layout_that_the_browser_has_stored():
    first, second = People()["a"], People()["b"]
    first.settings |= {"tab if1": "Program", "dark": True, "scope": object(), "more": False}
    layout.restore(second, quote(layout.written(first)))
    assert second.settings == {"tab if1": "Program", "dark": True, "more": False}
    layout.restore(second, quote('{"dark":false}'))
    assert second.settings["dark"] is True, "the server knows this user"


@pytest.mark.parametrize("cookie", [None, "", "%", "[1]", "{", "17", quote('{"tab if1": [1], "dark": 3}')])
def test_an_invalid_cookie_is_ignored(cookie):
    person = People()["a"]
    layout.restore(person, cookie)
    assert person.settings == {}


def test_the_oldest_settings_are_left_out_of_a_cookie_that_is_too_long():
    person = People()["a"]
    person.settings |= {f"tab controller{number}": "Program" for number in range(200)}
    kept = json.loads(layout.written(person))
    assert len(layout.written(person)) <= layout.MOST
    assert "tab controller199" in kept and "tab controller0" not in kept


def test_a_stored_tool_that_this_machine_does_not_have_is_not_selected():
    people = People()
    context = Context(
        Common(Session(bench_of("if1", X={"limits": (0, 9)}, Y={"limits": (0, 9)}), None)), people, people["a"]
    )
    context.person.settings["if1 tool"] = "laser"
    chosen = []

    def view(context):
        tool_choice(context, "if1")
        return lambda: None

    show_to(context, view, lambda visit: chosen.append(visit.found("if1 tool").value))
    assert chosen == ["output1"]
