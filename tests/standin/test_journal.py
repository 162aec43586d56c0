"""The journal of a stand-in: only a whole last line counts, and a disk that fails delays no stop."""

import os
import runpy
from pathlib import Path
from queue import SimpleQueue

import pytest

from axistwin.core.errors import UsageError
from axistwin.real.standin.board import State
from axistwin.real.standin.events import Stopped
from axistwin.real.standin.hal.board import HalBoard
from axistwin.real.standin.hal.wiring import HalWiring
from axistwin.real.standin.journal import Journal, last_positions
from axistwin.real.standin.sender import Sender
from axistwin.real.standin.wiring import DrivenAxis

from .metal import Metal

AXES = ["table.X", "table.Y"]
CAMPAIGN = runpy.run_path(str(Path(__file__).parents[2] / "benchmarks" / "robustness" / "journals.py"))
FULL = Path("/dev/full")


@pytest.fixture
def path(tmp_path):
    return tmp_path / "table.journal"


@pytest.fixture
def journal(path):
    told = SimpleQueue()
    made = Journal(path, "table.X, table.Y", told.put)
    made.told = told
    yield made
    made.close()


class Filled:
    """A journal on a disk that is full within a `with` block."""

    def __init__(self, journal):
        self._number = journal._file.fileno()

    def __enter__(self):
        if not FULL.exists():
            pytest.skip("this system has no /dev/full")
        self._kept = os.dup(self._number)
        with FULL.open("wb", buffering=0) as full:
            os.dup2(full.fileno(), self._number)

    def __exit__(self, *_):
        os.dup2(self._kept, self._number)
        os.close(self._kept)


def test_positions_are_known_only_after_a_completed_run(path, journal):
    journal.note("pulses table.X +1 100 100 2 0")
    assert last_positions(path, AXES) is None
    assert journal.end({"table.X": 12345, "table.Y": -2})
    assert last_positions(path, AXES) == {"table.X": 12345, "table.Y": -2}
    assert last_positions(path, ["table.Y"]) == {"table.X": 12345, "table.Y": -2}
    assert last_positions(path, [*AXES, "table.Z"]) is None  # an axis that the last run did not have


def test_without_a_run_each_axis_is_at_0_and_an_empty_journal_is_none(path):
    assert last_positions(path, AXES) == {"table.X": 0, "table.Y": 0}
    path.touch()
    assert last_positions(path, AXES) is None


@pytest.mark.parametrize(
    "text",
    [
        "end table.X=12345 table.Y=-2\n",  # the form without a check sum
        "end table.X=123",
        "end\n",
        "end crc32=deadbeef\n",
        "begin 2026-11-22T10:00:00Z table.X\n",
    ],
)
def test_an_incomplete_last_line_does_not_count(path, text):
    path.write_text(text)
    assert last_positions(path, AXES) is None


def test_damaged_journals_and_full_disks(capsys):
    """A small instance of the campaign."""
    assert CAMPAIGN["main"](["--seed", "3", "--mutations", "200", "--disks", "8"]) == 0
    assert capsys.readouterr().out.startswith("passed: seed 3: 0 wrong;")


def test_a_new_run_forgets_the_positions_of_the_last_one(path, journal):
    journal.end({"table.X": 1, "table.Y": 2})
    journal.close()
    before = path.read_bytes()
    Journal(path, "table.X, table.Y").close()
    assert last_positions(path, AXES) is None
    path.write_bytes(path.read_bytes()[: len(before)])  # the begin of the new run is lost again
    assert last_positions(path, AXES) is None


def test_a_journal_that_cannot_be_written_refuses_the_start_and_stays_as_it_is(tmp_path, monkeypatch):
    with pytest.raises(UsageError, match="cannot be written"):
        Journal(tmp_path, "table.X")
    path = tmp_path / "table.journal"
    journal = Journal(path, "table.X")
    journal.end({"table.X": 7})
    journal.close()

    def full(_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("axistwin.real.standin.journal.os.fsync", full)
    for at in (path, tmp_path / "new.journal"):
        with pytest.raises(UsageError, match=r"journal .* cannot be written: no space left on device"):
            Journal(at, "table.X")
    assert last_positions(path, ["table.X"]) == {"table.X": 7}
    assert last_positions(tmp_path / "new.journal", ["table.X"]) == {"table.X": 0}


def test_a_disk_that_is_full_for_a_while_costs_lines_but_not_the_positions(path, journal):
    with Filled(journal):
        journal.note("pulses table.X +1 100 100 2 0")
        line = journal.told.get(timeout=300)
    assert line.startswith(f"journal {path} cannot be written (no space left on device): the run goes on; make room")
    assert journal.end({"table.X": 1, "table.Y": 2})
    assert last_positions(path, AXES) == {"table.X": 1, "table.Y": 2}
    assert "lost: lines are missing here" in path.read_text() and journal.told.empty()


def test_a_disk_that_is_full_at_the_end_loses_the_positions_and_says_so(path, journal):
    with Filled(journal):
        assert not journal.end({"table.X": 1, "table.Y": 2})
    assert last_positions(path, AXES) is None


def hung(journal):
    """Let the disk hang: nobody reads this pipe, which is full."""
    read, write = os.pipe()
    os.set_blocking(write, False)
    try:
        while True:
            os.write(write, b"x" * 4096)
    except BlockingIOError:
        os.set_blocking(write, True)
    os.dup2(write, journal._file.fileno())
    os.close(write)
    return read


class Port:
    """The serial port of a simulated board, one turn of the sender's thread at a time."""

    def __init__(self, metal):
        self._metal, self.in_waiting = metal, 0

    def write(self, data):
        self._metal.small.receive(data)


def test_a_stop_reaches_the_board_while_the_disk_hangs(journal, monkeypatch):
    metal = Metal(journal=journal.note).start()
    sender = Sender(metal.board, Port(metal), lambda sender, event: metal.events.append(event))
    monkeypatch.setattr("axistwin.real.standin.sender.monotonic", lambda: metal.now)
    read = hung(journal)
    journal.note("a line that waits for the disk")
    metal.move("table.X", +1, metal.even(400, 1000), seconds=0.2)
    sender.stop("stopped from the page")
    sender._turn(b"")
    metal.run(0.5)
    made = len(metal.small.pulses[2])
    assert 50 < made < 110  # 0.2 s less the horizon of 0.1 s
    [stopped] = [event for event in metal.events if isinstance(event, Stopped)]
    assert (stopped.reason, stopped.positions["table.X"]) == ("stopped from the page", made)
    os.close(read)


def test_a_stop_is_sent_before_it_is_written():
    """A journal that raises an error is not possible any more; here it shows the order."""

    def fail(line):
        if line.startswith("stop "):
            raise OSError(28, "No space left on device")

    metal = Metal(journal=fail).start()
    metal.move("table.X", +1, metal.even(400, 1000), seconds=0.2)
    with pytest.raises(OSError, match="No space"):
        metal.board.stop("by hand")
    metal.run(0.5)
    assert 50 < len(metal.small.pulses[2]) < 110
    assert [event.reason for event in metal.events if isinstance(event, Stopped)] == ["by hand"]

    hal = HalBoard(HalWiring("hal", (DrivenAxis("table.X"),)), journal=fail)
    hal.receive({"ready": {"table.X": 0}, "inputs": {}})
    hal.commands.clear()
    with pytest.raises(OSError, match="No space"):
        hal.stop("by hand")
    assert list(hal.commands) == [{"stop": ["table"]}]


@pytest.mark.parametrize(("error", "words"), [(OSError("no such device"), "disappeared"), (KeyError(1), "internal")])
@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_whatever_ends_the_thread_of_a_board_is_reported(error, words):
    class Broken:
        in_waiting = 0

        def read(self, count):
            raise error

        def close(self):
            pass

    metal, events = Metal().start(), []
    metal.board.fail("the board has stopped: Missed scheduling of next digital out event")
    sender = Sender(metal.board, Broken(), lambda sender, event: events.append(event))
    sender.start()
    sender.join(60)
    assert metal.board.state is State.FAILED
    assert events[-1].gone and words in events[-1].reason
