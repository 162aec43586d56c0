"""Measures and claims: of known signals, and compared with a simple reference that evaluates every second."""

import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import AxistwinError, Scene
from axistwin.core.units import S
from axistwin.sweeps import CLAIMS, MEASURES, Recording, Series, Sweep, claim, measure

from .scenes import motor, stepper


class Record:
    """A recording with given values: `signals` have values by time in s, `events` have times in s."""

    def __init__(self, end_s, events=None, **signals):
        self.end_ns, self.events, self.signals = end_s * S, events or {}, signals

    def series(self, name):
        times, values = zip(*sorted(self.signals[name].items()), strict=True)
        return Series.of(np.array(times) * S, np.array(values, float), self.end_ns)

    def times(self, event):
        return np.array(self.events.get(event, []), np.int64) * S


RECORD = Record(
    10,
    {"t.o rises": [1, 4, 5], "t.o falls": [3, 8], "t.X passes 5": [2, 6], "t.i rises": []},
    x={0: 0, 2: 4, 3: -6, 5: 2},
    y={0: 0, 4: 1, 8: 0},
    **{"t.X.position": {0: 0, 2: 9, 6: 1}},
)


@pytest.mark.parametrize(("sentence", "value"), [
    ("final x", 2), ("max x", 4), ("min x", -6), ("max |x|", 6), ("mean x", (4 - 12 + 10) / 10), ("integral x", 2),
    ("rms x", ((16 + 72 + 20) / 10) ** 0.5), ("max x while y high", 2), ("min x while y high and x < 0", -6),
    ("integral x while y low", 4 - 6 + 4), ("from t.o rises to t.o falls", 2),
    ("from t.o rises to t.o falls last", 4), ("from t.o rises to t.o falls each", [2, 4]),
    ("from t.o rises to t.o rises each", [3, 1]), ("count t.o rises", 3), ("count t.i rises", 0)])  # fmt: skip
def test_measures(sentence, value):
    assert measure(sentence).answer(RECORD).value == pytest.approx(value)


@pytest.mark.parametrize(("sentence", "reason"), [
    ("from t.i rises to t.o falls", "no event 't.i rises'"), ("from t.o falls to t.i rises", "no event 't.i rises'"),
    ("max x while x > 100", "never x > 100")])  # fmt: skip
def test_a_measure_without_its_event_has_a_reason(sentence, reason):
    found = measure(sentence).answer(RECORD)
    assert (found.value, found.reason) == (None, reason)


INF = float("inf")


@pytest.mark.parametrize(("sentence", "holds", "robustness", "at_s"), [
    ("always x < 5", True, 1, None), ("always x < 4", False, 0, 2), ("always x <= 4", True, 0, None),
    ("always x > 0 while y high", False, -6, 4), ("always not x > 4", True, 0, None), ("never x > 3", False, -1, 2),
    ("always (x < 1 or y low) and |x| < 7", False, -1, 5), ("eventually x = 4", True, 0, None),
    ("eventually x > 3 within 1 s", False, -3, 1), ("eventually x > 3 within 2 s", True, 1, None),
    ("eventually y high within 3.5 s", False, -INF, 3.5), ("always within 1 s after t.o rises: x > 1", True, 1, None),
    ("always within 1 s after t.o falls: x > 1", False, -6 - 1, 4),
    ("always for 1 s after t.o rises: x >= 0", False, -6, 4), ("x >= 0 until x >= 4", True, 0, None),
    ("x >= 0 until x > 4", False, 0, 3), ("x > -9 until y high within 3 s", False, -INF, 3),
    ("never t.i rises", True, INF, None), ("never t.o falls", False, -INF, 3),
    ("never t.o falls while y high", True, 0, None), ("never t.o rises while y high", False, -1, 4),
    ("never t.o falls while x > 3", True, 0, None), ("never t.o rises while x > 3", True, 1, None),
    ("never t.o falls while x > 0 and x < 3", False, -3, 8), ("never t.X passes 5", False, -4, 2),
    ("never t.X passes 5 while x < 0", True, 4, None), ("never t.X passes 12 while x < 0", True, 3, None),
    ("max |x| <= 6.5", True, 0.5, None), ("from t.o rises to t.o falls each < 3", False, -1, 10)])  # fmt: skip
def test_claims(sentence, holds, robustness, at_s):
    found = claim(sentence).answer(RECORD)
    assert (found.holds, found.robustness) == (holds, pytest.approx(robustness))
    assert found.at_ns == (None if at_s is None else at_s * S)


@pytest.mark.parametrize("sentence", ["always within 1 s after t.i rises: x > 1", "always x > 1 while x > 50"])
def test_a_claim_without_its_event_or_condition_has_a_reason(sentence):
    found = claim(sentence).answer(RECORD)
    assert (found.holds, found.robustness) == (None, None) and found.reason


CHANGES = st.dictionaries(st.integers(1, 12), st.integers(-5, 5), max_size=6)


@settings(max_examples=30, deadline=None)
@given(CHANGES, CHANGES, st.sets(st.integers(0, 12), min_size=1, max_size=4), st.integers(0, 6))
def test_claims_agree_with_a_simple_reference(x, y, events, window):
    x, y, events = {0: 0, **x}, {0: 1, **y}, sorted(events)
    record = Record(12, {"t.o rises": events}, x=x, y=y)

    def at(signal, time):
        return signal[max(t for t in signal if t <= time)]

    xs, ys = [at(x, t) for t in range(13)], [at(y, t) for t in range(13)]
    windows = [range(e, min(e + window, 12) + 1) for e in events]
    expected = {
        "always x < 3": min(3 - v for v in xs),
        "eventually x >= 2": max(v - 2 for v in xs),
        "always x < 3 or y > 1": min(max(3 - a, b - 1) for a, b in zip(xs, ys, strict=True)),
        "always not (x < 3 and y = 1)": min(-min(3 - a, -abs(b - 1)) for a, b in zip(xs, ys, strict=True)),
        f"always within {window} s after t.o rises: x > 0": min(max(xs[t] for t in w) for w in windows),
        f"always for {window} s after t.o rises: x > 0": min(min(xs[t] for t in w) for w in windows),
        f"x < 3 until y > 2 within {window} s": max(
            min([ys[t] - 2, *(3 - v for v in xs[:t])]) for t in range(window + 1)
        ),
    }
    for sentence, robustness in expected.items():
        found = claim(sentence).answer(record)
        assert (sentence, found.robustness) == (sentence, robustness)
        if robustness:
            assert found.holds is (robustness > 0)


@pytest.mark.parametrize("form", [*MEASURES, *CLAIMS], ids=lambda form: form.form)
def test_every_example_is_read_by_its_form(form):
    read = measure if form in MEASURES else claim
    assert read(form.example).text == form.example


@pytest.mark.parametrize(("read", "text", "told"), [
    (measure, "finl x", "invalid measure"), (measure, "final |x", "invalid signal"),
    (measure, "max x while y", "invalid condition"), (measure, "count t.o goes", "invalid event"),
    (measure, "from t.o rises", "expected two events with 'to' between them"),
    (claim, "sometimes x > 1", "invalid claim"), (claim, "always x >", "invalid condition"),
    (claim, "always (x > 1", "invalid condition"), (claim, "always x > y", "is not a number"),
    (claim, "never t.X passes high", "expected a number, e.g. 1000 in 'table.X passes 1000'")])  # fmt: skip
def test_sentences_that_cannot_be_read_are_refused(read, text, told):
    with pytest.raises(AxistwinError) as error:
        read(text)
    assert told in str(error.value)


def test_lost_steps_and_position_are_exact_at_every_time(tmp_path):
    scene = Scene.load(stepper(tmp_path))
    table = dict(scene.data["controller"][0])
    table["axes"] = {"X": {**table["axes"]["X"], "load": {"torque": 0.6, "inertia": 6e-5}}}
    bench = scene.varied({**scene.data, "controller": [table]}).build()
    axis, seen = bench["table"].axes["X"], []
    with Recording(bench, ["table.X.position", "X.lost"], []) as record:
        for _ in range(500):
            bench.run(0.01)
            seen.append((bench.now, axis.position, axis.lost))
    times = np.array([time_ns for time_ns, _, _ in seen])
    assert max(lost for _, _, lost in seen) > 0
    assert record.series("table.X.position").at(times).tolist() == [at for _, at, _ in seen]
    assert record.series("X.lost").at(times).tolist() == [lost for _, _, lost in seen]


def test_signals_of_a_servo(tmp_path):
    bench = Scene.load(motor(tmp_path)).build()
    axis, seen = bench["knife"].axes["shaft"], []
    bench.run(0.05)
    names = ["knife.shaft.following_error", "shaft.velocity", "knife.shaft.position", "RKP"]
    bench["knife"].assign("a", 500)
    with Recording(bench, names, ["knife.C rises"]) as record:
        for _ in range(200):
            bench.run(0.002)
            seen.append((bench.now, axis.setpoint - axis.position, axis.position))
    times = np.array([time_ns for time_ns, _, _ in seen])
    assert record.series("knife.shaft.following_error").at(times).tolist() == [error for _, error, _ in seen]
    velocity = record.series("shaft.velocity")
    assert float(np.sum(velocity.values * velocity.seconds)) == pytest.approx(axis.position)
    assert record.series("RKP").values[-1] == 60


def test_energy_of_a_move_and_of_axes_without_windings(tmp_path):
    """A move and back gives heat only; before power-up the drive uses no energy."""
    rows = (
        Sweep(motor(tmp_path))
        .vary("knife.a", [2000, 20_000])
        .measure("joules", "energy knife.shaft")
        .claim("economical", "energy shaft < 1000")
        .run(workers=0, seconds=1)
        .to_pylist()
    )
    short, long = (row["joules"] for row in rows)
    assert 0 < short < long < 1000 and [row["economical.robustness"] for row in rows] == [1000 - short, 1000 - long]
    for axis, told in (("table.X", "the energy of axis table.X is unknown"), ("table.Q", "no axis")):
        with pytest.raises(AxistwinError, match=told):
            Sweep(stepper(tmp_path)).measure("joules", f"energy {axis}").check()


AGREEING = [
    ("always x < 3", "always(x < 3)"),
    ("never x > 3", "always(not(x > 3))"),
    ("always y <= 0 or |x| < 4", "always((y <= 0) or (abs(x) < 4))"),
    ("eventually x > 2 within 4 s", "eventually[0:4](x > 2)"),
    ("eventually x > 2 and y > 0", "eventually((x > 2) and (y > 0))"),
    ("x < 4 until y > 0 within 6 s", "(x < 4) until[0:6] (y > 0)"),
]


@pytest.mark.parametrize(("ours", "theirs"), AGREEING)
def test_claims_agree_with_rtamt(ours, theirs):
    """An independent implementation of signal temporal logic, for 20 pairs of signals that change at whole seconds."""
    rtamt = pytest.importorskip("rtamt", reason="rtamt (Python 3.11 and 3.12 only) is not installed")
    chance = random.Random(1)
    for _ in range(20):
        x, y = ([chance.randint(-5, 5) for _ in range(13)] for _ in "xy")
        monitor = rtamt.StlDiscreteTimeSpecification()
        for name in ("x", "y", "out"):
            monitor.declare_var(name, "float")
        monitor.spec = f"out = {theirs}"
        monitor.parse()
        robustness = monitor.evaluate({"time": list(range(13)), "x": x, "y": y})[0][1]
        assert claim(ours).answer(Record(12, x=dict(enumerate(x)), y=dict(enumerate(y)))).robustness == robustness
