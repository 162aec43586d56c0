"""Checks of the language server in a separate process."""

import asyncio
import os
import socket

import pytest

from axistwin.ui.editor.background import Background


def run(play):
    async def execute():
        background = Background()
        try:
            return await play(background)
        finally:
            background.close()

    return asyncio.run(execute())


@pytest.fixture
def gate():
    """Return a listening socket, and a program that waits in the background until the test sends a byte."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        address = listening.getsockname()
        listening.setblocking(False)
        yield listening, f"import socket; socket.create_connection({address!r}).recv(1)"


async def entered(listening):
    """Wait until the program in the background is at the gate."""
    connection, _ = await asyncio.get_running_loop().sock_accept(listening)
    return connection


def test_functions_are_executed_in_one_other_process():
    async def play(background):
        return [await background.run(os.getpid) for _ in range(3)]

    first, *others = run(play)
    assert first != os.getpid() and others == [first, first]


def test_the_event_loop_is_free_while_a_function_is_executed(gate):
    async def play(background):
        checking = asyncio.create_task(background.run(exec, gate[1]))
        connection = await entered(gate[0])
        for _ in range(100):
            await asyncio.sleep(0)
        assert not checking.done()
        connection.close()
        return await checking

    assert run(play) is None


def test_a_function_waits_for_the_one_before_even_if_nobody_wants_its_result(gate):
    async def play(background):
        first = asyncio.create_task(background.run(exec, f"import os; os.done = 1; {gate[1]}; os.done = 2"))
        connection = await entered(gate[0])
        first.cancel()
        second = asyncio.create_task(background.run(eval, "__import__('os').done"))
        await asyncio.sleep(0)
        connection.close()
        return await second

    assert run(play) == 2


def test_an_error_is_raised_to_the_caller_and_printed_text_is_not_an_answer():
    async def play(background):
        with pytest.raises(RuntimeError, match="ZeroDivisionError"):
            await background.run(divmod, 1, 0)
        return await background.run(eval, "print('a text') or 3")

    assert run(play) == 3


def test_a_process_that_ends_is_started_again():
    async def play(background):
        with pytest.raises(RuntimeError, match="has ended"):
            await background.run(os._exit, 3)
        return await background.run(abs, -3)

    assert run(play) == 3


def test_a_closed_background_starts_no_process(gate):
    async def play(background):
        checking = asyncio.create_task(background.run(exec, gate[1]))
        connection = await entered(gate[0])
        background.close()
        with connection:
            connection.setblocking(False)
            assert await asyncio.get_running_loop().sock_recv(connection, 1) == b""  # the process has ended
        checking.cancel()

    run(play)
