"""The command table: what a pattern matches, what its handler gets, and patterns that cannot be right."""

import pytest

from axistwin.core.errors import UsageError
from axistwin.devices import Datagrams, Device, Lines, Positioner, Refused, Why, command, query
from axistwin.devices.making import product_of
from axistwin.devices.table import Pattern, collected


class Everything(Device):
    """A device with every kind of placeholder."""

    model = "everything"
    axes = {"X": Positioner(), "X2": Positioner()}

    @command("{axis}PA{position:int -1000..1000 steps}", section="Absolute move")
    def move(self, axis, position): ...

    @command("V={speed:float 0.5..200 mm/s}[,{ramp:float}]")
    def set_speed(self, speed, ramp): ...

    @command("NAME {name}")
    def set_name(self, name): ...

    @command("SAY {words:text}", name="say something")
    def say(self, words): ...

    @query("MODE=1")
    def mode(self): ...

    @query("{axis}?")
    @query("TELL {axis}")
    def tell(self, axis): ...

    @command("WIRE {first:axis},{second:axis}")
    def wire(self, first, second): ...


FIND = Lines().finder(collected(Everything), Everything.axes)


def found(line):
    try:
        request = FIND(line)
    except Refused as reason:
        return reason.words, {} if reason.why is Why.UNKNOWN else reason.why
    return request.entry.handler.__name__, dict(request.values)


@pytest.mark.parametrize(("line", "name", "values"), [
    (b"XPA-1000", "move", {"axis": "X", "position": -1000}),
    (b"X2PA+12", "move", {"axis": "X2", "position": 12}),
    (b"XPA-" + b"0" * 30 + b"7", "move", {"axis": "X", "position": -7}),
    (b"V=200", "set_speed", {"speed": 200.0, "ramp": None}),
    (b"V=.5,-1e3", "set_speed", {"speed": 0.5, "ramp": -1000.0}),
    (b"NAME left_1", "set_name", {"name": "left_1"}),
    (b"SAY good morning", "say", {"words": "good morning"}),
    (b"SAY ", "say", {"words": ""}), (b"SAY", "unknown command 'SAY'", {}),
    (b" MODE=1", "unknown command ' MODE=1'", {}), (b"MODE=1 ", "unknown command 'MODE=1 '", {}),
    (b"MODE=1\n", "unknown command 'MODE=1\\n'", {}), (b"\x0bMODE=1", "unknown command '\\x0bMODE=1'", {}),
    (b"MODE=1", "mode", {}),
    (b"X2?", "tell", {"axis": "X2"}), (b"TELL X", "tell", {"axis": "X"}),
    (b"WIRE X,X2", "wire", {"first": "X", "second": "X2"}),
    (b"YPA1", "axis 'Y': expected X or X2", Why.FORMAT), (b"xPA1", "axis 'x': expected X or X2", Why.FORMAT),
    (b"PA1", "axis '': expected X or X2", Why.FORMAT), (b"XYZPA1", "unknown command 'XYZPA1'", {}),
    (b"XPA1.5", "position '1.5': expected a whole number", Why.FORMAT),
    (b"XPA", "position '': expected a whole number", Why.FORMAT), (b"XPAUSE", "unknown command 'XPAUSE'", {}),
    (b"V=1,x", "unknown command 'V=1,x'", {}), (b"V=1,1.2.3", "ramp '1.2.3': expected a number", Why.FORMAT),
    (b"NAME ", "name '': expected letters, digits or _", Why.FORMAT),
    (b"XPA1 ;", "unknown command 'XPA1 ;'", {}), (b"MODE=12", "unknown command 'MODE=12'", {}),
    (b"NAME a b", "unknown command 'NAME a b'", {}), (b"XPA\xb2", "unknown command 'XPA\xb2'", {}),
])  # fmt: skip
def test_lines_and_their_values(line, name, values):
    assert found(line) == (name, values)


@pytest.mark.parametrize(("line", "words"), [
    (b"XPA1001", "position 1001: expected position -1000…1000 steps"),
    (b"XPA-1001", "position -1001: expected position -1000…1000 steps"),
    (b"XPA" + b"9" * 250, "position 999999999999999999…: expected position -1000…1000 steps"),
    (b"V=0.4", "speed 0.4: expected speed 0.5…200.0 mm/s"),
    (b"V=1,9e999", "ramp inf: expected [ramp]"),
])  # fmt: skip
def test_values_out_of_range(line, words):
    with pytest.raises(Refused) as refused:
        FIND(line)
    assert (refused.value.words, refused.value.why) == (words, Why.RANGE)


def test_many_digits_between_numbers_without_a_separator_do_not_hang():
    """The expression of a number is unambiguous: the work for 60 digits is their square, not their fifth power."""
    find = Lines().finder(collected(device_of("W{a:int}{b:float}{c:float}")), {})
    with pytest.raises(Refused, match="unknown command"):
        find(b"W" + b"1" * 60 + b"xy" * 40)
    assert find(b"W12.5.5").values == {"a": 12, "b": 0.5, "c": 0.5}


def test_without_case_an_axis_keeps_its_own_name():
    class Small(Device):
        model = "small"
        axes = {"x": Positioner()}

        @command("{axis}Go")
        def go(self, axis): ...

    find = Lines(ignore_case=True).finder(collected(Small), Small.axes)
    assert [find(line).values["axis"] for line in (b"xGo", b"XGO", b"xgo")] == ["x"] * 3


def test_the_list_for_users():
    table = [(each.syntax, each.name, each.chapter, [str(field) for field in each.parameters]) for each in
             product_of(Everything).commands]  # fmt: skip
    assert table == [
        ("<axis>PA<position>", "move", "Absolute move", ["axis", "position -1000…1000 steps"]),
        ("V=<speed>[,<ramp>]", "set speed", "", ["speed 0.5…200.0 mm/s", "[ramp]"]),
        ("NAME <name>", "set name", "", ["name"]),
        ("SAY <words>", "say something", "", ["words"]),
        ("MODE=1", "mode", "", []),
        ("TELL <axis>", "tell", "", ["axis"]),
        ("<axis>?", "tell", "", ["axis"]),
        ("WIRE <first>,<second>", "wire", "", ["first", "second"]),
    ]


def test_a_subclass_replaces_a_command():
    class Newer(Everything):
        model = "newer"

        @command("SAY {words:word}")
        def say(self, words): ...

    codes = [entry.code for entry in collected(Newer)]
    assert len(codes) == 8 and str(next(e for e in collected(Newer) if e.name == "say").parameters[0].kind) == "word"


@pytest.mark.parametrize(("pattern", "message"), [
    ("PA{to:integer}", r"d.py:7: invalid placeholder {to:integer}: expected a name and int, float, word, text"),
    ("PA{1:int}", r"invalid placeholder {1:int}"),
    ("PA{to:int", r"invalid pattern 'PA{to:int': expected pairs of brackets"),
    ("PA[{to:int}", r"expected pairs of brackets, e.g. '{axis}PA\[{to:int}\]'"),
    ("PA{to:int 0..x}", r"invalid range in {to:int 0..x}: expected LOW..HIGH, e.g. {to:int 0..9}"),
    ("PA{to:int 9..0}", r"invalid range in {to:int 9..0}"),
    ("PA{to:int},{to:int}", r"two placeholders {to} in 'PA{to:int},{to:int}': give one another name"),
])  # fmt: skip
def test_patterns_that_cannot_be_right(pattern, message):
    with pytest.raises(UsageError, match=message):
        Pattern.read(pattern, "d.py:7")


def device_of(*patterns, framing=None):
    """Return a class of a device with these patterns, each of a handler without parameters."""
    handlers = {f"handler_{n}": command(pattern)(lambda self: None) for n, pattern in enumerate(patterns)}
    return type("Made", (Device,), {"model": "made", "framing": framing or Lines(), "axes": {"X": Positioner()},
                                    "__module__": __name__, **handlers})  # fmt: skip


@pytest.mark.parametrize(("first", "second", "line"), [
    ("PA{to:int}", "PA{to:word}", "PA0"),
    ("PA{to:word}", "PA{to:int}", "PA0"),
    ("{what:text}", "ST", "ST"),
    ("ST", "{what:text}", "ST"),
    ("ST", "ST", "ST"),
    ("{axis}ST[{how:word}]", "{axis}ST", "XST"),
    ("{axis}ST", "XST[ now]", "XST"),
])  # fmt: skip
def test_two_commands_that_match_one_line(first, second, line):
    with pytest.raises(UsageError, match="change one of the patterns") as error:
        product_of(device_of(first, second))
    assert f"also matches {line!r}, as " in str(error.value)


FIELDS = Datagrams(">BBi code type value", ">i value")


@pytest.mark.parametrize(("patterns", "message"), [
    (["code=1", "code=1 type=2"], r"'code=1 type=2' also matches 'code=1', as 'code=1' does"),
    (["code=1", "code=1 {value:int 0..9}"], r"also matches 'code=1'"),
    (["cod=1"], r"no field 'cod': expected one of code, type, value"),
    (["code=1 {speed:int}"], r"no field 'speed': expected one of code, type, value"),
])  # fmt: skip
def test_datagrams_that_cannot_be_right(patterns, message):
    with pytest.raises(UsageError, match=message):
        product_of(device_of(*patterns, framing=FIELDS))


def test_of_two_datagrams_the_first_may_be_a_special_case():
    find = FIELDS.finder(collected(device_of("code=1 type=2", "code=1", framing=FIELDS)), {})
    assert [find(bytes([1, kind, 0, 0, 0, 0])).entry.code for kind in (2, 3)] == ["code=1 type=2", "code=1"]
    assert len(product_of(device_of("code=1 type=2", "code=1", framing=FIELDS)).commands) == 2
    with pytest.raises(Refused, match="unknown command 02 00 00 00 00 00"):
        find(bytes([2, 0, 0, 0, 0, 0]))


def test_a_parameter_that_the_pattern_lacks():
    class Wrong(Device):
        model = "wrong"

        @command("PA{position:int}")
        def move(self, axis, position): ...

    with pytest.raises(UsageError, match=r"test_table.py:\d+: the pattern 'PA<position>' has no {axis}: add it, or"):
        product_of(Wrong)


def test_a_parameter_that_the_method_does_not_take():
    expected = r"test_table.py:\d+: the method of '<axis>PA\[<to>\]' does not take 'axis': add it to its parameters"
    with pytest.raises(UsageError, match=expected):
        product_of(device_of("{axis}PA[{to:int}]"))


def test_an_empty_pattern_needs_an_address():
    with pytest.raises(UsageError, match=r"test_table.py:\d+: an empty pattern needs an address"):
        product_of(device_of(""))
    assert len(product_of(device_of("", framing=Lines(address="#"))).commands) == 1
