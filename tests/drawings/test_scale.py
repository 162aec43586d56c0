"""Numbers, scales and smooth motion in drawings."""

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.ui.drawings.scale import Flow, grouped, round_step, signed, ticks


def test_numbers_are_grouped_by_thousands_and_have_a_true_minus():
    assert grouped(24000) == "24\u2009000" and grouped(-1234567) == "\u22121\u2009234\u2009567"
    assert [signed(number) for number in (5, 0, -5)] == ["+5", "0", "\u22125"]


def test_ticks_are_round():
    assert list(ticks(-160, 24_000, 5)) == [0, 5000, 10_000, 15_000, 20_000]
    assert list(ticks(-5000, 60_000, 5)) == [0, 20_000, 40_000, 60_000]
    assert list(ticks(-3, 3, 10)) == [-3, -2, -1, 0, 1, 2, 3]


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])  # the machine may be loaded
@given(first=st.integers(-(10**9), 10**9), span=st.integers(1, 10**9), most=st.integers(2, 50))
def test_ticks_lie_within_and_are_few(first, span, most):
    found = list(ticks(first, first + span, most))
    assert all(first <= tick <= first + span for tick in found) and len(found) <= most + 1
    step = round_step(span, most)
    assert all(tick % step == 0 for tick in found) and str(step).rstrip("0") in ("1", "2", "5")


def test_a_drawing_moves_smoothly_while_time_passes():
    bench, flow = Bench(), Flow()
    assert not flow.is_smooth(bench)
    bench.run(0.05)
    assert flow.is_smooth(bench) and flow.is_smooth(bench)


def test_a_jump_is_none():
    bench, flow = Bench(), Flow()
    flow.is_smooth(bench)
    bench.run(1.001)
    assert not flow.is_smooth(bench)
    bench.run(0.05)
    assert flow.is_smooth(bench)


def test_another_bench_is_none_though_it_be_later():
    bench, other, flow = Bench(), Bench(), Flow()
    flow.is_smooth(bench)
    other.run(0.05)
    assert not flow.is_smooth(other)
    other.run(0.05)
    assert flow.is_smooth(other)
