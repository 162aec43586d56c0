"""Asynchronous tests of sessions run on an event loop with a fake clock, or as their module's `run` says."""

from inspect import iscoroutinefunction

import pytest

from .driving import drive


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    if not iscoroutinefunction(pyfuncitem.obj):
        return None
    arguments = {name: pyfuncitem.funcargs[name] for name in pyfuncitem._fixtureinfo.argnames}
    getattr(pyfuncitem.module, "run", drive)(pyfuncitem.obj(**arguments))
    return True
