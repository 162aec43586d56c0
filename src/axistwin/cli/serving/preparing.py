"""Prepare controllers in the background while they are served, e.g. load the compiled code of SmartMotors.

A thread loads compiled code from the user's cache.  A child process first compiles missing code, because a compiler in
this process would block the interpreter for up to a tenth of a second.  The controllers run in plain Python until then;
the results are the same.
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
from axistwin.core.errors import UsageError

DELAY_S = 0.1  # Seconds before the thread starts, so that the first answers are not delayed.
SWITCH_S = 0.0005  # Longest time in seconds for which the thread keeps the interpreter, except in a library.
CHILD = """
import os, sys
hasattr(os, "nice") and os.nice(10)
from axistwin.bench import product
product(sys.argv[1]).prepare(None, 1)
"""


@contextmanager
def preparing(bench: Bench, speed: float | None) -> Iterator[Event]:
    """Prepare the code of the controllers in a background thread; yield an event that is set at its end."""
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
    def __init__(self, models: Counter[str], speed: float | None) -> None:
        self._models, self._speed = models, speed
        self._stopped = Event()
        self.ended = Event()  # Event that is set when all models are prepared.

    def stop(self) -> None:
        self._stopped.set()

    def run(self) -> None:
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
        """Compile the code of one model; a child process stores it in the user's cache directory."""
        logging.getLogger("axistwin").info(
            "compiling for the %s takes some seconds, once for each version; until then it runs in plain Python", model
        )
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
        command = [sys.executable, "-P", "-c", CHILD, model]
        with subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as child:
            while child.poll() is None:
                if self._stopped.wait(0.05):
                    child.terminate()


@contextmanager
def _short_turns() -> Iterator[None]:
    """Within a `with` block, let other threads run often, and delay garbage collection."""
    before_s = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH_S)
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()
        sys.setswitchinterval(before_s)
