"""State directories of controllers if the disk, or another process, prevents reading or writing.

Separate processes hold a directory, are killed, or have no space left; in this process system calls are refused.
"""

import gc
import json
import logging
import os
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

import axistwin
from axistwin import Bench
from axistwin.bench import Controller
from axistwin.cli.program import main
from axistwin.core.errors import AxistwinError, UsageError
from axistwin.core.storage import HOLDER, LOCK, FileStore, MemoryStore, excerpt, write_whole

from . import command
from .digiplan.talking import ready, write

ENV = {**os.environ, "PYTHONPATH": str(Path(axistwin.__file__).parents[1])}
NO_SPACE = OSError(28, "No space left on device")


MACHINE = """
import sys
from axistwin import Bench

bench = Bench()
bench.add("if2", state=sys.argv[1])
print("up", flush=True)
input()
"""


@contextmanager
def holding(directory):
    """Start another process that has a controller with the directory `directory / "state"`."""
    program = directory / "machine.py"
    program.write_text(MACHINE)
    command = [sys.executable, program, "state", "--token", "secret"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=ENV, cwd=directory) as process:
        assert process.stdout is not None and process.stdout.readline() == b"up\n"
        yield process
        process.kill()


@pytest.fixture(scope="module")
def other_process(tmp_path_factory):
    directory = tmp_path_factory.mktemp("other")
    with holding(directory) as process:
        yield process.pid, directory / "state"


@pytest.fixture
def other(other_process):
    """Return the number of another process and its state directory; its note is restored after the test."""
    note = (other_process[1] / HOLDER).read_bytes()
    yield other_process
    (other_process[1] / HOLDER).write_bytes(note)


def refused(monkeypatch: pytest.MonkeyPatch, directory: Path, error: OSError) -> None:
    replace = os.replace

    def refusing(source, target):
        if Path(target).parent == directory:
            raise error
        replace(source, target)

    monkeypatch.setattr(os, "replace", refusing)


def warnings(caplog: pytest.LogCaptureFixture) -> list[str]:
    return [record.message for record in caplog.records if record.levelno >= logging.WARNING]


def stored(file: Path) -> str:
    sequence = json.loads(file.read_text())["sequence"]
    assert isinstance(sequence, str)
    return sequence


def lock(bench: Bench, if2: Controller, sequence: str) -> None:
    for text in ("]", sequence, "["):
        write(if2, text)
        bench.run(0.1)


# One process


def test_a_second_process_is_told_of_the_first_in_one_line(other):
    """The message names the first process and its program, without its options, which may be secret."""
    number, state = other
    message = (
        f"state directory {state} is in use by process {number} (machine.py state): "
        "end that process, or choose another directory"
    )
    with pytest.raises(UsageError) as told:
        Bench().add("smartmotor", state=state)
    assert str(told.value) == message
    assert command.refused("serve", "if2", "--tcp", ":0", "--state", state) == (2, f"axistwin: {message}\n")


def test_a_process_that_is_killed_lets_go(tmp_path):
    with holding(tmp_path) as process:
        process.send_signal(signal.SIGKILL)
    Bench().add("if2", state=tmp_path / "state")
    assert (tmp_path / "state" / HOLDER).read_text().startswith(f"{os.getpid()} ")


def test_controllers_of_one_process_share_a_directory(tmp_path):
    bench, another = Bench(), Bench()
    for name in ("left", "right"):
        bench.add("if2", name, state=tmp_path)
        another.add("smartmotor", name, state=str(tmp_path / "." / "..") + f"/{tmp_path.name}")


HOLDS = "import sys, axistwin; axistwin.Bench().add('if2', state=sys.argv[1])"


def holds(directory: Path) -> bool:
    tried = subprocess.run([sys.executable, "-c", HOLDS, directory], capture_output=True, check=False, env=ENV)
    return tried.returncode == 0


@pytest.mark.slow
def test_the_directory_is_free_when_the_last_of_its_controllers_has_gone(tmp_path):
    left, right = Bench(), Bench()
    left.add("if2", "left", state=tmp_path)
    right.add("if2", "right", state=tmp_path)
    del left
    gc.collect()
    assert not holds(tmp_path)
    del right
    gc.collect()
    assert holds(tmp_path)


@pytest.mark.parametrize("note", [b"", b"\xff\xfe", b"1", b"1 \n", b"1 " + b"x\x1b\n" * 5000, None])
def test_whatever_stands_in_the_note_of_who_holds_it_it_is_one_short_line(other, note):
    """The note in the file is for the user; the lock itself is the operating system's."""
    _, state = other
    (state / HOLDER).unlink()
    if note is not None:
        (state / HOLDER).write_bytes(note)
    with pytest.raises(UsageError) as told:
        Bench().add("if2", state=state)
    assert str(told.value).isprintable() and len(str(told.value)) < len(str(state)) + 200
    assert "in use by " in str(told.value)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_the_child_of_a_fork_is_a_process_of_its_own(tmp_path):
    Bench().add("if2", state=tmp_path)
    child = os.fork()
    if child == 0:
        try:
            Bench().add("if2", "other", state=tmp_path)
        except UsageError as error:
            os._exit(3 if f"process {os.getppid()} " in str(error) else 4)
        os._exit(5)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 3 and not holds(tmp_path)


# Whole files


def test_a_file_that_is_replaced_keeps_its_permissions(tmp_path):
    file = tmp_path / "a"
    file.write_bytes(b"old")
    file.chmod(0o640)
    write_whole(file, b"new")
    assert (file.read_bytes(), file.stat().st_mode & 0o777) == (b"new", 0o640) and list(tmp_path.iterdir()) == [file]


def test_two_writers_do_not_meet_in_one_name(tmp_path, monkeypatch):
    """Each writer renames only the file that it has written, even if another one begins meanwhile."""
    file, fsync, left = tmp_path / "a.json", os.fsync, ["second"]

    def fsync_after_another(descriptor):
        if left:
            write_whole(file, left.pop().encode())
        fsync(descriptor)

    monkeypatch.setattr(os, "fsync", fsync_after_another)
    write_whole(file, b"first")
    assert file.read_bytes() == b"first" and list(tmp_path.iterdir()) == [file]


def test_what_could_not_be_written_is_not_left_behind(tmp_path, monkeypatch):
    refused(monkeypatch, tmp_path, NO_SPACE)
    with pytest.raises(OSError, match="No space"):
        write_whole(tmp_path / "a", b"1")
    assert list(tmp_path.iterdir()) == []


def test_what_a_killed_process_left_is_removed_and_nothing_else(tmp_path):
    for name in ("if2.json.0a1b.new", "if2.json.new", f"{HOLDER}.99.new", "if2.json.bak", "other.json.1.new"):
        (tmp_path / name).write_text("half")
    Bench().add("if2", state=tmp_path)
    assert {file.name for file in tmp_path.iterdir()} == {LOCK, HOLDER, "if2.json.bak", "other.json.1.new"}


# A directory that cannot be written, from the beginning


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs a directory in which nobody can write")
def test_a_directory_that_cannot_be_written_is_told_at_the_start():
    with pytest.raises(UsageError, match=r"^cannot write state directory /proc/self \(.*\): choose another directory$"):
        Bench().add("if2", state="/proc/self")


@pytest.mark.parametrize("error", [NO_SPACE, OSError(30, "Read-only file system")])
def test_a_disk_that_is_full_is_told_at_the_start(tmp_path, monkeypatch, error):
    refused(monkeypatch, tmp_path, error)
    with pytest.raises(AxistwinError) as told:
        Bench().add("if2", state=tmp_path)
    assert (
        str(told.value)
        == f"cannot write state directory {tmp_path} ({error.strerror.lower()}): choose another directory"
    )
    monkeypatch.undo()
    Bench().add("if2", state=tmp_path)  # the lock of the directory has been released


# A disk that becomes full


def test_a_controller_keeps_its_memory_in_ram_until_it_is_switched_off(tmp_path, monkeypatch, caplog):
    """The last complete image remains on disk; the first failure is reported, and the total at the end."""
    bench = Bench()
    if2 = ready(bench, model="if2", state=tmp_path)
    file = tmp_path / "if2.json"
    lock(bench, if2, ":X10:$")
    assert stored(file) == ":X10:$"
    refused(monkeypatch, tmp_path, NO_SPACE)
    bench.run(1)
    lock(bench, if2, ":X20:$")
    assert warnings(caplog) == [
        f"{file} cannot be written: no space left on device: the memory is in RAM only until the power is off"
    ]
    assert stored(file) == ":X10:$"
    bench.run(1)
    before = if2.axes["X"].position
    write(if2, "]")
    write(if2, ":$")
    bench.run(1)
    assert if2.axes["X"].position == before + 20
    if2.power(False)
    assert len(warnings(caplog)) == 2
    # written: the lock (nothing was locked before); not written: unlock, lock, unlock
    assert warnings(caplog)[1] == f"{file}: 3 of 4 writes failed: the file has the contents of the last complete write"
    if2.power(True)
    assert "X10" in "".join(if2.programs["sequence"].lines)
    assert {path.name for path in tmp_path.iterdir()} == {LOCK, HOLDER, "if2.json"}


def test_the_others_notice_nothing(tmp_path, monkeypatch):
    """A full disk of one controller does not affect others, on the same bench or on the same disk."""

    def session(full: Path | None) -> list[object]:
        bench = Bench()
        motors = [bench.add("smartmotor", name, state=tmp_path / f"{full is None}" / name) for name in ("a", "b")]
        if full is not None:
            refused(monkeypatch, full, NO_SPACE)
        for motor in motors:
            motor.serial.write(b"a=7 VST(a,1) a=9 EPTR=0 VLD(a,1) Ra ")
        bench.run(1)
        return [motors[1].serial.read(), motors[0].serial.read(), bench.now]

    assert session(tmp_path / "False" / "a") == session(None) and not (tmp_path / "False" / "a" / "a.json").exists()
    assert (tmp_path / "False" / "b" / "b.json").read_bytes() == (tmp_path / "True" / "b" / "b.json").read_bytes()


def test_a_reset_by_command_is_no_loss_of_power(tmp_path, monkeypatch):
    """Z of a SmartMotor restarts it with the contents of its RAM."""
    bench = Bench()
    motor = bench.add("smartmotor", state=tmp_path)
    bench.run(1)
    refused(monkeypatch, tmp_path, NO_SPACE)
    motor.serial.write(b"EPTR=0 a=7 VST(a,1) Z ")
    bench.run(1)
    motor.serial.read()
    motor.serial.write(b"EPTR=0 VLD(a,1) Ra ")
    bench.run(1)
    assert motor.serial.read() == b"7\r"
    motor.power_cycle()
    bench.run(1)
    motor.serial.write(b"EPTR=0 VLD(a,1) Ra ")
    bench.run(1)
    assert motor.serial.read() == b"-1\r"


def test_what_has_room_again_when_the_power_goes_is_kept(tmp_path, monkeypatch, caplog):
    store = FileStore(tmp_path / "a.json")
    store.save(b"1")
    with monkeypatch.context() as patch:
        refused(patch, tmp_path, NO_SPACE)
        store.save(b"2")
        assert store.load() == b"2"
    store.end()
    assert (tmp_path / "a.json").read_bytes() == b"2" == store.load()
    assert warnings(caplog)[1:] == [f"{store}: 1 of 2 writes failed: the file is up to date again"]
    store.end()
    assert len(warnings(caplog)) == 2


def test_each_time_it_is_switched_on_it_is_told_again(tmp_path, monkeypatch, caplog):
    store = FileStore(tmp_path / "a.json")
    refused(monkeypatch, tmp_path, NO_SPACE)
    for contents in (b"1", b"2"):
        store.save(contents)
        store.save(contents)
        store.end()
        assert store.load() is None
    told = "no space left on device: the memory is in RAM only until the power is off"
    assert [line.partition(": ")[2] for line in warnings(caplog)] == [
        told, "2 of 2 writes failed: there is no file", told, "4 of 4 writes failed: there is no file",
    ]  # fmt: skip


def test_a_disk_that_cannot_be_read_any_more_stops_nobody(tmp_path, caplog):
    """The file is replaced by a directory while the controller runs."""
    bench = Bench()
    if2 = ready(bench, model="if2", state=tmp_path)
    lock(bench, if2, ":X10:$")
    file = tmp_path / "if2.json"
    file.unlink()
    file.mkdir()
    if2.power_cycle()
    assert len(warnings(caplog)) == 2 and "X10" in "".join(if2.programs["sequence"].lines)


FULL = """
import resource, signal, sys
from axistwin import Bench

bench = Bench()
motors = [bench.add("smartmotor", name, state=f"{sys.argv[1]}/{name}") for name in "ab"]
bench.run(1)
def say(text):
    for motor in motors:
        motor.serial.write(text)
    bench.run(1)
    print([motor.serial.read() for motor in motors])
say(b"EPTR=0 a=7 VST(a,1) ")
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (10, 10))
say(b"EPTR=0 a=8 VST(a,1) EPTR=0 VLD(a,1) Ra ")
say(b"RP ")
for motor in motors:
    motor.power(False)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="needs a limit of the system on files")
def test_a_real_limit_on_the_size_of_files(tmp_path):
    """The operating system cuts every write after 10 bytes."""
    command = [sys.executable, "-c", FULL, tmp_path]
    ended = subprocess.run(command, capture_output=True, text=True, check=False, env=ENV)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.splitlines() == ["[b'', b'']", r"[b'8\r', b'8\r']", r"[b'0\r', b'0\r']"]
    assert ended.stderr.count("file too large") == 2 and ended.stderr.count("1 of 2 writes failed") == 2
    for name in "ab":
        assert json.loads((tmp_path / name / f"{name}.json").read_text())["eeprom"] == "00000007"
        assert {path.name for path in (tmp_path / name).iterdir()} == {LOCK, HOLDER, f"{name}.json"}


def test_a_run_tells_and_counts_what_it_could_not_keep(tmp_path, monkeypatch, caplog):
    """`axistwin run` reports and counts failed writes, although it ends without switching off."""
    program = tmp_path / "p.sms"
    program.write_text("a=5\nVST(a,1)\nEND\n")
    replace, left = os.replace, [2]

    def full_soon(source, target):
        if Path(target).name == "smartmotor.json":
            left[0] -= 1
            if left[0] < 0:
                raise NO_SPACE
        replace(source, target)

    monkeypatch.setattr(os, "replace", full_soon)
    with pytest.raises(SystemExit) as ended:
        main(["run", "smartmotor", str(program), "--state", str(tmp_path / "state"), "--for", "1"])
    assert ended.value.code == 1
    first, last = warnings(caplog)
    assert "smartmotor.json cannot be written: no space left on device" in first
    # loading the program takes two writes: when LOAD begins, and at its end
    assert last.endswith("smartmotor.json: 1 of 3 writes failed: the file has the contents of the last complete write")


# Images that are none

LONG = "x" * 5000
SPOILT = [
    f'{{"{LONG}": 1}}', f'{{"locked": true, "frame": {{"{LONG}": 1}}, "parameters": {{}}}}',
    f'{{"frame": {{}}, "parameters": {{"{LONG}\\n{LONG}": 1}}}}', f'{{"frame": {{}}, "parameters": {{}}, "{LONG}": 1}}',
    f'{{"frame": {{"terminator": "{LONG}"}}, "parameters": {{}}}}', "[" * 100_000, "9" * 5000, "1e" + "9" * 5000,
    f'{{"version": 1, "program": "\\ud800{LONG}", "broken": false, "locked": false, "eeprom": ""}}',
    f'{{"version": 1, "program": "", "broken": false, "locked": false, "eeprom": "{LONG}"}}',
    '"' + LONG, "\x00" * 5000, "{}" + "\x1b[31m" * 900,
]  # fmt: skip


@pytest.mark.parametrize("model", ["if2", "smartmotor"])
@pytest.mark.parametrize("contents", SPOILT)
def test_a_spoilt_image_is_refused_in_one_short_line(tmp_path, model, contents):
    file = tmp_path / f"{model}.json"
    file.write_text(contents)
    with pytest.raises(UsageError) as told:
        Bench().add(model, state=tmp_path)
    assert str(told.value).startswith(f"{file} is not a memory file of a") and "): delete " in str(told.value)
    assert str(told.value).isprintable() and len(str(told.value)) < len(str(file)) + 160


def test_an_image_without_end_is_not_read(tmp_path):
    with (tmp_path / "if2.json").open("wb") as file:
        file.truncate(1 << 40)
    remedy = "delete the file to start the controller without stored data"
    with pytest.raises(UsageError, match=rf"if2\.json is invalid \(larger than 1048576 bytes\): {remedy}$"):
        Bench().add("if2", state=tmp_path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes that have names")
def test_a_pipe_in_the_place_of_the_image_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "if2.json")
    with pytest.raises(UsageError, match=r"if2\.json: expected a regular file$"):
        Bench().add("if2", state=tmp_path)


def test_one_line():
    assert excerpt("a\n\tb\x00 c") == "a b c"
    assert excerpt("x" * 81) == "x" * 79 + "…" and excerpt("x" * 80) == "x" * 80


def test_what_is_kept_with_the_bench_is_never_lost():
    store = MemoryStore()
    store.save(b"1")
    store.end()
    assert store.load() == b"1"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs processes that can be killed")
def test_a_short_campaign_of_kills():
    """Two processes share one directory and are killed at random, as in `benchmarks/robustness/state_kills.py`."""
    script = Path(__file__).parents[1] / "benchmarks" / "robustness" / "state_kills.py"
    command = [sys.executable, script, "--seed", "3", "--rounds", "3"]
    ended = subprocess.run(command, capture_output=True, text=True, check=False, env=ENV)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ended.stdout.startswith("passed: 3 rounds, seed 3: 0 wrong in ")


@pytest.mark.skipif(sys.platform == "win32", reason="needs to know of dead processes")
def test_a_process_that_was_killed_is_not_named(other):
    """The note of a process that was killed may remain; a message must not name this process."""
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    (other[1] / HOLDER).write_text(f"{dead.pid} gone\n")
    with pytest.raises(UsageError, match="is in use by another process: end that process"):
        Bench().add("if2", state=other[1])
