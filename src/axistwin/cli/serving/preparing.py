"""Slow preparations of controllers while they are already served, such as the compiled code of SmartMotors.

A thread loads what is in the user's cache.  What is missing is compiled before in a child process, because the compiler
would hold the interpreter for up to a tenth of a second.  The controllers run in plain Python until then; the results
are the same.
"""

import gc
import logging
import os
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Event, Thread

from axistwin.bench import Bench, product
from axistwin.errors import UsageError

DELAY_S = 0.1
"""Time for the first answers, before the thread takes a share of the interpreter."""
SWITCH_S = 0.0005
"""Maximum time for which the thread keeps the interpreter, unless a library holds it for longer."""
CHILD = """
import os, sys
hasattr(os, "nice") and os.nice(10)
from axistwin.bench import product
product(sys.argv[1]).prepare(None, 1)
"""


@contextmanager
def preparing(bench: Bench, speed: float | None) -> Iterator[Event]:
    """Prepare the controllers of a bench in a thread; log notes for the user.  Yields an event for the end."""
    models = Counter(controller.product.model for controller in bench.controllers.values())
    for model in models:
        if note := product(model).note():
            logging.getLogger("axistwin").warning("%s", note)
    preparation = _Preparation(models, speed)
    thread = Thread(target=preparation.run, name="preparations", daemon=True)
    thread.start()
    try:
        yield preparation.ended
    finally:
        preparation.stop()
        thread.join()


class _Preparation:
    """The preparations of all models of a bench, one after the other."""

    def __init__(self, models: Counter[str], speed: float | None) -> None:
        self._models, self._speed = models, speed
        self._stopped = Event()
        self.ended = Event()
        """Set when all models are prepared."""

    def stop(self) -> None:
        """Stop after the present step; a child process is ended."""
        self._stopped.set()

    def run(self) -> None:
        """Prepare each model."""
        if self._stopped.wait(DELAY_S):
            return
        for model, number in self._models.items():
            if not product(model).prepared(self._speed, number):
                self._compile(model)
            if not self._stopped.is_set():
                self._prepare(model, number)
        self.ended.set()

    def _prepare(self, model: str, number: int) -> None:
        try:
            with _short_turns():
                product(model).prepare(self._speed, number)
        except UsageError as error:
            logging.getLogger("axistwin").warning("%s", error)

    def _compile(self, model: str) -> None:
        """Fill the user's cache in a child process; if that fails, `prepare` compiles in this process."""
        logging.getLogger("axistwin").info(
            "compiling for the %s takes some seconds, once for each version; until then it runs in plain Python", model
        )
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
        command = [sys.executable, "-c", CHILD, model]
        with subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as child:
            while child.poll() is None:
                if self._stopped.wait(0.05):
                    child.terminate()


@contextmanager
def _short_turns() -> Iterator[None]:
    """Let other threads have the interpreter often; a garbage collection of all new objects would hold it too long."""
    before_s = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH_S)
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()
        sys.setswitchinterval(before_s)
