"""9.2, 9.3, 9.5: crossings of the zero point, in both directions and with each kind of cam."""

from .scenarios import cam, start_cam, turn_to
from .scripts import play, scripts
from .talking import send


@scripts({
    '9.3: "in either direction": before the origin there are the dwell, 2000 counts, and a new cycle of 4000':
    f"{cam('F=16')}; turn 3000; BASE=4000 MC CI ; "
    "turn 0 -1 -2000 -2500 -6000 -8000 -8500: 0 0 0 250 -500 -500 -250",
    "9.2: with a new D, CTR is BASE plus this D minus 1 at one count before zero":
    f"{cam('F=128')}; turn 3000; D=100 CI ; turn 0: 0; RP RCTR -> 0 0; turn -1: 0; RP RCTR -> 500 8099; "
    "turn -1100: 250; RP RCTR -> 750 7000; turn -8101; RP RCTR -> 500 8099",
    "9.5 names no kind of cam, so in F=0 a new BASE takes effect too, at the zero point after each BASE":
    f"{cam('F=0')}; turn 3000; BASE=4000 MC CI ; turn 7000 8000 9000 11000 12000 13000: 750 0 500 1000 0 500",
    "9.5: F is changed from 0 to 16 at the zero point; later positions are relative to the shaft's position "
    "there":
    f"{cam('F=0')}; turn 3000; D=100 F=16 MC CI ; turn 7000 8000 9000 16000 16100 17100: 750 0 250 500 500 750",
    "4: O= shifts actual and commanded position together, so the shaft does not move":
    [f"{cam(f)}; turn 3000; O=0 ; at 250; turn 6000: 1000; @P is {later}"
     for f, later in (("F=16", 750), ("F=144", 750))],
    "9.5: starting with MCn and G uses the buffered parameters; an earlier CI changes nothing at the zero "
    "point":
    "MF4 F=16 D=2000 BASE=8000 SIZE=8 aw[0] 0 250 500 250 0 500 1000 750 500.; MC D=100 CI G D=300; "
    "turn 8000 8100 9100 16200 17200: 500 500 750 1000 1250",
    "9.4: MC2 doubles the encoder's pulses: a cycle of BASE=16 and D=5 takes 10.5 counts, two cycles take 21":
    "MF4 F=16 D=5 BASE=16 SIZE=8 aw[0] 0 2 4 6 8 10 12 14 100. MC2 G; "
    "turn 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 by 1: 0 2 4 6 8 10 12 14 100 100 100 101 "
    "103 105 107 109 111 113 157 200 200 200 202; "
    "turn 22 21 20 19 18 17 16 15 14 13 12 11 10 9 8 7 6 5 4 3 2 1 0 by 1: 202 200 200 200 157 113 111 109 107 "
    "105 103 101 100 100 100 14 12 10 8 6 4 2 0",
    "9.4: below ¼ BASE per sample no zero point is missed: after 10000 counts, five cycles take 8100 counts "
    "each":
    [f"{cam('F=16')}; turn {3000 if way > 0 else 7000}; D=100 CI; "
     f"turn {(50500 if way > 0 else -40500) + 1000} by {per_sample}: {(6 if way > 0 else -5) * 500 + 250}"
     for per_sample in (1, 777, 1999) for way in (1, -1)],
    "9.4: MC8 reaches ¼ BASE per sample at an eighth of the counts: a cycle of 10000 counts is passed in 1250":
    [f"{cam('F=16', mc='MC8')}; turn 25125 by {per_sample}: 10250; turn -24875 by {per_sample}: -9750"
     for per_sample in (50, 249)],
})  # fmt: skip
def test_cam_crossings(script):
    play(script)


def test_ci_over_and_over_follows_d(bench, motor):
    """Each cycle sends D+1, MC and CI, as in example 4: the cycles take 8000, 8001 and 8002 counts."""
    start_cam(bench, motor, "F=16", dwell=0)
    end, position = 0, 0
    for dwell in range(5):
        end, position = end + 8000 + dwell, position + 500
        turn_to(bench, motor, end - 2000)
        send(bench, motor, f"D={dwell + 1} MC CI", 0)
        assert turn_to(bench, motor, end - 1) == position and turn_to(bench, motor, end + 1000) == position + 250
