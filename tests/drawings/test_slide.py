"""The drawing of an axis with limited travel."""

import re

from axistwin import Bench
from axistwin.ui.drawings.slide import Slide


def figures(**options):
    slide = Slide(Bench().add("if1", X=options), "X", lambda pin, level: None)
    return re.findall(r'class="figures" x="([0-9.]+)" y="88">([^<]*)<', slide.drawing.art)


def test_the_ruler_counts_in_the_unit_of_the_machine():
    in_mm = figures(limits=["0 mm", "400 mm"], units={"per": 80, "of": "mm"})
    assert [text for _, text in in_mm] == ["0", "100", "200", "300", "400 mm"]
    in_pulses = figures(limits=(0, 32_000))
    assert in_pulses[-1][1].replace("\u2009", " ").replace("\u202f", " ").replace("\xa0", " ") == "30 000"
    assert in_mm[-1][0] == "270.00", "400 mm are 32,000 pulses, the end of the scale"
