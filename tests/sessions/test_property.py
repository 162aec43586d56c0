"""After random acts at random speeds, going back to any time gives the same trace, byte by byte.

A run of the saved scene with `axistwin run` gives the same trace, too.
"""

import asyncio
from contextlib import suppress
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from axistwin import Bench, Session
from axistwin.core.errors import AxistwinError

from ..benches import bench_of
from .driving import Traced, do_all, drive, run_saved, upto

digiplan = bench_of("if2 if1", X={"limits": (-100, 400)}, Y={"motor": {"torque": [[0, 1.0], [500, 0.1]]}})


compumotor = bench_of(
    "1811", motor={"limits": (-3000, 9000), "encoder": {"counts_per_rev": 4000, "pulses_per_rev": 25000}}
)


smartmotor = bench_of("smartmotor motor", shaft={"motor": "frame23", "limits": (-800, 900)})


def all_of_them() -> Bench:
    bench = Bench()
    bench.add("if1", line="instant", X={"limits": (-100, 400)})
    bench.add("1811")
    bench.add("smartmotor", "motor", line="38400 8N1")
    return bench


SAID = {
    "if1": [b"(", b"U61\r", b"X40@300S1$\r", b"Y-20$\r", b"E\r", b"K\r", b"C\r", b":Z3:P0,2:X20$:=2,1:$\r", b"\xff"],
    "1811": [
        bytes.fromhex(text)
        for text in ("31 00 00 00 00 03 E8 00 03 D0 90", "33 00 00 00 64", "83", "84", "33 FF FF FF 90", "70")
    ],
    "motor": [b"UCI UDI ZS ", b"A=100 V=400000 MP O=0 P=500 G ", b"RP RPE ", b"MV V=-100000 G ", b"X ", b"a=7 Ra "],
}  # fmt: skip
DONE = {
    "if1": [("limit_plus", "low"), ("limit_plus", "release"), ("input1", "high"), ("input2", "high"), ("X.jam", "on"),
            ("X.jam", "off"), ("power", "off"), ("power", "on"), ("line", "9600 7E1"), ("break", "0.3"), ("dtr", "low"),
            ("dtr", "high"), ("flow", "dtr"), ("flow", "xon"), ("hold", "on"), ("hold", "off"), ("drop", "pending"),
            ("fault", "lose 2 name=gap"), ("fault", "flip probability=0.2 way=both seed=3"), ("mend", "all"),
            ("fault", 'stuck input1 high when="X passes 20" duration=0.05')],
    "1811": [
        ("cw_limit", "high"), ("cw_limit", "release"), ("power", "off"), ("power", "on"), ("init", "on"),
        ("write", "0 33 00 00 01 00"), ("write", "1 10"), ("read", "0 16"), ("write", "1 80"), ("motor.load", "0.2"),
        ("fault", 'power_cut duration=0.1 when="motor passes 300"'), ("mend", "all"),
    ],
    "motor": [("A", "2.5V"), ("A", "release"), ("B", "low"), ("shaft.load", "0.05"),
              ("shaft.jam", "on"), ("shaft.jam", "off"),
              ("shaft.push", "20"), ("ambient", "60"), ("master", "400 in 0.5"), ("power", "off"), ("power", "on"),
              ("line", "9600 8N1"), ("break", "0.1"), ("fault", "double 3 way=from name=echo"), ("mend", "all"),
              ("fault", 'jam when="echo ends" duration=0.2'), ("hold", "on"), ("hold", "off")],
}  # fmt: skip


async def wait(seconds: float, session: Session) -> None:
    """Wait until a time of the wall clock has passed."""
    session.run()
    await asyncio.sleep(seconds)


async def hurry(turns: int, session: Session) -> None:
    before, session.speed = session.speed, None
    session.run()
    for _ in range(turns):
        await asyncio.sleep(0)
    session.speed = before


async def say(name: str, data: bytes, session: Session) -> None:
    session.say(name, data)


async def do(name: str, act: tuple[str, str], session: Session) -> None:
    with suppress(AxistwinError):  # e.g. the fault to be mended does not exist, or a second fault has the same name
        session.do(name, *act)


async def pause(session: Session) -> None:
    session.pause()


async def step(kind: str, session: Session) -> None:
    await session.step(kind)


async def speed(times: float, session: Session) -> None:
    session.speed = times


async def by_a_host(name: str, data: bytes, session: Session) -> None:
    session.pacer.sync()
    if name in session.bench.ports:
        session.input.serial(name).write(data)
    else:
        for byte in data:
            session.input.bus(name).write(0, byte)
        session.input.bus(name).write(1, 0x10)
    session.pacer.work()


def steps(names: tuple[str, ...]):
    words = st.sampled_from([(name, data) for name in names for data in SAID[name]])
    acts = st.sampled_from([(name, act) for name in names for act in DONE[name]])
    return st.lists(
        st.one_of(
            words.map(lambda word: partial(say, *word)),
            words.map(lambda word: partial(by_a_host, *word)),
            acts.map(lambda act: partial(do, *act)),
            st.sampled_from([0.004, 0.03, 0.11, 0.4]).map(lambda seconds: partial(wait, seconds)),
            st.integers(1, 3).map(lambda turns: partial(hurry, turns)),
            st.just(pause),
            st.sampled_from(["event", "move"]).map(lambda kind: partial(step, kind)),
            st.sampled_from([0.1, 1.0, 3.0]).map(lambda times: partial(speed, times)),
        ),
        min_size=3,
        max_size=24,
    )


async def ready(names: tuple[str, ...], session: Session) -> None:
    session.speed = 100.0
    await wait(0.015, session)
    if "if1" in names:
        for data in (b"(", b"U61\r"):
            session.say("if1", data)
            await wait(0.013, session)
    session.speed = 1.0


@pytest.mark.parametrize(("build", "names"), [
    (digiplan, ("if1",)), (compumotor, ("1811",)), (smartmotor, ("motor",)), (all_of_them, ("if1", "1811", "motor"))
], ids=["digiplan", "compumotor", "smartmotor", "all"])  # fmt: skip
@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_a_session_is_repeated(build, names, data):
    told = data.draw(steps(names))
    shares = data.draw(st.lists(st.floats(0.01, 1), min_size=1, max_size=2))
    with TemporaryDirectory() as directory:
        drive(repeat(build, [partial(ready, names), *told], shares, Path(directory)))


async def repeat(build, told, shares, directory):
    session = Session(build)
    traced = Traced(session, directory)
    await do_all(session, told)
    end_ns, first = session.bench.now, traced.rows()
    saved = session.save()
    for share in shares:
        time_ns = int(end_ns * share)
        await session.go_to(0)
        await session.go_to(time_ns / 1e9)
        assert abs(session.bench.now - time_ns) <= 1 and session.recorded_seconds == end_ns / 1e9
        assert traced.rows() == upto(first, session.bench.now)
    await session.go_to(0)
    await session.go_to(end_ns / 1e9)
    assert traced.rows() == first
    assert not session.repeating and session.save() == saved
    assert run_saved(saved, directory, end_ns / 1e9) == first
