"""The setpoint: the commanded position in the machine's own coordinates, read at any time."""

from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench

from .talking import SAMPLE_S, ask, ready, send

DATA = {"motor": "frame23", "load": {"inertia_kg_m2": 1e-4}}


def moving(origin="", **options):
    bench = Bench()
    motor = ready(bench, shaft=DATA, **options)
    send(bench, motor, f"{origin}V=200000 A=500 P=4000 MP G ")
    return bench, motor


@settings(deadline=None, max_examples=12)
@given(looks=st.lists(st.integers(1, 150), min_size=1, max_size=8), origin=st.sampled_from(["", "O=123 ", "F=2 "]))
def test_the_setpoint_is_that_published_in_each_sample(looks, origin):
    """The setpoint read at any time is that of the last sample; reading it does not change the motion."""
    bench, motor = moving(origin)
    axis, published = motor.axes["shaft"], {}

    def note(samples):
        for number in range(len(samples)):
            published[samples.time_ns(number)] = int(samples.commanded[number])

    axis.subscribe(note)
    seen = {}
    for samples in looks:
        bench.run(samples * SAMPLE_S)
        seen[bench.now] = axis.setpoint
    axis.catch_up()
    for time_ns, setpoint in seen.items():
        done = [at for at in published if at <= time_ns]
        assert not done or setpoint == published[max(done)]
    other, same = moving(origin)
    other.run((bench.now - other.now) / 1e9)
    assert same.axes["shaft"].position == axis.position


def test_it_less_the_position_is_the_following_error():
    bench, motor = moving("O=500 ")
    bench.run(0.05)
    axis = motor.axes["shaft"]
    error = axis.setpoint - axis.position
    assert error > 0
    motor.axes["shaft"].jam()
    bench.run(0.002)
    assert axis.setpoint - axis.position > error
    assert abs(int(ask(bench, motor, "RPE ")) - (axis.setpoint - axis.position)) < 60  # read a little later


def test_with_the_servo_off_it_is_where_the_shaft_is():
    bench, motor = moving()
    bench.run(2.0)
    send(bench, motor, "OFF ")
    motor.axes["shaft"].encoder.displace(300)
    bench.run(0.1)
    axis = motor.axes["shaft"]
    assert axis.setpoint == axis.position == axis.encoder.count
