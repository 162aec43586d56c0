"""Followers of registers: each follower has its own registers, and others do not affect it."""

from functools import cache
from itertools import groupby

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench, tracing

from .talking import ready, send

NAMES = ("RP", "RV", "Ra", "RMODE", "P", "RTEMP", "RBt")
SAYINGS = (
    "a=1 A=65536 V=400000 P=3000 G ", "a=a+1 a=a+1 ", "X ", "MV V=200000 G a=7 ", "P=17 S ", "O=100 ",
)  # fmt: skip


class Follower:
    """The changes that one follower has received: times and values of each register."""

    def __init__(self, motor, names):
        self.names = names
        registers, now_ns = motor.registers, motor.bench.now
        self.told = {name: [(now_ns, registers[name].read())] for name in names}
        self.end = motor.follow(names, self.take)

    def take(self, times, which, values):
        for time_ns, number, value in zip(times, which, values, strict=True):
            self.told[self.names[number]].append((time_ns, value))

    def course(self):
        """Return the values in their order, without repetitions."""
        return {
            name: [next(same) for _, same in groupby(told, key=lambda one: one[1])] for name, told in self.told.items()
        }


def a_motor():
    bench = Bench()
    return bench, ready(bench)


def run(bench, motor, also=lambda step: None):
    for step, saying in enumerate(SAYINGS):
        also(step)
        motor.serial.write(saying.encode())
        also(step + 0.5)
        bench.run(0.037)
    motor.axes["shaft"].catch_up()


@cache
def all_followed_alone():
    bench, motor = a_motor()
    follower = Follower(motor, NAMES)
    run(bench, motor)
    return follower.course()


def followed_alone(names):
    return {name: all_followed_alone()[name] for name in names}


STEPS = st.sampled_from([step / 2 for step in range(2 * len(SAYINGS))])
SOME = st.lists(st.sampled_from(NAMES), min_size=1, max_size=4, unique=True).map(tuple)


@settings(max_examples=12, deadline=None)
@given(SOME, SOME, STEPS, STEPS)
def test_a_follower_is_told_the_same_whoever_else_comes_and_goes(names, others, comes, goes):
    bench, motor = a_motor()
    follower, other = Follower(motor, names), []

    def come_and_go(step):
        if step == comes:
            other.append(Follower(motor, others))
        if step == goes and other:
            other.pop().end()

    run(bench, motor, come_and_go)
    assert follower.course() == followed_alone(names)


@settings(max_examples=12, deadline=None)
@given(SOME, SOME, STEPS)
def test_who_comes_later_or_stays_longer_is_told_all_of_his_own(names, others, step):
    bench, motor = a_motor()
    first, late = Follower(motor, others), []

    def take_over(now):
        if now == step:
            late.append((bench.now, Follower(motor, names)))
            first.end()

    run(bench, motor, take_over)
    [(since_ns, follower)] = late
    assert after(since_ns, follower.course()) == after(since_ns, followed_alone(names))


def after(since_ns, courses):
    """Return the value of each register after all events at a time, and its later changes."""
    return {
        name: (
            [value for at_ns, value in course if at_ns <= since_ns][-1],
            [one for one in course if one[0] > since_ns],
        )
        for name, course in courses.items()
    }


def test_both_are_told_how_everything_is_when_the_power_comes_back():
    bench, motor = a_motor()
    followers = Follower(motor, ("Ra", "RMODE")), Follower(motor, ("RV", "Ra"))
    send(bench, motor, "a=5 ", 0.01)
    motor.power_cycle()
    bench.run(0.01)
    for follower in followers:
        assert [value for _, value in follower.course()["Ra"]] == [0, 5, 0]


def test_nobody_is_told_anything_when_all_have_gone():
    bench, motor = a_motor()
    followers = [Follower(motor, ("Ra",)) for _ in range(2)]
    for follower in followers:
        follower.end()
    send(bench, motor, "a=5 ", 0.01)
    motor.power_cycle()
    assert [len(follower.told["Ra"]) for follower in followers] == [1, 1]


@pytest.mark.parametrize("also", ["*", "smartmotor.RP,smartmotor.Ra"])
def test_a_trace_is_the_same_file_while_another_is_written(tmp_path, also):
    def written(name, beside):
        bench, motor = a_motor()
        with tracing(bench, tmp_path / name, ["*"]):
            if beside is None:
                run(bench, motor)
            else:
                with tracing(bench, tmp_path / f"beside-{name}", beside.split(",")):
                    run(bench, motor)
            bench.run(0.01)
        return (tmp_path / name).read_bytes()

    assert written("one.csv", also) == written("two.csv", None)
