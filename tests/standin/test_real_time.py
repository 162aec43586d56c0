"""Real-time priority of the process that drives motors."""

import os
import sys
import threading

import pytest

from axistwin.real.standin.real_time import PRIORITY, real_time_priority

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="SCHED_RR is Linux's")


@pytest.fixture
def policies(monkeypatch):
    """Calls of the operating system's function, which changes nothing here."""
    calls = []
    monkeypatch.setattr(os, "sched_setscheduler", lambda *call: calls.append(call))
    return calls


def test_all_threads_have_the_priority_and_lose_it_at_the_end(policies):
    end = threading.Event()
    thread = threading.Thread(target=end.wait)
    thread.start()
    try:
        with real_time_priority() as granted:
            assert granted
            param = os.sched_param(PRIORITY)
            assert (thread.native_id, os.SCHED_RR, param) in policies
            assert (threading.get_native_id(), os.SCHED_RR, param) in policies
            policies.clear()
        assert (thread.native_id, os.SCHED_OTHER, os.sched_param(0)) in policies
    finally:
        end.set()
        thread.join()


def test_without_permission_the_program_runs_as_before(policies, monkeypatch):
    def refuse(*call):
        policies.append(call)
        raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    with real_time_priority() as granted:
        assert not granted
    assert policies == [(0, os.SCHED_RR, os.sched_param(PRIORITY))]
