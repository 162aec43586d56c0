"""The IF2's battery RAM on disk: `bench.add("if2", state=directory)`, and its contents after a crash.

Crashes come at each call to the operating system in turn, as an exception that nothing catches; and in separate
processes as a real SIGKILL, at such a call or partway through a write.
"""

import gc
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import axistwin
from axistwin import AxistwinError, Bench
from axistwin.bench import Controller

from .talking import ask, command, detect, play, ready, send


class Crash(BaseException):
    """Raised instead of a system call, to end the process at this call."""


def store(directory: Path, steps: int, name: str = "if2") -> Controller:
    """Store a sequence that moves X by `steps` in a locked IF2 with this state directory."""
    bench = Bench()
    if2 = bench.add("if2", name, state=directory)
    if if2.serial.host.dtr:
        detect(bench, if2)
    play(bench, if2, f"* -> U<CR>; U61; 1.2 s; :H1:X{steps}@400:$; 0.1 s; [; 0.1 s")
    return if2


def switched_on(directory: Path, name: str = "if2") -> tuple[Bench, Controller]:
    """Return an IF2 with this state directory after its self-test; DSR is low."""
    bench = Bench()
    if2 = bench.add("if2", name, state=directory, wiring="3-wire")
    bench.run(1.1)
    return bench, if2


def stored_steps(directory: Path, name: str = "if2") -> int | None:
    """Return the number of steps of X in the sequence that a new process loads, or None if nothing is locked."""
    bench, if2 = switched_on(directory, name)
    if ask(bench, if2, "E", 0.1) != b"[\r":
        return None
    if2.pins["input1"].drive(True)
    bench.run(20.0)
    return if2.axes["X"].position


def test_another_bench_finds_what_was_locked(tmp_path):
    """Storing: a locked sequence is "retained with power removed", and also when the program ends."""
    store(tmp_path / "deep" / "down", 123)
    assert (stored_steps(tmp_path / "deep" / "down"), stored_steps(tmp_path / "deep" / "down")) == (123, 123)


def test_without_a_state_directory_nothing_is_left_behind(tmp_path, monkeypatch):
    """With `state=None` the memory exists as long as the bench, and no file is written."""
    monkeypatch.chdir(tmp_path)
    bench = Bench()
    command(bench, ready(bench, model="if2"), "[", seconds=0.1)
    assert list(tmp_path.iterdir()) == []


def test_controllers_of_different_names_do_not_meet(tmp_path):
    """Controllers of different names in one directory have a file each."""
    store(tmp_path, 10, "left")
    store(tmp_path, 20, "right")
    assert (stored_steps(tmp_path, "left"), stored_steps(tmp_path, "right")) == (10, 20)
    assert stored_steps(tmp_path, "other") is None


@pytest.mark.parametrize(("dsr", "script"), [("low", "1.1 s; ]; 0.1 s"), ("high", "detect; * -> U<CR>")])
def test_unlocking_and_erasing_are_on_disk_too(tmp_path, dsr, script):
    """Breaking: "may also be used to erase stored sequence statements in the RAM".

    Storing: unlocking is written to disk, because only locked data are kept.
    """
    store(tmp_path, 10)
    bench = Bench()
    play(bench, bench.add("if2", state=tmp_path, wiring="3-wire" if dsr == "low" else "5-wire"), script)
    assert stored_steps(tmp_path) is None


def test_an_if1_leaves_nothing_that_matters(tmp_path):
    """R31: an IF1 has no battery, and a state directory gives it none."""
    for script in ("X10@400$; idle; [; 0.1 s", "E: C"):
        bench = Bench()
        play(bench, ready(bench, state=tmp_path), script)


# Crashes


def crash_at(monkeypatch: pytest.MonkeyPatch, moment: int) -> list[str]:
    """Let the process end at this call to the operating system; return the list of the calls made."""
    made: list[str] = []

    def deadly(function, name):
        def call(*args, **kwargs):
            if len(made) >= moment:
                raise Crash
            made.append(name)
            return function(*args, **kwargs)

        return call

    for name in ("replace", "rename", "fsync", "open", "close", "unlink", "mkdir", "write"):
        monkeypatch.setattr(os, name, deadly(getattr(os, name), name))
    monkeypatch.setattr(Path, "open", deadly(Path.open, "Path.open"))
    return made


def lock_anew(if2: Controller, bench: Bench, steps: int) -> None:
    """Unlock, send another sequence, and lock: three messages."""
    for text in ("]", "#", f":H1:X{steps}@400:$", "["):
        command(bench, if2, text, seconds=0.1)


@pytest.mark.parametrize("moment", range(24))
def test_a_crash_at_any_call_leaves_the_old_or_the_new_contents(tmp_path, monkeypatch, moment):
    """ "a file written so that a crash at any moment leaves the old or the new contents, never a mixture"."""
    store(tmp_path, 10)
    bench, if2 = switched_on(tmp_path)
    gc.disable()  # the locks of earlier tests, in garbage, must not be released by the replaced calls
    with monkeypatch.context() as patch:
        made = crash_at(patch, moment)
        try:
            lock_anew(if2, bench, 20)
        except Crash:
            crashed = True
        else:
            crashed = False
    gc.enable()
    assert len(made) <= moment
    # the old contents (10 steps), nothing (unlocked in between), or the new contents (20 steps)
    assert stored_steps(tmp_path) in ((10, None, 20) if crashed else (20,))
    store(tmp_path, 30)  # the remains do not prevent another store
    assert stored_steps(tmp_path) == 30


def test_the_contents_are_on_the_disk_before_they_take_the_place_of_the_old_ones(tmp_path, monkeypatch):
    """In another order, a power failure of the computer could leave an empty file under the old name."""
    store(tmp_path, 10)
    bench, if2 = switched_on(tmp_path)
    with monkeypatch.context() as patch:
        made = crash_at(patch, 1000)
        lock_anew(if2, bench, 20)
    moves = [n for n, name in enumerate(made) if name in ("replace", "rename")]
    assert moves and all("fsync" in made[max(0, n - 3) : n] for n in moves)


@pytest.mark.parametrize("rest", [b"", b"{", b'{\n "locked": true,\n "baudr', b"\0" * 4096])
def test_half_a_file_left_beside_is_no_hindrance(tmp_path, rest):
    """A crash during a write leaves half a file under another name, which has no effect."""
    store(tmp_path, 10)
    known = set(tmp_path.glob("*.json*"))
    for file in known:
        file.with_name(file.name + ".new").write_bytes(rest)
    assert stored_steps(tmp_path) == 10
    store(tmp_path, 20)
    assert stored_steps(tmp_path) == 20 and set(tmp_path.glob("*.json*")) == known


KILLED = """
import gc, os, resource, signal, sys
from axistwin import Bench

def switch_on():
    bench = Bench()
    if2 = bench.add("if2", state=sys.argv[1], wiring="3-wire")
    if2.pins["input1"].drive(True)
    bench.run(1.1)
    return bench, if2

def say(bench, if2, text, seconds=0.1):
    if2.serial.write(text.encode())
    bench.run(seconds)
    return if2.serial.read()

def lock(steps, hook):
    bench, if2 = switch_on()
    say(bench, if2, "(")  # a locked one ignores this
    say(bench, if2, "U61\\r", 1.2)
    for text in ("]", "#", f":H1:X{steps}@400:$"):
        say(bench, if2, text + "\\r")
    hook()
    say(bench, if2, "[\\r")

def found():
    bench, if2 = switch_on()
    bench.run(10.0)
    return if2.axes["X"].position if say(bench, if2, "E\\r") == b"[\\r" else None

def killed_after_bytes(count):
    signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (count, count))

def killed_at_call(number):
    left = [number]
    def audit(event, args):
        if event in ("open", "os.rename", "os.remove", "os.mkdir", "os.truncate"):
            left[0] -= 1
            if left[0] < 0:
                os.kill(os.getpid(), signal.SIGKILL)
    sys.addaudithook(audit)

def child(steps, hook):
    gc.collect()  # the directory is free when no bench uses it any more
    pid = os.fork()
    if pid == 0:
        lock(steps, hook)
        os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])

steps = 1
for hook, points in ((killed_after_bytes, (0, 1, 2, 50, 100, 200, 300, 10**6)), (killed_at_call, range(6))):
    for point in points:
        steps += 1
        code = child(steps, lambda: hook(point))
        print(hook.__name__, point, code, found(), steps)
        assert child(steps, lambda: None) == 0
        assert found() == steps
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs processes that can be killed in the middle of a write")
def test_a_killed_process_leaves_the_old_or_the_new_contents(tmp_path):
    """Real processes, killed after a number of bytes or system calls, leave the old or the new contents too."""
    store(tmp_path, 1)
    gc.collect()
    done = subprocess.run(
        [sys.executable, "-c", KILLED, str(tmp_path)],
        capture_output=True,
        text=True,
        timeout=50,
        check=False,
        env={**os.environ, "PYTHONPATH": str(Path(axistwin.__file__).parents[1])},
    )
    assert done.returncode == 0, done.stderr
    lines = [line.split() for line in done.stdout.splitlines()]
    for _, _, code, found, new in lines:
        # the unlock command was already on disk
        assert (code, found) in (("-9", "None"), ("-9", new), ("-25", "None"), ("0", new))
    assert len(lines) == 14 and sum(code != "0" for _, _, code, _, _ in lines) >= 9


# A directory that cannot be used


def test_a_state_directory_that_is_a_file_is_told_in_one_line(tmp_path):
    """The error names place and remedy, without a traceback."""
    (tmp_path / "file").write_text("")
    with pytest.raises(AxistwinError, match=r"^[^\n]*file[^\n]*$"):
        Bench().add("if2", state=tmp_path / "file")


@pytest.mark.parametrize("contents", [
    b"", b"{}", b"[]", b"null", b"\xff\xfe", b'{"locked": true}', b'{"locked": "yes"}', b"{" * 3000,
    b'{"locked": true, "baudrate": -5, "frame": {}, "parameters": {}, "sequence": 7}'])  # fmt: skip
def test_a_file_that_is_not_ours_is_told_in_one_line(tmp_path, contents):
    """For a file that is edited or foreign, the error names place and remedy, without a traceback."""
    store(tmp_path, 10)
    (file,) = tmp_path.glob("*.json")
    file.write_bytes(contents)
    with pytest.raises(AxistwinError, match=rf"^[^\n]*{file.name}[^\n]*$"):
        stored_steps(tmp_path)


def test_an_image_that_does_not_tell_how_the_lock_command_came_is_unlocked_by_any(tmp_path):
    """An image of an earlier version has no `lock`; any unlock command unlocks it."""
    store(tmp_path, 10)
    (file,) = tmp_path.glob("*.json")
    image = json.loads(file.read_text())
    assert image.pop("lock") == {"baudrate": 9600, "bytesize": 8, "parity": "N", "eighth": [False, False]}
    file.write_text(json.dumps(image))
    bench, if2 = switched_on(tmp_path)
    assert send(bench, if2, "]", "E", seconds=0.1) == b"E\r"


def test_a_directory_in_the_place_of_the_file_is_told_in_one_line(tmp_path):
    (tmp_path / "if2.json").mkdir()
    with pytest.raises(AxistwinError, match=r"^[^\n]*$"):
        store(tmp_path, 10)
