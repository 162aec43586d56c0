"""The numbers of the manual's examples; the fidelity report lists expected and obtained values."""

from itertools import pairwise

import pytest

from axistwin.core.units import MS

from .talking import ask, command, edges, moves, number, play, positions, ready, status, times, write


def running(bench, if1, words, axis="X"):
    """Return the speed of a run, three seconds after its command."""
    command(bench, if1, f"{words}{axis}G$", seconds=3)
    return float(if1.axes[axis].velocity)


@pytest.mark.parametrize(("speed", "final"), [
    (503, 500.0), (504, 506.25), (21, 18.75), (22, 25.0), (1, 6.25), (8, 6.25), (5400, 5400.0)])  # fmt: skip
def test_a_speed_within_the_resolution(bench, if1, printed, speed, final):
    """Speed: "programming a speed of 503 steps/sec in range 1 will give a final speed of 500 steps/sec"."""
    printed("Speed", f"{speed} steps/sec programmed in range 1, steps/sec", final, running(bench, if1, f"@{speed}"))


def test_99999_in_range_3(bench, if1, printed):
    """Speed: 99,999 steps/sec "will result in a speed of 100,000 steps/sec due to the 25 s/s resolution"."""
    command(bench, if1, ">3 ^500", seconds=1.2)
    printed("Speed", "99,999 steps/sec in range 3, steps/sec", 100_000.0, running(bench, if1, "@99999"))


def test_all_parameters_in_one_message(bench, if1, printed):
    """Acceleration rate: ">1 <10 ^15 @ 4800": start/stop 1000, acceleration 15,000, speed 4800."""
    play(bench, if1, ">1 <10 ^15 @ 4800; 1.2 s; X20000$; idle")
    at = times(if1.axes["X"])
    printed("Acceleration rate", "<10: interval of the first pulses, ns", MS, at[1] - at[0])
    fastest = min(after - before for before, after in pairwise(at))
    printed("Acceleration rate", "@ 4800: shortest interval, ns", 1e9 / 4800, fastest, within=1)
    # From 1000 to 4800 at 15,000 steps/sec²: 38 levels of 100 steps/sec, 1/150 s each
    top = next(n for n, (a, b) in enumerate(pairwise(at)) if b - a <= fastest + 1)
    printed(
        "Acceleration rate", "^15: seconds from 1000 to 4800 steps/sec", 3800 / 15_000, (at[top] - at[0]) / 1e9, 0.002
    )


def test_start_stop_1200(bench, if1, printed):
    """Start/stop speed: "<12" "will set the start/stop rate at 1200 steps/sec in speed range 1"."""
    play(bench, if1, "<12; 1.2 s; X3000@2000$; idle")
    at = times(if1.axes["X"])
    printed("Start/stop speed", "<12: interval of the first pulses, ns", 1e9 / 1200, at[1] - at[0], within=1)


def test_backlash_of_20_steps(bench, if1, printed):
    """Backlash correction: "the motor will run 120 steps in the positive direction, then reverse and move back 20"."""
    play(bench, if1, "B - 20; X 100 B $; idle")
    printed("Backlash correction", "B - 20, X 100 B: steps out and back", [120, -20], moves(if1.axes["X"]))


def test_a_reversal_takes_3_ms(bench, if1, printed):
    """Backlash correction: the motor reverses after "at least 3mS"; here those 3 ms and a period of 1/400 s."""
    play(bench, if1, "B - 20; X 100 B $; idle")
    at = times(if1.axes["X"])
    printed("Backlash correction", "from the last step out to the first step back, ms", 5.5, (at[120] - at[119]) / 1e6)


def test_a_pulse_of_200_ms(bench, if1, printed):
    """Output switching: "P4, 20 $" "will generate a pulse 200mS long on output 4"."""
    out = edges(if1.pins["output4"])
    command(bench, if1, "P4, 20 $", seconds=1)
    (on, up), (off, down) = out
    assert up and not down
    printed("Output switching commands", "P4, 20: length of the pulse, ns", 200 * MS, off - on)


def test_an_inter_character_delay_of_50_ms(bench, if1, printed):
    """Inter-character delay: "D5" "will set a minimum delay of 50mS"."""
    assert ask(bench, if1, "D5", 1.2) == b""
    write(if1, "N")
    assert bench.run_until(lambda: if1.serial.pending == 0, 1)
    started, received = bench.now, []
    while len(received) < 2 and bench.now < started + 1000 * MS:
        bench.run(0.0005)
        received += [bench.now] * len(if1.serial.read())
    gap = (received[1] - received[0]) / 1e6
    # ... and the 11 bits of the character itself at the host's baud rate
    printed(
        "Inter-character delay", "D5: from character to character, ms", 50 + 11_000 / if1.serial.host.baudrate, gap, 1
    )


def test_a_sequence_of_six_and_six_moves(bench, if1, printed):
    """Repeating: "giving a total of six X moves and six Y moves"."""
    play(bench, if1, ": S1 : X 400 @ 100 : Y : = 5, 2 : R1 : $; idle")
    found = [len(moves(if1.axes[axis])) for axis in "XY"]
    printed("Repeating parts of a sequence", "= 5, 2: moves of X and Y", [6, 6], found)
    printed("Repeating parts of a sequence", "= 5, 2: where X, Y and Z stand", (2400, 2400, 0), positions(if1))


def test_nested_repeats(bench, if1, printed):
    """Repeating: "the Z motor runs for 50 steps and then the entire sequence is repeated ... a further 24 times"."""
    play(bench, if1, ": S1 : X400 @ 10000 : Y : = 5, 2 : R1 : Z50 : = 24, 1 : $; 200 s; idle")
    made = [len(moves(if1.axes[axis])) for axis in "XYZ"]
    printed("Repeating parts of a sequence", "= 24, 1: moves of X, Y and Z", [150, 150, 25], made)


def test_a_square(bench, if1, printed):
    """Programming a sequence: "four moves which cause an X-Y system to describe a square"."""
    play(bench, if1, ": X 1000 @ 200 : Y : X- : Y- : $; idle")
    found = [moves(if1.axes[axis]) for axis in "XY"]
    printed("Programming a sequence", "the moves of X and of Y", [[1000, -1000], [1000, -1000]], found)


def test_a_delay_of_500_ms(bench, if1, printed):
    """Adding time delays: "The interface will wait for 500mS after the X move"."""
    play(bench, if1, ": X 1000 P0, 50 : Y 100 @ 100 : $; idle")
    gap = (times(if1.axes["Y"])[0] - times(if1.axes["X"])[-1]) / 1e6
    # Y's first pulse comes a period of 10 ms after its start; a step takes 1 ms of the interface's time
    printed("Adding time delays", "P0, 50: from the end of X to the begin of Y, ms", 500 + 10, gap, within=2)


@pytest.mark.parametrize(("words", "steps", "speeds"), [
    ("X 2000 / YZ 500 @ 1000 $", (2000, 500, 500), {"X": 1000, "Y": 250, "Z": 250}),
    ("XY 1000 / Z 50 @ 800 $", (1000, 1000, 50), {"X": 800, "Y": 800, "Z": 40})])  # fmt: skip
def test_an_interpolated_move(bench, if1, printed, words, steps, speeds):
    """Duplicating: "X axis to move 2000 steps at a speed of 1000 steps/sec, and both Y and Z axes ... at 250"."""
    command(bench, if1, words, seconds=0.7)
    found = {axis: float(if1.axes[axis].velocity) for axis in speeds}
    printed("Linear interpolation mode", f"{words}: steps/sec", speeds, found)
    play(bench, if1, "idle")
    printed("Linear interpolation mode", f"{words}: steps", steps, positions(if1))


def test_a_speed_beyond_the_constraints(bench, if1, printed):
    """Constraints: "k <CR> = 128, F <CR> = 16" beyond 10,000 steps/sec."""
    command(bench, if1, "X20000/Y500@10001$", seconds=0.5)
    printed("Constraints in linear interpolation mode", "10,001 steps/sec: K", 128, number(bench, if1, "K"))
    printed("Constraints in linear interpolation mode", "10,001 steps/sec: F", 16, number(bench, if1, "F"))


def test_an_emergency_stop_is_asked_for_three_times(bench, if1, printed):
    """Clearing fault conditions: K is "32", "32" again once the emergency stop has been removed, then "0"."""
    play(bench, if1, "estop low; 0.1 s")
    first = number(bench, if1, "K")
    play(bench, if1, "estop high")
    found = [first, number(bench, if1, "K"), number(bench, if1, "K")]
    printed("Clearing fault conditions", "an emergency stop: K before, after, and once more", [32, 32, 0], found)


def test_an_emergency_stop_that_decelerates(bench, if1, printed):
    """Motion status: "41 would indicate the interface has had an emergency stop and is decelerating"."""
    play(bench, if1, "^1 X20000 @ 4000 $; 8 s; estop low; 0.05 s")
    printed("Motion status", "emergency stop, decelerating, in motion: K", 41, number(bench, if1, "K"))


def test_quick_status_of_a_limit_while_decelerating(bench, printed):
    """Quick status: "a single byte of value 73 decimal or 49 hex" means limit, decelerating, in motion."""
    if1 = ready(bench, message="U37")
    play(bench, if1, "^1 X20000 @ 4000 $; 8 s; limit_plus low")
    printed("Quick status", "a limit whilst decelerating: the byte", 73, ask(bench, if1, "Q", 0.1)[0])


def test_the_distance_that_is_reported(bench, if1, printed):
    """Position report-back: " 527" "steps were sent to the motor by the time it came to rest"."""
    play(bench, if1, "X527@400$; idle")
    printed("Position report-back", "527 steps were sent: N", "527", status(bench, if1, "N"))
    assert positions(if1) == (527, 0, 0)
