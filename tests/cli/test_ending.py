"""Errors that end a serving program, and errors that are logged only."""

import asyncio
import gc
import json
import logging
import os
import signal

import pytest

from axistwin import Bench
from axistwin.cli.serving import ending
from axistwin.cli.serving.ending import fail
from axistwin.links.pacing import Pacer
from axistwin.ui.panel.people import People

from ..command import ended, serving


def raised(what):
    """Return the error that ends a program in whose loop `what(loop)` is called; None if the program continues."""

    async def served():
        ended = ending.ending()
        what(asyncio.get_running_loop(), ended)
        for _ in range(5):
            await asyncio.sleep(0)
            gc.collect(1)  # a deleted task reports an error that was not retrieved
        return ended.exception() if ended.done() else None

    return asyncio.run(served())


def broken_bench():
    bench = Bench()
    bench.clock.call_later(0, lambda: {}["defect"])
    return bench


def test_a_defect_of_the_bench_ends_it():
    assert isinstance(raised(lambda loop, _: loop.call_soon(Pacer(broken_bench().clock, None).start, loop)), KeyError)


def test_a_defect_of_the_bench_ends_it_also_when_the_panel_has_let_time_pass():
    def advance(loop, ended):
        pacer = Pacer(broken_bench().clock, None)
        pacer.on_defect = lambda error: fail(ended, error)
        with pytest.raises(KeyError):  # the web framework catches this error
            pacer.sync()

    assert isinstance(raised(advance), KeyError)


async def undone():
    json.loads("{")


@pytest.mark.parametrize("what", [
    lambda loop, _: loop.call_soon(json.loads, "{"),
    lambda loop, _: loop.call_soon(People().rename, None, "a name for nobody"),
    lambda loop, _: loop.create_task(undone()) and None,
    lambda loop, _: loop.call_exception_handler({"message": "something odd"})
], ids=["framework", "panel", "task", "no error"])  # fmt: skip
def test_a_defect_of_somebody_else_is_reported_with_its_traceback(caplog, what):
    with caplog.at_level(logging.ERROR, "axistwin"):
        assert raised(what) is None
    (record,) = [record for record in caplog.records if record.name == "axistwin"]
    assert record.exc_info is None or record.exc_info[2] is not None


def test_what_the_system_cannot_do_for_a_client_is_told_in_a_line(caplog):
    lost = {"message": "lost", "exception": ConnectionResetError("peer")}
    assert raised(lambda loop, _: loop.call_exception_handler(lost)) is None
    assert [(record.getMessage(), record.exc_info) for record in caplog.records] == [("lost: peer", None)]


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="Windows has no SIGHUP")
def test_a_closed_terminal_ends_every_server_as_sigterm_does(tmp_path):
    """SIGHUP: the link of the pseudo terminal is removed, and the trace is whole."""
    link, trace = tmp_path / "if1", tmp_path / "t.csv"
    with serving("if1", "--pty", link, "--trace", trace, "--speed", "100") as (program, _):
        assert link.is_symlink() and ended(program, signal.SIGHUP)[0] == 0
    assert not link.is_symlink() and trace.read_text().endswith("\n")


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="Windows has no SIGHUP")
def test_nohup_goes_on():
    """`nohup` ignores SIGHUP, and so does the server that it starts."""
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        assert raised(lambda loop, _: os.kill(os.getpid(), signal.SIGHUP)) is None
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)
