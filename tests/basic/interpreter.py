"""PC-BASIC without a screen: run a program, type keys at its prompts, and return what it prints."""

import asyncio
import os
import sys
from asyncio.subprocess import DEVNULL, PIPE, Process
from collections.abc import Awaitable, Callable, Mapping
from pathlib import Path

TIED_LINES = Path(__file__).with_name("tied_lines.py")
SECONDS = 300
"""No program takes so long; one that does hangs."""

Patience = Callable[[], Awaitable[object]]
"""What a person does between the prompt and the key."""


async def run_basic(
    program: str, com1: str, keys: Mapping[str, str], patience: Patience, directory: Path, seconds: float = SECONDS
) -> str:
    """Run a program to its END or STOP; return everything that it has printed.

    `com1`: the device at COM1, in PC-BASIC's syntax.  `keys`: the answer to each prompt.  `directory`: an empty one,
    for the program and for files of PC-BASIC.  `seconds`: the time limit.
    """
    file = directory / "PROGRAM.BAS"
    file.write_bytes(program.encode("ascii"))
    basic = await _start("--interface=none", f"--load={file}", "--exec=RUN", "--quit", f"--com1={com1}", home=directory)
    screen: list[str] = []
    try:
        async with asyncio.timeout(seconds):
            await _converse(basic, screen, dict(keys), patience)
            await basic.wait()
    except TimeoutError:
        raise AssertionError(f"the program hangs; it has printed {''.join(screen)!r}") from None
    finally:
        if basic.returncode is None:
            basic.kill()
            await basic.wait()
    return "".join(screen)


async def _start(*options: str, home: Path) -> Process:
    homes = dict.fromkeys(("HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME"), str(home))
    # The only message on stderr is that PC-BASIC cannot save its session, which is not needed.
    starter = [str(TIED_LINES)] if any("=PORT:" in option for option in options) else ["-m", "pcbasic"]
    return await asyncio.create_subprocess_exec(
        *(sys.executable, *starter, *options), env=os.environ | homes, stdin=PIPE, stdout=PIPE, stderr=DEVNULL
    )


async def _converse(basic: Process, screen: list[str], keys: dict[str, str], patience: Patience) -> None:
    assert basic.stdin is not None and basic.stdout is not None
    while printed := await basic.stdout.read(1000):
        screen.append(printed.decode("cp437").replace("\r\n", "\n"))
        for prompt in [prompt for prompt in keys if prompt in "".join(screen)]:
            await patience()
            basic.stdin.write(keys.pop(prompt).encode("ascii"))
            await basic.stdin.drain()
