"""Chapter Stop, discontinue, suspend, kill: 70h to 7Fh by command and by trigger, and the messages of A0h to ACh."""

from ..scripts import scripts
from .scripts import play


@scripts(
    {
        "From 10,000 pps at 100,000 pps²: 49 levels of 2 ms, from 9,800 to 200 pps, are 490 pulses in 98 ms":
        "cruise 10000 100000; 70; mark; clock; 8F -> FF; until at rest; 98 ms later; moved 489 to 491",
        "events of a move":
        "default 10000 100000; A0 01; A1 01; A2 01; A3 01; A4 01; A5 01; 33 =3000; idle; says A0 00, A1 00, A2 00, "
        "A3 00, A4 00, A5 00; 33 =3000; idle; says A1 00, A3 00, A5 00; AF; 33 =3000; idle; says nothing",
        "a move that is ended before its velocity sends no A3h":
        "A3 01; default 10000 100000; 32 00; 0.05 s; 73; 1 s; says nothing",
        "hits of the limits":
        "{cw_limit|ccw_limit} high; 0.001 s; {A8|AA} 01; {A9|AB} 01; {cw_limit|ccw_limit} low; 0.001 s; {cw_limit|"
        "ccw_limit} high; 0.001 s; {cw_limit|ccw_limit} low; 0.001 s; {cw_limit|ccw_limit} high; 0.001 s; says {A8|"
        "AA} 00, {A9|AB} 00, {A9|AB} 00",
    }
)  # fmt: skip
def test_stop(bench, script):
    play(bench, script)
