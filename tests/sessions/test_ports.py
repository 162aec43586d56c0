"""Hosts at real ports of a session: recorded, blocked during a replay, and kept connected."""

import asyncio

from axistwin import Session
from axistwin.links.urls import parse
from axistwin.scenes.sessions.session import DRAIN_EVERY

from ..benches import bench_of
from ..links.serving import HOST_TIMEOUT_S

run = asyncio.run  # real ports need a real loop
if1 = bench_of("if1", line="instant")


board = bench_of("1811")


async def connected(session, name, scheme="tcp", **serving):
    url = await session.serve(**serving).open(name, parse(f"{scheme}://127.0.0.1:0"))
    host, _, port = url.address.rpartition(":")
    return await asyncio.open_connection(host, int(port))


async def ask(reader, writer, question, end=b"\r"):
    writer.write(question)
    return await asyncio.wait_for(reader.readuntil(end), HOST_TIMEOUT_S)


async def settled():
    """Wait until all data in transit on this machine have been received."""
    for _ in range(50):
        await asyncio.sleep(0)


async def initialised(session, reader, writer):
    session.run()
    while session.seconds < 1:
        await asyncio.sleep(0)
    assert await ask(reader, writer, b"(") == b"U\r"
    writer.write(b"U61\r")
    while session.seconds < 2:
        await asyncio.sleep(0)


async def test_a_client_polls_waits_while_the_run_is_repeated_and_goes_on():
    session = Session(if1, None)
    reader, writer = await connected(session, "if1")
    await initialised(session, reader, writer)
    for _ in range(20):
        assert (await ask(reader, writer, b"N\r")).endswith(b"\r")
    session.pause()
    who = "{}:{}".format(*writer.get_extra_info("sockname"))
    assert session.client("if1") == who
    end_s = session.recorded_seconds
    await session.go_to(1.5)
    assert (session.seconds, session.recorded_seconds, session.repeating) == (1.5, end_s, True)
    assert session.client("if1") == who
    told = len(list(session.journal))
    writer.write(b"N\r")
    await settled()
    assert len(list(session.journal)) == told
    session.run()
    assert (await asyncio.wait_for(reader.readuntil(b"\r"), HOST_TIMEOUT_S)).endswith(b"\r")
    assert not session.repeating and session.seconds >= end_s
    assert len(list(session.journal)) > told
    assert (await ask(reader, writer, b"N\r")).endswith(b"\r")
    writer.close()
    session.server.close()


async def test_another_future_begins_where_somebody_does_something_and_the_client_is_heard_there():
    session = Session(if1, None)
    reader, writer = await connected(session, "if1")
    await initialised(session, reader, writer)
    await ask(reader, writer, b"N\r")
    session.pause()
    await session.go_to(0.5)
    writer.write(b"(")
    await settled()
    session.do("if1", "input1", "high")
    assert (session.recorded_seconds, session.repeating) == (0.5, False)
    session.run()
    assert await asyncio.wait_for(reader.readuntil(b"\r"), HOST_TIMEOUT_S) == b"U\r"
    assert session.bench["if1"].pins["input1"].level
    writer.close()
    session.server.close()


async def test_a_host_at_a_bus_is_repeated_too():
    session = Session(board, None)
    reader, writer = await connected(session, "1811", "bus")
    session.run()
    while session.seconds < 1:
        await asyncio.sleep(0)
    assert await ask(reader, writer, b"w 0 83\nw 1 10\n", b"ok\n") == b"ok\n"
    await asyncio.wait_for(reader.readuntil(b"ok\n"), HOST_TIMEOUT_S)
    status = b""
    while not status or not int(status, 16) & 8:
        status = await ask(reader, writer, b"r 1\n", b"\n")
    message = await ask(reader, writer, b"r 0 16\n", b"\n")
    assert message.startswith(b"83 ")
    session.pause()
    end_s = session.seconds
    await session.go_to(0)
    await session.go_to(end_s)
    assert await ask(reader, writer, b"r 1\n", b"\n") == status
    writer.close()
    session.server.close()


async def test_a_client_that_finds_the_controller_just_switched_on_is_repeated():
    session = Session(if1, None)
    session.run()
    while session.seconds < 1:
        await asyncio.sleep(0)
    _, writer = await connected(session, "if1", reset=True)
    await settled()
    session.pause()
    acts = [f"{act.target} {act.value}" for moment in session.journal for act in moment.acts]
    assert acts[-2:] == ["power off", "power on"]
    writer.close()
    session.server.close()


def test_nobody_is_connected_where_nobody_serves():
    assert Session(if1).client("if1") == ""


async def test_a_host_at_a_second_channel_is_repeated_too():
    session = Session(bench_of("smartmotor", line="instant"), None)
    _, writer = await connected(session, "smartmotor.rs485")
    session.run()
    writer.write(b"RP ")
    while not any(act.controller == "smartmotor.rs485" for moment in session.journal for act in moment.acts):
        await asyncio.sleep(0)
    writer.close()
    session.pause()
    session.server.close()


async def test_what_nobody_is_connected_to_hear_is_not_kept_for_ever():
    session = Session(if1, None)
    session.do("if1", "estop", "high")
    session.say("if1", b"(")
    session.run()
    while session.pacer.passes <= 2 * DRAIN_EVERY:
        await asyncio.sleep(0)
        session.pacer.advance_slice(lambda _: session.bench.run(0.001))
    session.pause()
    assert session.bench["if1"].serial.read() == b""
