"""Compilation of the sampled functions: its conditions, and its cache, also with older versions in it."""

import logging
import os
import sys
from functools import cache
from types import FunctionType

import pytest

from axistwin.controllers.smartmotor.kernel import jit, servo
from axistwin.core.errors import MissingExtraError, UsageError
from axistwin.core.storage import user_cache

needs_numba = pytest.mark.skipif(not jit.available(), reason="Numba is not installed")


@pytest.fixture
def afresh(monkeypatch):
    """Reset the setting before and after the test."""
    forget()
    yield monkeypatch
    forget()


def forget():
    for function in (jit.setting, jit.available, jit._numba):
        function.cache_clear()


def test_a_sampled_function_stays_what_it_is():
    assert isinstance(servo.rotate, FunctionType) and servo.slowed(3.0, 1.0) == 2.0


def test_off_means_plain_python(afresh):
    afresh.setenv("AXISTWIN_JIT", "off")
    assert not jit.available() and jit.best(servo.rotate) is servo.rotate
    assert jit.note() == ""


def test_without_numba_it_is_slow_and_programs_can_say_so(afresh, caplog):
    afresh.delenv("AXISTWIN_JIT", raising=False)
    afresh.setitem(sys.modules, "numba", None)
    with caplog.at_level(logging.INFO, "axistwin.smartmotor"):
        assert jit.best(servo.rotate) is servo.rotate and not jit.available()
    assert jit.note().startswith('SmartMotors run in plain Python, many times slower: pip install "numba')
    assert jit.note().endswith(', or in a clone pip install ".[fast]"')
    assert not caplog.records  # the note is not logged a second time


def test_on_without_numba_is_an_error(afresh):
    afresh.setenv("AXISTWIN_JIT", "on")
    afresh.setitem(sys.modules, "numba", None)
    with pytest.raises(MissingExtraError, match=r'needs numba: pip install "numba.*", or in a clone .*"\.\[fast\]"'):
        jit.best(servo.rotate)


def test_other_settings_do_not_exist(afresh):
    afresh.setenv("AXISTWIN_JIT", "yes")
    with pytest.raises(UsageError, match=r"^AXISTWIN_JIT=yes: expected one of auto, on, off$"):
        jit.available()


@needs_numba
def test_a_numba_that_does_not_work_is_told_in_one_line(afresh):
    afresh.setenv("AXISTWIN_JIT", "auto")
    assert jit.available()
    afresh.setitem(sys.modules, "numba", None)
    jit._numba.cache_clear()
    with pytest.raises(
        UsageError, match=r"^numba cannot be loaded \(.*\): install numba again, or set AXISTWIN_JIT=off$"
    ):
        jit.best(inner)


FACTOR, NOTE = 2, "a text"


def inner(x):
    return x + FACTOR


def outer(x):
    return 10 * inner(x)


def test_the_fingerprint_is_that_of_code_and_constants(monkeypatch):
    before = jit.fingerprint((inner, outer))
    assert jit.fingerprint((inner, outer)) == before
    monkeypatch.setitem(globals(), "NOTE", "another")
    assert jit.fingerprint((inner, outer)) == before
    monkeypatch.setitem(globals(), "FACTOR", 3)
    assert jit.fingerprint((inner, outer)) != before


def test_the_fingerprint_changes_with_any_function(monkeypatch):
    before = jit.fingerprint((inner, outer))
    monkeypatch.setattr(inner, "__code__", (lambda x: x - FACTOR).__code__)
    assert jit.fingerprint((inner, outer)) != before


@pytest.fixture
def only_these(monkeypatch, tmp_path):
    """Make `inner` and `outer` the only sampled functions, with an empty cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(jit, "_sampled", {})
    for function in ("_compiled", "_spaces"):  # the compiled kernel stays for other tests
        monkeypatch.setattr(jit, function, cache(getattr(jit, function).__wrapped__))
    jit.sampled(inner)
    jit.sampled(outer)
    return tmp_path / "cache"


def forget_compiled():
    jit._compiled.cache_clear()
    jit._spaces.cache_clear()


def machine_code(directory):
    return sorted(path.name.split("-")[0] for path in directory.rglob("*.nbi"))


@needs_numba
def test_compiled_functions_call_compiled_functions_and_are_kept(only_these):
    import numba

    assert jit.best(outer)(1) == 30 and outer(1) == 30
    assert machine_code(only_these) == ["test_jit.outer"] and numba.config.CACHE_DIR == ""
    assert "numba" not in outer.__module__ and outer.__globals__["inner"] is inner


@needs_numba
def test_a_changed_callee_is_compiled_anew(only_these, monkeypatch):
    assert jit.best(outer)(1) == 30
    monkeypatch.setattr(inner, "__code__", (lambda x: x * FACTOR).__code__)
    forget_compiled()
    assert jit.best(outer)(5) == 100
    monkeypatch.setitem(globals(), "FACTOR", 3)
    forget_compiled()
    assert jit.best(outer)(5) == 150 and len(list((only_these / "axistwin").iterdir())) == 3


@needs_numba
def test_nowhere_to_keep_it_is_no_error(only_these, tmp_path):
    (tmp_path / "cache").write_text("a file is no directory")
    assert jit.best(outer)(1) == 30


@needs_numba
@pytest.mark.parametrize("suffix", ["nbc", "nbi"])
def test_machine_code_that_is_damaged_is_compiled_again(only_these, suffix):
    assert jit.best(outer)(1) == 30
    for file in only_these.rglob(f"*.{suffix}"):
        file.write_bytes(file.read_bytes()[:100])
    forget_compiled()
    assert jit.best(outer)(1) == 30 and machine_code(only_these) == ["test_jit.outer"]


@needs_numba
def test_that_it_is_compiled_is_told_once(only_these, caplog):
    with caplog.at_level(logging.INFO, "axistwin.smartmotor"):
        assert jit.best(outer)(1) == 30
        forget_compiled()
        assert jit.best(outer)(1) == 30
    assert [record.getMessage() for record in caplog.records] == [jit.COMPILING]


@needs_numba
def test_caches_that_nobody_uses_are_removed(only_these):
    old = only_these / "axistwin" / "smartmotor-0123456789abcdef"
    old.mkdir(parents=True)
    os.utime(old, (0, 0))
    assert jit.best(outer)(1) == 30 and not old.exists()


@needs_numba
def test_a_cache_directory_that_is_not_absolute_is_ignored(monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    assert user_cache().is_absolute()
