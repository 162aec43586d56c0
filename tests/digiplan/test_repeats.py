"""Sequence mode: repeating parts of a sequence."""

from axistwin.core.units import S

from ..scripts import scripts
from .talking import OWN_TIME_NS, edges, gaps, moves, play, times


@scripts({
    'Repeating: "Up to 255 repeats can be specified, so the same move ... can be performed 256 times"':
    ":X3@400:=255,1:$; idle; at 768 0 0; N: 3",
    "Repeating: up to 255; R35: 256 is out of range": ":X3@400:=256,1:$; 1 s; at 0 0 0; K: 128; F: 16",
    "Repeating: each pass of the second repeat begins the first repeat again":
    ":X1@400:=2,1:=3,1:$; idle; at 12 0 0",
    "Repeating, format: high levels, low levels, repeat data":
    "input1 low; input3 high; :X10@400:H1L3=1,1:$; 0.5 s; input3 low; 0.5 s; at 10 0 0; input1 high; "
    "0.5 s; at 20 0 0; E: C",
    'Programming a sequence: "the whole sequence can be repeated"':
    ":X2@400:=4,1:$; idle; at 10 0 0; :$; idle; at 20 0 0; :$; idle; at 30 0 0; :$; idle",
    # per Z: two Y; per Y: three X.  Four Z.
    'Repeating: "nesting repeats within the sequence", three levels; an outer pass restarts the inner repeats':
    ":X1@400:=2,1:Y1:=1,1:Z1:=3,1:$; idle; at 24 8 4",
    # X Y X Y Z; from step 2: Y; the first repeat begins again and goes back to step 1: X Y; Z
    "Repeating: the second repeat begins in the middle of the first one's steps":
    ":X1@400:Y1:=1,1:Z1:=1,2:$; idle; at 3 4 2",
    # cancelled in the middle of the Y move
    'Repeating: "Once a sequence has been terminated, it can only be restarted from the beginning"; R14: by `:$`':
    ":X1000@400:Y:X-:Y-:=0,1:$; 3.5 s; #; 0.1 s; X at 1000; Y between 350 450; :$; 2.55 s; X at 2000; "
    "Y between 350 549; O: 2",
    'R14: the manual\'s ":% <CR>" is a misprint: `%` means "wait for control", and this message is unfinished':
    ":X10@400:$; idle; :%; 1 s; at 10 0 0",
    'Repeating: ":H1" first: "will only continue to repeat if input 1 is high ... always stop at the origin"':
    "input1 high;  :H1: X 1000 @ 400 : Y : X- : Y- : = 0, 1 : $; 23 s; input1 low; 50 s; at 0 0 0; "
    "X moves 1000 -1000 1000 -1000 1000 -1000; E: E; K: 0; O: 1; input1 high; 4.9 s; X at 1000; Y between 901 1000",
    'Repeating: "restarted from step 1", with all passes, after a cancel in the second of five passes':
    "input1 high; :H1X100@400:=4,1:$; 0.4 s; input1 low; 0.5 s; at 200 0 0; #; input1 high; :$; idle; at 700 0 0",
    "Repeating a delay: 4 x 256 times 990 ms, about 17 minutes, are exact but for the interface's own time":
    ":S1:P0,99:=255,2:=3,2:R1:$; 1020 s; output1 high for 1013760 to 1014789 ms",
    "R35: a step m that is not 1 to 63, or not yet defined, sets F 16, and the sequence is dropped":
    ":X3@400:={1,0|1,64|1,3|0,9}:Y4:$; 1 s; at 0 0 0; K: 128; F: 16",
    "Repeating an empty step for ever takes time, and the cancel code ends it":
    "input1 high; input2 low; :{=0,1|S1:=0,1|X0:=0,1|X:Y:=0,1|=255,1:=255,1:=255,1:=0,1|B+5:R1:=0,2|H1:L2:=0,1|"
    "A:=0,1}:$; 2 s; E: E; #; 0.1 s; E: C; X5@400$; idle; at 5 0 0",
})  # fmt: skip
def test_repeated_steps(bench, if1, script):
    play(bench, if1, script)


def test_x_and_y_are_moved_six_times_and_then_the_output_is_reset(bench, if1):
    """Repeating: "repeated five times from step 2 ... giving a total of six X moves and six Y moves"."""
    # 12 moves of 400 steps at 100 steps/s; S1 and six times `=` take only the interface's own time
    play(bench, if1, " : S1 : X 400 @ 100 : Y : = 5, 2 : R1 : $; idle; output1 high for 48000 to 48007 ms")
    assert moves(if1.axes["X"]) == moves(if1.axes["Y"]) == [400] * 6
    first = [(at_ns, axis) for axis in "XY" for at_ns in times(if1.axes[axis])[::400]]
    assert [axis for _, axis in sorted(first)] == ["X", "Y"] * 6


def test_nested_repeats(bench, if1):
    """Repeating: six X and six Y moves, Z 50, then "the entire sequence is repeated from step 1 a further 24 times"."""
    out = edges(if1.pins["output1"])
    # 24 x 48.5 s + 48.5 s and the interface's own time; 150 x 400, 150 x 400, 25 x 50
    play(bench, if1, " : S1 : X400 @ 100 : Y : = 5, 2 : R1 : Z50 : = 24, 1 : $; 1213 s; idle; at 60000 60000 1250")
    assert moves(if1.axes["X"]) == moves(if1.axes["Y"]) == [400] * 150 and moves(if1.axes["Z"]) == [50] * 25
    assert [level for _, level in out] == [True, False] * 25
    passes = gaps(at_ns for at_ns, _ in out)[1::2]
    assert all(S // 2 <= length <= S // 2 + 2 * OWN_TIME_NS for length in passes)  # Z: 50 steps at 100 steps/s


def test_zero_repeats_for_ever_until_it_is_cancelled(bench, if1):
    """Repeating: "it will continue round until the cancel code "# <CR>" is sent"."""
    play(bench, if1, " : X 1000 @ 400 : Y : X- : Y- : = 0, 1 : $; 1000 s; E: E")  # one pass takes 10 s
    assert len(moves(if1.axes["X"])) in (199, 200, 201)
    play(bench, if1, "#; 0.1 s; E: C; mark; 100 s; moved 0 0 0")


def test_a_repeat_can_wait_for_an_input_at_each_repetition(bench, if1):
    """Repeating: ": H2 = 10, 4 :" "would repeat ... ten times from step 4, with each repetition waiting"; R15."""
    play(bench, if1, "input2 low; :Y1@400:Y1:Y1:X10:Z1:H2=10,4:Y1:$; 1 s")
    for passes in range(1, 12):
        here = f"at {10 * passes} 3 {passes}"  # within 0.01 s the X move has begun: 10 steps at 400 steps/s
        play(bench, if1, f"{here}; E: E; 1 s; {here}; input2 high; 0.01 s; input2 low; 1 s")
    # R15: the eleventh repetition, after which the sequence continues, has waited too
    play(bench, if1, "at 110 4 11; E: C")
