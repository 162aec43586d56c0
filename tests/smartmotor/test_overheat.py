"""The fault Bh: a controller that is too hot (TH, THD), or a current too large for too long; 2, 4 and 5.2."""

from functools import partial
from itertools import pairwise

from axistwin import Bench
from axistwin.bench import Controller

from . import talking
from .bits import BA, BH, BI, BO, BX
from .scripts import play, scripts
from .talking import UNIT, advance, ask, ready, send

status_word = partial(talking.status_word, ignored=BI | BX | BA)
MOVE = f"A={UNIT} V={10 * UNIT} MV G"


def temperature(bench: Bench, motor: Controller) -> int:
    return int(ask(bench, motor, "PRINT(TEMP,#13)"))


@scripts({
    'Table 4.1: "Controller temperature exceeded temperature limit"; TH is 70 at power-up':
    [f"air {celsius}; 3.1 s; TEMP is {celsius}; W {BO + trips * BH}"
     for celsius, trips in ((25, False), (69, False), (70, False), (71, True), (120, True))],
    "THD=12000 by default: 12000 samples are 2.949 s; a shorter overheat has no effect":
    "air 75; 11950 samples; air 25; 100 samples; air 75; 11950 samples; W o; 100 samples; W ho",
    'Reference 10: "Motion refused until cooled 5 °C below TH": 66 °C is too warm; only a Z clears the flag':
    [f"air 71; 3.1 s; P=50 A=65536 V=65536 MP; air 71; 1.0 s; {clear} G; 0.1 s; W ho; at 0; air 70; 1.0 s; "
     f"{clear} G; 0.1 s; W ho; at 0; air 66; 1.0 s; {clear} G; 0.1 s; W ho; at 0; air 65; 1.0 s; W ho; "
     f"Ze Zr Zl G; 0.1 s; W ho; {clear} G; 0.1 s; W; at 50"
     for clear in ("Zh", "ZS")],
    "Two flags, each cleared by its own Z; both must be cleared":
    f"air 69; 3.1 s; {MOVE}; 0.1 s; jam; 110 samples; free; air 71; 3.1 s; W eho; air 20; 3.1 s; Zh G; 0.1 s; "
    "W eo; Ze G; 0.1 s; W t",
    "TH=20 in a room of 25 °C is an overheat after THD samples":
    "TH=20; 3.1 s; W ho; TH=29 Zh; 0.001 s; W ho; TH=30 Zh; 0.001 s; W o",
    "4.1: the amplifier goes off, MTB and the static brake act; moves, RUN and LOAD are refused":
    f"load WHILE 1 / a=a+1 / LOOP; {MOVE} RUN; 0.1 s; air 71; 3.1 s; W ho; RMODE -> B; brake is high; mark; "
    "keep a; LOAD; "
    + "; ".join(f"{command}; 0.05 s; moved 0; a kept; brake is high"
                for command in ("G", "MT T=500", "X", "S", "MF4", "MS", "RUN")),
    "The fault comes within two samples after THD samples":
    [f"air 75; THD={thd}; {max(thd - 2, 0)} samples; RBh -> 0; 5 samples; RBh -> 1" for thd in (1, 10, 1000)],
    "4.1 item 4, motor protection fault: without F=32 the program ends, with F=32 it goes to C1":
    [f"load F={f} / WHILE 1 / a=a+1 / LOOP / C1 / c=c+1 / RETURNF; {MOVE} RUN; 0.1 s; air 71; 3.1 s; keep a; "
     "0.1 s; "
     f"c is {f // 32}; a {how}"
     for f, how in ((0, "kept"), (1, "kept"), (32, "grew"), (33, "grew"))],
})  # fmt: skip
def test_overheat(script):
    play(script)


def test_f_1_decelerates(bench, motor):
    """4.1 item 1: "If F=1 is issued, the controller decelerates to a stop"; then MTB (table 4.2)."""
    motor.ambient = 75
    send(bench, motor, f"THD=100 F=1 {MOVE}", 0)
    path = []
    for _ in range(200):
        advance(bench, 1)
        path.append(motor.axes["shaft"].position)
    path = path[: path.index(path[-1]) + 2]
    steps = [later - earlier for earlier, later in pairwise(path)]
    assert steps[-11:] == [10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0]
    advance(bench, 2)
    assert status_word(bench, motor) == BO + BH


def test_a_winding_warms_slowly(bench):
    """A frame 23 in hot air trips after a while; a power cycle clears the flag but does not cool the motor.

    The housing reaches the air's temperature after minutes instead of hours.
    """
    motor = ready(bench, shaft={"motor": {"model": "frame23", "housing_time_constant_s": 60.0}})
    motor.ambient = 100
    bench.run(10)
    assert status_word(bench, motor) == BO
    bench.run(12 * 60)
    assert status_word(bench, motor) == BO + BH and temperature(bench, motor) > 90
    motor.power_cycle()
    send(bench, motor, "UCI UDI ZS", 0.5)
    assert status_word(bench, motor) == BO and temperature(bench, motor) > 90
    bench.run(3.0)
    assert status_word(bench, motor) == BO + BH


def test_too_much_current_for_too_long(bench):
    """Table 4.1: "RMS current exceeded limit": a jammed motor pushes, while its controller is still cool.

    E=32000 prevents a position error.  Zh is refused until the current is low; then the motor moves again.
    """
    motor = ready(bench, shaft={"motor": "frame23"})
    motor.axes["shaft"].jam(True)
    send(bench, motor, "E=32000 A=200 V=400000 P=500 G", 1.0)
    assert status_word(bench, motor) == 0 and bench.run_until(lambda: motor.pins["brake"].level, 9.0)
    send(bench, motor, "Zh")
    assert status_word(bench, motor) == BO + BH and temperature(bench, motor) < 40
    motor.axes["shaft"].jam(False)
    send(bench, motor, "Zh G", 0.1)
    assert status_word(bench, motor) == BO + BH
    bench.run(120.0)
    assert status_word(bench, motor) == BO + BH
    send(bench, motor, "Zh G", 2.0)
    assert (status_word(bench, motor), ask(bench, motor, "RP")) == (0, "500")


def test_a_held_load_within_the_rated_torque_never_trips(bench):
    """A motor that holds 0.1 N·m, less than its rated torque, has no fault in an hour."""
    motor = ready(bench, shaft={"motor": "frame23"})
    send(bench, motor, "P=0 A=200 V=20000 G")
    motor.axes["shaft"].load(0.1)
    bench.run(600.0)
    assert status_word(bench, motor) == 0 and abs(int(ask(bench, motor, "RP"))) < 5
