"""Sending basic move instructions: Run mode instructions.

`test_index.py` tests the cancel code in a run, too.
"""

from axistwin.core.units import S

from ..scripts import scripts
from .talking import at_speed, command, play, pulse_times_of, ramped, start_ns, write


def test_the_x_axis_runs_continuously_at_5000(bench, if1):
    """Run mode: ""X @ 5000 G $ <CR>" will run the X axis continuously at 5000 steps/sec"."""
    write(if1, "X @ 5000 G $")
    assert at_speed(bench, if1) == 5000
    bench.run(3600)
    assert if1.axes["X"].velocity == 5000 and if1.axes["X"].position > 18_000_000
    # up: 400 ... 4900, 46 levels of 10 ms: 1219 pulses in 460 ms; then one each 200 us
    begin = start_ns(if1.axes["X"])
    times = [int(time) - begin for time in if1.axes["X"].pulse_times(begin, begin + 2 * S)][:5000]
    assert times[1218] == 460_000_000 and times[1219] == 460_200_000
    assert times == pulse_times_of(ramped(10_000, 400, 5000, 100, 10_000))[:5000]


@scripts({
    'Run mode: ""Y- G $ <CR>" will run the Y axis in the negative direction at the previously-programmed speed"':
    "@250; Y- G $; 30 s; Y runs at -250; #; 0.1 s; Y between -7530 -7450; Y constant at 250",
    "Run mode: `$` stands last": "XG$@300; 1 s; still; K: 128; F: 8",
    'Run mode: "To stop the motor, send the cancel code"; R9: at once, though CTS holds back a reply (R4)':
    "host RTS off; XG$; E; 1 s; moving; #; 1 s; still",
    'Index mode: "More than one axis may be selected"':
    "X+Y-ZG$; 10 s; X runs at 400; Y runs at -400; Z runs at 400; #; 1 s; X like Y; X like Z; N: X; N: Y; N: Z",
    'Run mode: "the interface will default to zero index length", so "the distance MUST be stated"':
    "X70$; XG$; 1 s; #; 0.1 s; mark; X$; Y$; 1 s; moved 0 0 0; X70$; 1 s; moved 70 0 0",
    "Busy status and motion status: running at speed is 1 + 2": "XG$; 0.1 s; E: E; K: 3",
    'Run mode: "the axis to be moved is selected as before", and then comes G; digest: "after axis/speed"':
    "GX$; 0.2 s; still; K: 128; F: 8; G$; 0.2 s; still; K: 128; F: 8; @500G$; 0.2 s; still; K: 128; F: 8",
    "Run mode: after `#` a run in the other direction begins when the motor is at rest":
    "XG$; 1 s; #; X-G$; 1 s; X runs at -400; #; 1 s; still",
    'Speed: "Speeds between 1 and 8 steps/sec will run at 6.25": one pulse each 160 ms':
    "X@1G$; 16 s; X constant at 6.25; X between 99 100",
    'Run mode: "no distance is programmed and the Go command "G" is included"':
    "{XG@300|X@300G|@300XG|X+G@300}$; 1 s; X runs at 300",
    'Run mode: "the distance MUST be stated in a subsequent index instruction", both distances of an interpolation':
    "X200/Y100@400$; 1 s; {X@400G|X/Y@400G|:X@400G:P0,5:A:}$; 0.3 s; #; 0.3 s; X between 201 1000; mark; Z-$; "
    "0.5 s; X/Y$; 0.5 s; moved 0 0 0; X50/Y$; 0.5 s; moved 50 0 0; X/Y25$; 0.5 s; Z$; 0.5 s; moved 100 25 50; F: 0",
    'Run mode: the data are lost "if the run mode is used"; a run that is refused does not count':
    "X50$; 0.3 s; limit_plus low; 0.1 s; K?; XG$; 0.1 s; K?; X-$; 0.3 s; X at 0",
})  # fmt: skip
def test_run_mode(bench, if1, script):
    play(bench, if1, script)


def test_after_an_interpolated_run_the_index_lengths_are_zero(bench, if1):
    """Run mode: "the data used in a previous index will be lost if the run mode is used"."""
    command(bench, if1, "X2000/Y500@400G$", seconds=1.0)
    command(bench, if1, "#", seconds=0.1)
    x, y = if1.axes["X"].position, if1.axes["Y"].position
    assert (x > 0, 0 <= x - 4 * y < 4) == (True, True)  # the ratio of the lengths is the ratio of the speeds
    play(bench, if1, "X$; 1 s; X/Y$; 1 s; moved 0 0 0; F: 0; X/YG$; 0.2 s; F: 16")  # there is no ratio left
