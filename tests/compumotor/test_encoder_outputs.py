"""Specifications, ENCODER connector: channel Z from the plant's encoder, STEP OUT and DIRECTION OUT (1811)."""

import pytest

from axistwin.bench import terminals
from axistwin.core.errors import UsageError
from axistwin.plant.switches import PositionSwitch, in_series

from ..scripts import scripts
from .scripts import play
from .talking import ask, complete, default, i32, position, ready, send, send_all, until_idle

ENCODER = {"counts_per_rev": 4000, "pulses_per_rev": 25_000}  # 0.16 counts a pulse
AT_ONCE = 0x7FFF_FFFF


def encoder_board(bench, model="1811", encoder=ENCODER, **options):
    board = ready(bench, model, motor={"encoder": encoder}, **options)
    default(bench, board, 1_000, AT_ONCE)
    return board


def go(bench, board, pulses):
    complete(bench, board, 0x33, *i32(pulses))


# Channel Z


@scripts({
    'Encoder interface: "gives its home indication once per revolution": one count wide, i.e. pulses 0 to 6':
    "1811 motor={'encoder':{'counts_per_rev':4000,'pulses_per_rev':25000}}; default 1000 at_once; 33 ={6|7|24999|"
    "25000|25006|25007|-1}; idle; channel_z is {high|low|low|high|high|low|low}; 96 -> {FF|00|00|FF|FF|00|00}",
    "a mark elsewhere and wider: a mark on counts 10 to 12 begins at pulse 63 and ends at pulse 81 (62.5 to 81.25)":
    "1811 motor={'encoder':{'counts_per_rev':4000,'pulses_per_rev':25000,'index':10,'index_counts':3}}; "
    "default 1000 at_once; 33 =62; idle; channel_z is low; 33 =1; idle; channel_z is high; 33 =18; idle; "
    "channel_z is high; 33 =1; idle; channel_z is low",
})  # fmt: skip
def test_encoder_outputs(bench, script):
    play(bench, script)


def test_an_encoder_that_is_pushed_or_slips_takes_its_mark_along(bench):
    board = encoder_board(bench)
    encoder, pin = board.axes["motor"].encoder, board.pins["channel_z"]
    seen = []
    pin.subscribe(lambda pin: seen.append(pin.level))
    encoder.displace(5)
    assert not pin.level
    encoder.slip(3995)
    assert pin.level and seen == [False, True]


@pytest.mark.parametrize("counts_per_rev", [4000, -4000])
@pytest.mark.parametrize("backlash", [0, 5])
@pytest.mark.parametrize("way", [+1, -1])
def test_its_edges_come_on_the_very_pulse(bench, counts_per_rev, backlash, way):
    """Reading the pin at each pulse of two revolutions and back finds the same edges as a subscriber receives."""
    encoder = {"counts_per_rev": counts_per_rev, "pulses_per_rev": 100, "backlash": backlash, "index": 7}
    edges = []
    for watched in (False, True):
        board = encoder_board(bench, encoder={**encoder, "index_counts": 40})
        motor, pin, found = board.axes["motor"], board.pins["channel_z"], []
        if watched:
            pin.subscribe(lambda pin, motor=motor, found=found: found.append((motor.position, pin.level)))
        for pulses in (way * 200, -way * 200):
            before = pin.level
            send(bench, board, 0x33, *i32(pulses))
            while not motor.moving:
                bench.run(0.000_1)
            for time_ns in [int(motor.train.move.start_ns + n * 1_000_000) for n in range(1, 201)]:
                bench.run((time_ns + 1_000 - bench.now) / 1e9)
                if not watched and pin.level is not before:
                    before = pin.level
                    found.append((motor.position, before))
            until_idle(bench, board)
        edges.append(found)
    assert edges[0] == edges[1] and len(edges[0]) >= 7


@pytest.mark.parametrize(("final_ccw", "found"), [(0, 25_000), (1, 25_006)])
@pytest.mark.parametrize("minus", [0, 1])
def test_3ah_finds_the_mark_of_the_revolution_that_home_enable_marks(bench, final_ccw, found, minus):
    """3Ah finds the mark at pulses 25,000 to 25,006, around which HOME ENABLE is closed.

    At 50 % of the default velocity each pulse takes 2 ms, and the motor stops on the pulse that begins the mark.
    """
    board = ready(bench, motor={"encoder": ENCODER, "limits": (-1_000, 40_000)})
    in_series([PositionSwitch(board.axes["motor"], 24_000, 26_000)], board.pins["home_enable"])
    default(bench, board, 1_000, AT_ONCE)
    send_all(bench, board, (0x18, 1), (0x38, 1, 0, 50, final_ccw), (0x0F, 3, 2, 1), (0x3A, minus))
    assert bench.run_until(lambda: not board.pins["output1"].level, 100)
    assert board.axes["motor"].position == found and position(bench, board, 0x82) == 0
    assert ask(bench, board, 0x96)[1] == 0xFF


def test_a_mark_that_nobody_waits_for_costs_nothing(bench):
    """If nothing subscribes to channel Z, a motor that runs for ever causes no event at its marks."""
    board = encoder_board(bench)
    send(bench, board, 0x32, 0, seconds=1)
    assert bench.clock.next_event_ns() is None
    end = board.pins["channel_z"].subscribe(lambda pin: None)
    assert bench.clock.next_event_ns() is not None
    end()
    bench.run(26)
    assert bench.clock.next_event_ns() is None


def test_a_mark_is_no_news_in_a_transcript(bench):
    """A transcript lists channel Z only if it is wired by hand, because an encoder changes it each revolution."""
    board = encoder_board(bench)
    assert "channel_z" not in terminals(board)
    board.pins["channel_z"].set(True)
    assert "channel_z" in terminals(board) and "channel_z" in terminals(ready(bench))


def test_who_waits_for_its_next_change_is_told(bench):
    board = encoder_board(bench)
    changed = board.pins["channel_z"].changed()
    assert board.pins["channel_z"].changed() is changed
    go(bench, board, 7)
    assert changed.processed


def test_a_wire_or_a_test_lead_takes_the_place_of_the_encoder(bench):
    board = encoder_board(bench)
    pin = board.pins["channel_z"]
    pin.drive(False)
    assert not pin.level
    pin.release()
    assert pin.level
    pin.set(False)
    go(bench, board, 25_000)
    assert not pin.level


def test_an_1810_has_no_hardware_for_it(bench):
    """96h: "there is no hardware on the board supporting the Z-channel input"."""
    board = encoder_board(bench, "1810")
    assert ask(bench, board, 0x96)[1] == 0 and "encoder_step" not in board.pins


@pytest.mark.parametrize("wrong", [{"index_counts": 0}, {"index_counts": 4000}])
def test_a_mark_is_at_least_a_count_and_less_than_a_revolution(bench, wrong):
    with pytest.raises(UsageError, match="index mark"):
        bench.add("1811", motor={"encoder": {**ENCODER, **wrong}})


# STEP OUT and DIRECTION OUT


def test_step_out_gives_a_pulse_of_229_ns_for_each_count(bench):
    """STEP OUT: "Pulses are nominally 229 nanoseconds wide": pulse 7 makes the first count (7 × 0.16 = 1.12)."""
    board = encoder_board(bench)
    send(bench, board, 0x33, *i32(20))
    assert bench.run_until(lambda: board.axes["motor"].velocity, 1)
    began, pin = board.axes["motor"].train.move.start_ns, board.pins["encoder_step"]
    levels = []
    for time_ns in (6_000_100, 6_999_999, 7_000_000, 7_000_228, 7_000_229, 13_000_000):
        bench.run((began + time_ns - bench.now) / 1e9)
        levels.append(pin.level)
    assert levels == [False, False, True, True, False, True]


@pytest.mark.parametrize("inverted", [False, True])
def test_direction_out_is_the_quadrature_detectors_direction(bench, inverted):
    """DIRECTION OUT: "A jumper on the 1810/11 board inverts the polarity"; a play of 12 pulses delays it."""
    board = encoder_board(bench, encoder={**ENCODER, "backlash": 2}, invert_encoder=inverted)
    pin, levels = board.pins["encoder_direction"], []
    for pulses in (100, -6, -20, 50):
        go(bench, board, pulses)
        levels.append(pin.level is not inverted)
    assert levels == [True, True, False, True]
    board.power(False)
    assert not pin.level and not board.pins["encoder_step"].level


def test_without_an_encoder_there_are_no_pulses(bench):
    board = ready(bench)
    default(bench, board, 1_000, AT_ONCE)
    send(bench, board, 0x32, 0, seconds=0.1)
    assert not any(board.pins["encoder_step"].level for _ in range(5)) and not board.pins["channel_z"].level
