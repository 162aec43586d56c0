"""Slow preparations of a served bench run in a thread, and those that take seconds in a child process."""

import gc
import sys
import threading
from types import SimpleNamespace

import pytest

from axistwin import Bench
from axistwin.cli.serving import preparing as module
from axistwin.controllers.smartmotor.kernel import core, jit
from axistwin.controllers.smartmotor.kernel.kernel import advance
from axistwin.core.errors import UsageError

from ..command import PATIENCE_S


class Slow:
    """A product whose preparation waits for the test, with a cache that a child process fills."""

    def __init__(self, cached):
        self.cached, self.calls, self.interpreter = cached, [], None
        self.prepared_now, self.go_on = threading.Event(), threading.Event()

    def note(self):
        return "a note"

    def prepared(self, speed, number):
        self.calls.append(("prepared", speed, number))
        return self.cached

    def prepare(self, speed, number):
        self.interpreter = threading.current_thread().name, gc.isenabled(), sys.getswitchinterval()
        self.calls.append(("prepare", speed, number))
        self.prepared_now.set()
        assert self.go_on.wait(PATIENCE_S)


@pytest.fixture
def slow(monkeypatch):
    def made(cached):
        product = Slow(cached)
        monkeypatch.setattr(module, "product", lambda model: product)
        monkeypatch.setattr(module, "DELAY_S", 0)
        return product

    return made


BENCH = SimpleNamespace(controllers={name: SimpleNamespace(product=SimpleNamespace(model="m")) for name in "ab"})


def test_the_bench_is_served_while_a_thread_prepares(slow, caplog):
    product, before = slow(cached=True), (gc.isenabled(), sys.getswitchinterval())
    with module.preparing(BENCH, 20.0):
        assert product.prepared_now.wait(PATIENCE_S)
        assert product.interpreter == ("preparations", False, pytest.approx(module.SWITCH_S))
        product.go_on.set()
    assert product.calls == [("prepared", 20.0, 2), ("prepare", 20.0, 2)]
    assert (gc.isenabled(), sys.getswitchinterval()) == before
    assert caplog.messages == ["a note"]


def test_what_is_not_in_the_cache_is_compiled_first_in_a_child_process(slow, monkeypatch, tmp_path):
    monkeypatch.setattr(module, "CHILD", f"import sys; open({str(tmp_path / 'child')!r}, 'w').write(sys.argv[1])")
    product = slow(cached=False)
    with module.preparing(BENCH, None):
        assert product.prepared_now.wait(PATIENCE_S)
        assert (tmp_path / "child").read_text() == "m"
        product.go_on.set()


def test_the_end_does_not_wait_for_the_child_process(slow, monkeypatch):
    started, popen = threading.Event(), module.subprocess.Popen

    def begun(*arguments, **options):
        child = popen(*arguments, **options)
        started.set()
        return child

    monkeypatch.setattr(module.subprocess, "Popen", begun)
    monkeypatch.setattr(module, "CHILD", f"import time; time.sleep({10 * PATIENCE_S})")
    product = slow(cached=False)
    with module.preparing(BENCH, None):
        assert started.wait(PATIENCE_S)
    assert product.calls == [("prepared", None, 2)]


def test_an_installation_that_cannot_be_loaded_is_a_warning(slow, monkeypatch, caplog):
    def fail(speed, number):
        raise UsageError("numba cannot be loaded")

    monkeypatch.setattr(slow(cached=True), "prepare", fail)
    with module.preparing(BENCH, None) as ended:
        assert ended.wait(PATIENCE_S)
    assert caplog.messages == ["a note", "numba cannot be loaded"] and gc.isenabled()


def test_a_bench_that_ends_at_once_prepares_nothing(slow, monkeypatch):
    product = slow(cached=True)
    monkeypatch.setattr(module, "DELAY_S", 10 * PATIENCE_S)
    with module.preparing(BENCH, None):
        pass
    assert product.calls == []


@pytest.mark.skipif(not jit.available(), reason="Numba is not installed")
def test_motors_change_over_only_when_the_kernel_is_loaded(monkeypatch):
    def loading(function):
        assert function is advance and core.Engine.compiled is None
        return lambda *arguments: during.append((len(arguments), arguments[-1], core.Engine.compiled))

    during = []
    monkeypatch.setattr(core.Engine, "compiled", None)
    monkeypatch.setattr(jit, "best", loading)
    core.prepare(1.0, 1)  # for one motor in real time no kernel is compiled
    assert during == [] and core.prepared(1.0, 1)
    core.prepare(None, 1)
    assert during == [(11, 0, None)] and core.Engine.compiled is not None


def test_a_model_without_preparations_is_prepared():
    with module.preparing(Bench(), None) as ended:
        assert module.product("if1").prepared(None, 100) and ended.wait(PATIENCE_S)
