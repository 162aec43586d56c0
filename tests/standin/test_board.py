"""The class KlipperBoard connected to a simulated board, in virtual time."""

import random
import re

import numpy as np
import pytest

from axistwin.core.errors import UsageError
from axistwin.real.standin.board import State
from axistwin.real.standin.dictionary import Dictionary
from axistwin.real.standin.events import Failed, InputChanged, Ready, Stopped
from axistwin.real.standin.wiring import AxisPins, BoardPin, InputPin, Wiring

from .metal import INPUT, LIMIT, TICK_S, Metal, X, Y
from .small_board import DESCRIBED, SmallBoard


def kinds(metal, kind):
    return [event for event in metal.events if isinstance(event, kind)]


def test_the_board_makes_the_queued_pulses_at_their_times():
    metal = Metal().start()
    times = metal.even(2000, 4000)
    metal.move("table.X", +1, times)
    assert [direction for _, direction in metal.small.pulses[2]] == [+1] * 2000
    assert np.abs(metal.errors_us(2, times)).max() < 25 and not kinds(metal, Stopped)
    assert sum(line.startswith("pulses") for line in metal.lines) < 600


@pytest.mark.parametrize(("pause_s", "stopped"), [(0.45, False), (0.55, True)])
def test_a_pause_of_the_program_within_the_horizon_stops_no_motor(pause_s, stopped):
    """The sender goes on, but receives no pulses for this time; the horizon is 0.5 s."""
    metal = Metal(horizon_s=0.5, watchdog_s=0.5).start()
    times, begin, sent = metal.even(4000, 2000), metal.now + 0.7, [0]

    def each(now):
        upto = int(np.searchsorted(times, now))
        if not begin < now < begin + pause_s and upto > sent[0] and round(now / TICK_S) % 5 == 0:
            metal.board.queue("table.X", +1, times[sent[0] : upto])
            sent[0] = upto

    metal.run(3.0, each)
    made = len(metal.small.pulses[2])
    if stopped:
        [stop] = kinds(metal, Stopped)
        assert stop.reason.startswith("late by ") and stop.reason.endswith(" with a horizon of 500 ms")
        assert stop.positions["table.X"] == made
        assert 1380 <= made <= 1400  # those of the 0.7 s before, but perhaps the last block of 10 ms
    else:
        assert not kinds(metal, Stopped) and made == 4000
        assert np.abs(metal.errors_us(2, times)).max() < 25


def test_a_change_of_direction_and_an_inverted_pin():
    metal = Metal().start()
    metal.move("table.Y", +1, metal.even(30, 1000))
    metal.move("table.Y", -1, metal.even(50, 1000))
    assert [direction for _, direction in metal.small.pulses[5]] == [-1] * 30 + [+1] * 50
    metal.board.stop("the user")
    metal.run(0.2)
    assert kinds(metal, Stopped) == [Stopped("the user", {"table.X": 0, "table.Y": -20})]


@pytest.mark.parametrize("drift", [-200e-6, 200e-6])
def test_a_drifting_clock(drift):
    metal = Metal(SmallBoard(drift)).start()
    times = metal.even(1000, 250)
    metal.move("table.X", +1, times)
    assert len(metal.small.pulses[2]) == 1000 and np.abs(metal.errors_us(2, times)).max() < 25


class LateResponses(SmallBoard):
    """A board whose responses take up to half a millisecond longer, and once 60 ms longer."""

    def responses(self, now):
        if 10.3 < now < 10.36:
            return []
        return [(now + random.Random(now).uniform(0, 0.0005), self.transmitted())]


def test_late_responses_do_not_delay_the_start():
    """The clock's line is fitted to 40 samples at intervals of 20 ms, with one pause of 60 ms."""
    metal = Metal(LateResponses()).start(1.1)
    assert metal.board.connection.clock.error_s < 50e-6
    times = metal.even(1000, 250)
    metal.move("table.X", +1, times)
    assert np.abs(metal.errors_us(2, times)).max() < 50


@pytest.mark.parametrize("seed", range(4))
def test_a_bad_cable_loses_no_pulse(seed):
    rng = random.Random(seed)

    def wire(data):
        if rng.random() > 0.01 or not data:
            return data
        at = rng.randrange(len(data))
        return data[:at] + (b"", bytes([data[at] ^ 4]), data[at : at + 1] * 2)[rng.randrange(3)] + data[at + 1 :]

    metal = Metal(wire=wire).start()
    metal.move("table.X", +1, metal.even(3000, 4000))
    metal.move("table.X", -1, metal.even(1000, 1000))
    stops = kinds(metal, Stopped)
    made = [direction for _, direction in metal.small.pulses[2]]
    assert made == [+1] * 3000 + [-1] * 1000 if not stops else stops[0].reason
    assert metal.board.connection.channel.again > 0


@pytest.mark.parametrize("at", [1, 17, 400, 1999])
def test_a_limit_stops_the_motion_in_the_board(at):
    metal = Metal().start()
    board, small = metal.board, metal.small
    times = metal.even(2000, 4000)

    def open_limit():
        small.levels[8] = 0
        open_limit.made = len(small.pulses[2])

    opens = times[at - 1] + board.horizon_s + 10e-6
    small.at(small.start + round(opens * small.hz), open_limit)
    metal.move("table.X", +1, times)
    assert len(small.pulses[2]) - open_limit.made <= 1
    [stopped] = kinds(metal, Stopped)
    assert stopped.by == "table.limit_plus" and stopped.positions["table.X"] == len(small.pulses[2])
    changed = next(event for event in kinds(metal, InputChanged) if event.to == "table.limit_plus")
    assert changed.level is False and abs(changed.at_s - opens) < TICK_S


def test_an_axis_moves_away_from_an_open_limit_and_is_stopped_by_the_limit_again():
    metal = Metal().start()
    metal.small.levels[8] = 0
    metal.run(0.2)
    metal.board.resume("table")
    metal.move("table.X", -1, metal.even(50, 1000))
    assert len(metal.small.pulses[2]) == 50
    metal.small.levels[8] = 1
    metal.run(0.2)
    metal.move("table.X", +1, metal.even(20, 1000))
    metal.small.levels[8] = 0
    metal.run(0.2)
    assert [event.level for event in kinds(metal, InputChanged)] == [False, True, False]


def test_motion_towards_an_open_limit_is_refused():
    metal = Metal().start()
    metal.small.levels[8] = 0
    metal.run(0.2)
    metal.board.resume("table")
    metal.move("table.X", +1, metal.even(50, 1000))
    assert metal.small.pulses[2] == []
    assert kinds(metal, Stopped)[-1].reason == "table.X: table.limit_plus is open: no motion in this direction"


def test_changes_of_inputs_have_the_time_of_the_board():
    metal = Metal().start()
    opens = metal.now + 0.0123
    metal.small.at(metal.small.start + round(opens * metal.small.hz), lambda: metal.small.levels.update({9: 0}))
    metal.run(0.2)
    metal.small.levels[9] = 1
    metal.run(0.2)
    first, second = kinds(metal, InputChanged)
    assert (first.to, first.level, second.level) == ("table.input1", True, False)
    assert abs(first.at_s - opens) < 2 * TICK_S


def test_without_commands_the_board_stops_the_motors_and_switches_the_drives_off():
    metal = Metal(horizon_s=0.5).start()
    small, times = metal.small, metal.even(8000, 4000)
    metal.run(0.1)
    assert small.levels[4] == 0  # low is enabled: the output is inverted

    def die(now):
        metal.alive = metal.alive and now < times[0] + 1.0

    died = times[0] + 1.0
    metal.run(0.0)
    sent = 0

    def each(now):
        nonlocal sent
        die(now)
        upto = int(np.searchsorted(times, now))
        if metal.alive:
            metal.board.queue("table.X", +1, times[sent:upto])
            sent = upto

    metal.run(3.0, each)
    assert small.time_s(small.pulses[2][-1][0]) - died < 0.12
    assert small.levels[4] == 1 and small.shutdown


def test_the_user_continues_after_a_shutdown():
    metal = Metal().start()
    metal.move("table.X", +1, metal.even(100, 1000))
    metal.alive = False
    metal.run(0.3)
    metal.alive = True
    metal.run(0.1)
    assert kinds(metal, Failed) == [Failed("the board has stopped: Missed scheduling of next digital out event")]
    metal.board.restart(metal.now)
    metal.run(2.0)
    assert kinds(metal, Ready)[-1].positions == {"table.X": 100, "table.Y": 0}
    metal.move("table.X", -1, metal.even(40, 1000))
    assert len(metal.small.pulses[2]) == 140


def test_after_a_reset_of_the_board_the_position_is_unknown():
    metal = Metal().start()
    metal.small.off()
    metal.board.fail("unplugged")
    metal.board.restart(metal.now)
    metal.run(1.0)
    assert kinds(metal, Failed)[-1].reason.startswith("the board was reset, so its positions are unknown")


def test_late_pulses_stop_the_motors_with_a_reason():
    metal = Metal().start()
    metal.move("table.X", +1, metal.even(100, 1000))
    metal.board.queue("table.X", +1, metal.even(100, 1000) - 0.15)
    metal.run(0.2)
    [stopped] = kinds(metal, Stopped)
    assert re.fullmatch(r"late by 6\d ms, with a horizon of 100 ms", stopped.reason)
    assert stopped.positions["table.X"] == len(metal.small.pulses[2]) == 100


@pytest.mark.parametrize(("limits", "reason"), [
    ({"max_rate": 900}, "table.X: 1000 pulses/s is above max_rate 900"),
    ({"travel": (-10, 20)}, "table.X: position 21 is beyond travel [-10, 20]")])  # fmt: skip
def test_limits_are_checked_before_pulses_are_sent(limits, reason):
    metal = Metal(axes=(AxisPins("table.X", X.step, X.direction, X.enable, **limits),)).start()
    metal.board.queue("table.X", +1, metal.even(21, 1000))
    metal.run(0.3)
    assert metal.small.pulses[2] == [] and kinds(metal, Stopped)[0].reason == reason


def test_commands_are_sent_only_if_the_board_has_room():
    metal = Metal(SmallBoard(moves=32)).start()
    rng = random.Random(1)
    times = metal.now + np.cumsum([rng.uniform(0.0005, 0.005) for _ in range(300)])
    metal.move("table.X", +1, times)
    assert len(metal.small.pulses[2]) == 300


def test_outputs_change_one_horizon_later():
    metal = Metal().start()
    metal.board.set_output("table.output1", True, metal.now)
    metal.run(0.09)
    assert metal.small.levels[10] == 0
    metal.run(0.02)
    assert metal.small.levels[10] == 1


def test_a_board_that_never_answers():
    metal = Metal(wire=lambda data: b"")
    metal.run(6.0)
    assert metal.board.state is State.FAILED and kinds(metal, Failed)[0].reason.startswith("the board does not answer")


def test_a_board_with_another_configuration():
    small = SmallBoard()
    small.configured, small.crc = True, 7
    metal = Metal(small)
    metal.run(1.0)
    expected = "the board is configured for another scene: press its reset button, then try again"
    assert kinds(metal, Failed) == [Failed(expected)]


def test_a_queue_that_is_too_small():
    metal = Metal(SmallBoard(moves=20))
    metal.run(1.0)
    assert kinds(metal, Failed)[0].reason == (
        "the board can queue only 20 moves: expected at least 31 (12 for each axis, 1 for each output, 6 in reserve)"
    )


@pytest.mark.parametrize(("axes", "inputs", "message"), [
    ((X, Y), (InputPin("table.input1", BoardPin("P2")),),
     "pin P2 is used for table.X step and for table.input1 input: choose another pin for one of them"),
    ((AxisPins("table.X", X.step, X.direction),), (), "table.X has no enable pin"),
    (
        (X,),
        (InputPin("other.limit", BoardPin("P9"), stops=0),),
        "wired to the wrong board: expected the same board as for the axes of the controller other",
    )])  # fmt: skip
def test_conflicts_of_the_wiring(axes, inputs, message):
    with pytest.raises(UsageError, match=message):
        Wiring("small", axes, inputs).check()


@pytest.mark.parametrize(("pin", "message"), [
    ("P77", "the board has no pin P77 for table.input2 input: expected one of P0, P1"),
    ("P0", "is reserved for serial: choose another pin")])  # fmt: skip
def test_pins_that_the_board_lacks_or_reserves(pin, message):
    wiring = Wiring("small", (X,), (INPUT, InputPin("table.input2", BoardPin(pin)), LIMIT))
    with pytest.raises(UsageError, match=message):
        wiring.check_pins(Dictionary(DESCRIBED))


@pytest.mark.parametrize("text", ["", "!", "P 1", "!^P1", "P1 "])
def test_invalid_pins(text):
    with pytest.raises(UsageError, match="expected the name of a board's pin"):
        BoardPin.read(text)
