"""A simulated board on a pseudo terminal, in real time: `python -m tests.standin.pty_board LINK PULSES`.

LINK becomes a symbolic link to the terminal.  At the end the pulses are written as JSON to the file PULSES.
"""

import json
import os
import select
import signal
import sys
import time
import tty
from contextlib import suppress
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
from tests.standin.small_board import SmallBoard


def main(link, pulses):
    master, slave = os.openpty()
    tty.setraw(master)
    tty.setraw(slave)
    os.symlink(os.ttyname(slave), link)
    with suppress(OSError, AttributeError):  # not permitted
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(20))  # a real board has a processor of its own
    board, begun, ended = SmallBoard(), time.monotonic(), []
    heard = begun  # time of the latest bytes
    board.levels |= {8: 1, 9: 1}
    signal.signal(signal.SIGTERM, lambda *_: ended.append(True))
    while not ended:
        ready, _, _ = select.select([master], [], [], 0.001)
        data = os.read(master, 4096) if ready else b""
        heard = time.monotonic() if data else heard
        board.run_to(time.monotonic() - begun)  # the clock must not be older than the bytes
        board.receive(data)
        if out := board.transmitted():
            os.write(master, out)
    Path(pulses).write_text(
        json.dumps(
            {"begun": begun, "heard": heard, "pulses": board.pulses, "levels": board.levels, "stop": board.shutdown}
        )
    )


main(*sys.argv[1:])
