"""Appendix 3: the manual's own host programs, on a real BASIC interpreter, move an IF1 as their listings say."""

import itertools

import pytest

from axistwin.core.units import S
from axistwin.sim.frames import UartFormat

from .hosting import Session, perform
from .listings import ADAPTATIONS, MANUAL, REPAIRS, printed, runnable

pytestmark = pytest.mark.skipif(not MANUAL.exists(), reason="the manual is not here")

FORTH, BACK = {"X": 1000}, {"X": -1000}
FORTH_AND_TEN_TIMES_BACK_AND_FORTH = [FORTH, *[BACK, FORTH] * 10]


def assert_no_complaint(session: Session) -> None:
    assert not [word for word in ("ERROR", "FAULT", "NO U", "rror", "imeout") if word in session.screen], session.screen
    assert (session.ask("K"), session.ask("F")) == ("0", "0")


def together(*signs: str) -> dict[str, int]:
    """Return a move of X, Y and Z at once, by 1000 pulses in these directions; a blank leaves its axis out."""
    return {axis: int(f"{sign}1000") for axis, sign in zip("XYZ", signs, strict=True) if sign != " "}


# The listings


@pytest.mark.parametrize("program", range(1, 12))
def test_each_listing_is_found_whole(program):
    lines = list(printed(program))
    assert len(lines) > 40 and lines == sorted(lines)


@pytest.mark.parametrize("change", [*REPAIRS, *ADAPTATIONS], ids=lambda change: f"{change.program}-{change.line}")
def test_what_is_changed_in_a_listing_is_there(change):
    assert change.line in printed(change.program)
    assert change.found not in runnable(change.program)[change.line] or change.found in change.wanted


def test_the_programs_for_the_ibm_pc_run_nearly_as_they_are_printed():
    """The only changes are one illegible character and one waiting loop; the OPEN statements are as printed."""
    changed = [
        (program, line)
        for program in (7, 8, 9)
        for line, text in printed(program).items()
        if text != runnable(program)[line]
    ]
    assert changed == [(7, 270), (9, 90)]


# Programs that make moves


@pytest.mark.slow
@pytest.mark.parametrize(("program", "form", "line"), [
    (2, "V61", "2400 8N2"), (4, "U61", "2400 8N2"), (5, "U62", "4800 8N2")
], ids=["2-nec-2400", "4-epson-2400", "5-epson-4800-echo"])  # fmt: skip
def test_the_index_loop_moves_x_forth_and_ten_times_back_and_forth(program, form, line, tmp_path):
    session = perform(program, form, tmp_path, line=line)
    session.bench.run(2.0)  # the program ends as soon as it has sent the last move
    assert session.moves() == FORTH_AND_TEN_TIMES_BACK_AND_FORTH and session.controller.axes["X"].position == 1000
    assert_no_complaint(session)


@pytest.mark.slow
def test_sample_1_finds_every_character_echoed_and_each_takes_its_time_on_the_line(tmp_path):
    """The program compares each character with its echo, at 9600 baud with 11 bits per character."""
    session = perform(1, "U62", tmp_path, line="9600 8N2")
    session.bench.run(2.0)
    gaps_ns = [after - before for before, after in itertools.pairwise(session.heard_ns)]
    assert min(gaps_ns) >= 11 * S // 9600
    assert session.heard.startswith(b"U\rX1000@1000$\rE\r")
    assert set(session.heard.decode().split("\r")) == {"U", "X1000@1000$", "X-$", "X$", "E", "C", ""}
    assert session.moves() == FORTH_AND_TEN_TIMES_BACK_AND_FORTH
    assert_no_complaint(session)


@pytest.mark.slow
def test_sample_8_sets_its_own_baud_rate_and_checks_the_echo_of_every_character(tmp_path):
    """Over RFC2217 the OPEN statement of the listing sets the line: 9600 baud, 8 data bits, 2 stop bits."""
    session = perform(8, "U62", tmp_path, link="rfc2217", line="300 7E1")
    session.bench.run(2.0)
    assert session.controller.serial.host.format == UartFormat(9600, 8, "N", 2)
    assert session.moves() == FORTH_AND_TEN_TIMES_BACK_AND_FORTH and session.screen.count("C\n") == 20
    assert_no_complaint(session)


def test_sample_7_moves_x_and_y_forth_and_back(tmp_path):
    session = perform(7, "U61", tmp_path, link="rfc2217", line="2400 8N2")
    assert session.moves() == [{"X": 1000}, {"Y": 1000}, {"X": -1000}, {"Y": -1000}]
    assert session.heard.count(b"C\r") == 4
    assert_no_complaint(session)


@pytest.mark.slow
def test_sample_10_ends_with_an_interpolated_move_forth_and_back(tmp_path):
    """ "X5000/Y500@6500$": Y has a tenth of the pulses of X, at a tenth of the speed, in the same time."""
    session = perform(10, "V62", tmp_path, line="9600 8N2")
    assert session.moves() == [*FORTH_AND_TEN_TIMES_BACK_AND_FORTH, {"X": 5000, "Y": 500}, {"X": -5000, "Y": -500}]
    assert [max(session.controller.axes[axis].train.move.profile.rates) for axis in "XY"] == [6500, 650]
    assert_no_complaint(session)


@pytest.mark.slow
def test_sample_11_ends_with_both_axes_at_the_same_speed(tmp_path):
    session = perform(11, "V61", tmp_path, line="2400 8N2")
    assert session.moves() == [
        *({"X": 1000}, {"Y": 1000}, {"X": -1000}, {"Y": -1000}),
        *({"X": 5000, "Y": 5000}, {"X": -5000, "Y": -5000}),
    ]
    assert_no_complaint(session)


# Programs that install a sequence and go away

SINGLY = [{"X": 1000}, {"X": -1000}, {"Y": 1000}, {"Y": -1000}, {"Z": 1000}, {"Z": -1000}]
PASSES = {
    3: [*SINGLY, *(together(*signs) for signs in ("+++", "-++", "---", "---"))],
    6: [*SINGLY, *(together(*signs) for signs in ("+++", "-+ ", "--+", "--+", "---"))],
    9: [*SINGLY, *(together(*signs) for signs in ("+++", "-++", "--+", "---"))],
}
"""The moves of one pass through the sequence that each program sends, with the signs that are printed."""
ON_AND_OFF = [*((output, True) for output in (1, 2, 3, 4, 5)), *((output, False) for output in (5, 4, 3, 2, 1))]
"""What one pass does to the outputs: each on after a move, and off again after a later one."""


def one_pass(session: Session) -> list[tuple[int, bool]]:
    """Set input 1 high, and low again during the first pass; return the changes of the outputs."""
    changes: list[tuple[int, bool]] = []
    pins = session.controller.pins
    unwatch = [pins[f"output{n}"].subscribe(lambda pin, n=n: changes.append((n, pin.level))) for n in range(1, 6)]
    pins["input1"].drive(True)
    session.bench.run(1.0)
    pins["input1"].drive(False)
    session.bench.run(60.0)
    for end in unwatch:
        end()
    return changes


def assert_repeats_for_ever(program: int, session: Session) -> None:
    """Assert that with input 1 high the sequence repeats the same pass again and again."""
    session.controller.pins["input1"].drive(True)
    session.bench.run(600.0)
    moves = session.moves()
    assert len(moves) > 10 * len(PASSES[program])
    assert moves == [move for move, _ in zip(itertools.cycle(PASSES[program]), moves, strict=False)]


@pytest.mark.parametrize(("program", "form", "line"), [(3, "V61", "1200 8N2"), (9, "U61", "2400 8N2")])
def test_the_sequence_waits_for_input_1_and_repeats_for_ever(program, form, line, tmp_path):
    session = perform(program, form, tmp_path, line=line)
    session.bench.run(10.0)
    assert session.ask("E") == "E"  # E: busy, because it waits
    assert session.moves() == [] and one_pass(session) == ON_AND_OFF
    assert session.moves() == PASSES[program]
    assert_no_complaint(session)
    assert_repeats_for_ever(program, session)


@pytest.mark.slow
def test_sample_6_leaves_an_if2_with_a_locked_sequence_that_power_up_starts(tmp_path):
    """5-wire: DSR is a line of the host.  If DSR is low, a locked IF2 runs its sequence at power-up."""
    session = perform(6, "V61", tmp_path, model="if2", line="2400 8N2")
    session.bench.run(10.0)
    assert (session.ask("E"), session.ask("F")) == ("[", "32") and one_pass(session) == ON_AND_OFF

    session.controller.serial.host.dtr = False
    session.controller.power_cycle()
    session.bench.run(5.0)
    assert session.moves() == PASSES[6]
    assert_repeats_for_ever(6, session)

    session.controller.serial.host.dtr = True
    assert session.ask("X9$") == "" and session.ask("E") == "["
    session.ask("]")
    session.ask("#")
    session.bench.run(2.0)
    assert session.ask("E") == "C"
