"""A missing extra is reported in one line."""

import importlib
import sys

import pytest

from axistwin.core.errors import UsageError


def test_without_unicorn_an_8086_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "unicorn", None)
    monkeypatch.delitem(sys.modules, "axistwin.links.bus_hosts.x86", raising=False)
    with pytest.raises(UsageError, match=r'^needs unicorn: pip install "unicorn.*", or in a clone .*"\.\[x86\]"$'):
        importlib.import_module("axistwin.links.bus_hosts.x86")
