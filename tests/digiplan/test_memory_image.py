"""Using the battery backup: "any data": every value that can be programmed is kept; impossible values are refused."""

import json

import pytest

from axistwin import Bench
from axistwin.core.errors import UsageError

from .talking import ask, command, detect, each_character, host_format

LEAST = (">1<1^1", "@1", "B-255", "X0", "D0", ":P1,1:$")
MOST = (">4<40^500", "@4000", "B+255", "X999999999", "D25", ":P0,99:$")
FASTEST = (">3", "@99999")


def locked_with(directory, messages, form="U61", baud=9600):
    """Return an IF2 that was programmed with these messages, locked and switched off."""
    bench = Bench()
    if2 = bench.add("if2", state=directory, line=f"{baud} 8N2")
    detect(bench, if2)
    each_character(bench, if2, form + "\r", lambda n: bench.run(0.02))
    host_format(if2, form)
    bench.run(1.3)
    for message in (*messages, "["):
        command(bench, if2, message, seconds=3 if message[0] in ">:" else 0.5)
    if2.serial.read()
    assert ask(bench, if2, "F", 2) == b"32\r"
    if2.power(False)
    return next(directory.glob("*.json"))


def switched_on(directory, line="9600 8N2"):
    bench = Bench()
    if2 = bench.add("if2", state=directory, line=line, wiring="3-wire")
    bench.run(1.5)
    return bench, if2


@pytest.mark.parametrize(("messages", "form", "line"), [
    *((messages, "U61", "9600 8N2") for messages in (LEAST, MOST, FASTEST)),
    *(((), "U61", f"{baud} 8N2") for baud in (110, 300, 600, 1200, 2400, 4800, 9600)),
    ((), "U13", "9600 7O1"), ((), "U24", "9600 7E2"), ((), "U44", "9600 8E2")])  # fmt: skip
def test_the_ends_of_all_ranges_and_the_format_are_kept(tmp_path, messages, form, line):
    """Speed to Output switching commands: the lowest and the highest value of each parameter are kept.

    Running the stored sequence: "the same baud rate and data format".  Lockout: "exactly the same baud rate, number of
    bits etc.".
    """
    locked_with(tmp_path, messages, form, baud=int(line.split()[0]))
    bench, if2 = switched_on(tmp_path, line)
    bench.run(2)
    assert ask(bench, if2, "E", 5) == b"[\r"
    command(bench, if2, "]", seconds=1)
    assert ask(bench, if2, "E", 2) in (b"C\r", b"E\r")  # E: the stored sequence waits for an input


LOCK = {"baudrate": 9600, "bytesize": 8, "parity": "N", "eighth": [False, False]}
BEYOND = {
    "speed_range": (0, 5), "speed": (0, 100_000), "start_stop": (0, 41), "acceleration": (0, 501),
    "distance": (-1, 10**9), "minor_distance": (-1, 10**9), "backlash": (-256, 256), "pulse_length": (0, 100),
    "character_delay": (-1, 26),
}  # fmt: skip


def spoilt(file, **changes):
    kept = json.loads(file.read_text())
    for place, value in changes.items():
        *inside, name = place.split("__")
        part = kept
        for step in inside:
            part = part[step]
        assert name in part
        part[name] = value
    file.write_text(json.dumps(kept))


@pytest.fixture(scope="module")
def image(tmp_path_factory):
    return locked_with(tmp_path_factory.mktemp("memory"), (":H1:X5:$",)).read_text()


@pytest.fixture
def file(tmp_path, image):
    Bench().add("if2", state=tmp_path)
    path = tmp_path / "if2.json"
    path.write_text(image)
    return path


@pytest.mark.parametrize(
    ("place", "value"),
    [(f"parameters__{name}", value) for name, ends in BEYOND.items() for value in (*ends, True, "4", 4.0, None)]
    + [("locked", value) for value in (1, "yes", None)]
    + [(f"{part}baudrate", value) for part in ("", "lock__") for value in (9601, 0, 19_200, "9600", 9600.0, None)]
    + [("frame__x1", value) for value in (0, 9, "6", 6.0)]
    + [("frame__x2", value) for value in (0, 10, "1", True)]
    + [("frame__terminator", value) for value in ("W", "", None)]
    + [("lock__bytesize", value) for value in (6, 9, 8.0, "8", None)]
    + [("lock__parity", value) for value in ("n", "M", "", None, 0)]
    + [("lock__eighth", value) for value in ([], [False], [False, False, False], [0, 0], [False, "x"], 5)]
    + [("lock", value) for value in (5, dict(LOCK, eightieth=[]), {key: LOCK[key] for key in list(LOCK)[:3]})]
    + [("sequence", value) for value in ("X:::", ":X5", ":>2:$", 5, None)],
)
def test_no_value_is_believed_that_cannot_have_been_programmed(file, tmp_path, place, value):
    """A value that cannot have been programmed is an error of one line, which names the file and the remedy."""
    spoilt(file, **{place: value})
    with pytest.raises(UsageError) as told:
        switched_on(tmp_path)
    assert (
        "\n" not in str(told.value)
        and str(told.value).endswith("delete the file to start without data")
        and "if2" in str(told.value)
    )


def test_the_image_itself_is_believed(file, tmp_path):
    bench, if2 = switched_on(tmp_path)
    assert ask(bench, if2, "E") == b"[\r"
    if2.pins["input1"].drive(True)
    bench.run(0.5)
    assert if2.axes["X"].position == 5
