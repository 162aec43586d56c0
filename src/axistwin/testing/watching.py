"""What goes wrong in a run without anybody saying so: errors in a device, a loop that never ends, memory that grows."""

import ctypes
import gc
import logging
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import CodeType, FrameType, FunctionType, ModuleType
from typing import Any

import simpy

from axistwin.bench import Bench

PATIENCE_S = 60.0  # Seconds of computing without any virtual time: also a slow computer has compiled a motor's code.
_LOOK_S = 0.05
_OF_THE_CHECKS = str(Path(__file__).parent)
_NOT_OF_A_DEVICE = (str(Path(__file__).resolve().parents[1]), str(Path(simpy.__file__).parent))


class Hang(BaseException):
    """Raised in the thread of a run that never ends; a device's `except Exception` does not stop it."""


@contextmanager
def no_hang(bench: Bench) -> Iterator[None]:
    """Raise AssertionError if no virtual time passes during a minute of computing."""
    thread, over, places = threading.get_ident(), threading.Event(), list[str]()

    def watch() -> None:
        seen_ns, since = -1, time.process_time()
        while not over.wait(_LOOK_S):
            if bench.now != seen_ns:
                seen_ns, since = bench.now, time.process_time()
            elif time.process_time() - since > PATIENCE_S:
                places.append(_place(bench, sys._current_frames().get(thread)))
                ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(Hang))
                return

    watcher = threading.Thread(target=watch, name="axistwin-watch", daemon=True)
    watcher.start()
    try:
        yield
    except Hang:
        raise AssertionError(
            f"{places[0]}: never ends: let time pass in each round of a loop, e.g. yield self.after(0.01)"
        ) from None
    finally:
        over.set()
        watcher.join()


def _place(bench: Bench, frame: FrameType | None) -> str:
    """Return the file and line that is computed, or where a procedure waits for a time of 0 s."""
    found = frame
    while found is not None and found.f_code.co_filename.startswith(_NOT_OF_A_DEVICE):
        found = None if found.f_code.co_filename.startswith(_OF_THE_CHECKS) else found.f_back
    if found is None:
        waiting = (_innermost(each) for one in bench.controllers.values() for each in one._abilities.procedures())
        found = next((one for one in waiting if one is not None), frame)
    return "a handler" if found is None else f"{Path(found.f_code.co_filename).name}:{found.f_lineno}"


def _innermost(process: Any) -> FrameType | None:
    generator = process._generator
    while inner := generator.gi_yieldfrom or (generator.gi_frame and generator.gi_frame.f_locals.get("steps")):
        generator = inner
    frame: FrameType | None = generator.gi_frame
    return frame


class _Kept(logging.Handler):
    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.words: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.words.append(record.getMessage())


@contextmanager
def no_errors() -> Iterator[None]:
    """Raise AssertionError with the first error in a device, which its bench reports and survives."""
    log, kept = logging.getLogger("axistwin.devices"), _Kept()
    log.addHandler(kept)
    before, log.propagate = log.propagate, False
    try:
        yield
    finally:
        log.removeHandler(kept)
        log.propagate = before
    if kept.words:
        raise AssertionError(kept.words[0])


@contextmanager
def calls(codes: set[CodeType]) -> Iterator[set[CodeType]]:
    """Yield the functions, of these, that have been called so far."""
    called: set[CodeType] = set()

    def note(frame: FrameType, event: str, _: Any) -> None:
        if event == "call" and frame.f_code in codes:
            called.add(frame.f_code)

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        yield called
    finally:
        sys.setprofile(before)


def code_of(function: Any) -> CodeType | None:
    """Return the code behind partial functions and methods."""
    while not hasattr(function, "__code__"):
        function = getattr(function, "func", None) or getattr(function, "__func__", None)
        if function is None:
            return None
    code: CodeType = function.__code__
    return code


def size_of(*roots: object) -> int:
    """Return the bytes of all that can be reached from some objects, without classes, modules and caches."""
    seen: set[int] = set()
    todo, total = list[object](roots), 0
    while todo:
        one = todo.pop()
        if id(one) in seen or isinstance(one, type | ModuleType | CodeType | logging.Logger):
            continue
        seen.add(id(one))
        with suppress(TypeError):
            total += sys.getsizeof(one)
        if isinstance(one, FunctionType):
            todo += [one.__closure__, one.__defaults__, one.__kwdefaults__]
        elif type(one).__name__ != "_lru_cache_wrapper":
            todo += gc.get_referents(one)
    return total
