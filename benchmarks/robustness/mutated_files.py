"""Mutated files of the nine kinds that axistwin reads: each must give one clear line, no traceback and no hang.

    python benchmarks/robustness/mutated_files.py [--files 1000] [--seed 1] [--kinds toml,talk] [--keep DIR]

The full size is `--files 5000`; it takes some 15 minutes of processor time, the default about three.
Each file is given to every command that reads its kind, in this process: `check`, `run`, `plot`, `diff`, `replay`,
the loading of `serve`, and the language server.  Of scenes, `check` must accept exactly what can
be built.  The verdict is the last line; exit code 1 if anything was found.
"""

import argparse
import io
import random
import re
import shutil
import signal
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from time import process_time
from zlib import crc32

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

from axistwin import Bench, Scene
from axistwin.cli.program import execute
from axistwin.cli.serving.bench_and_ports import scene as served_scene
from axistwin.core.errors import AxistwinError, one_line
from axistwin.records.plots.trace_chart import of_trace
from axistwin.records.traces.reading import read as read_trace
from axistwin.records.traces.trace import tracing

ROOT = Path(__file__).resolve().parents[2]
BOUND_S = 10.0
"""Processor time that one command may take for one file, unless the file itself asks for more virtual time."""
WAITING = 30
"""Limit by the wall clock, as a multiple of the limit of processor time: no command may block."""
ASKED_FOR_S = 100.0
"""Virtual time after which a run counts as successful."""
LONGEST_LINE = 800
"""Longest message, in characters, including the path of the file."""
DRAWN = 50
KINDS = ("toml", "talk", "if1", "181x", "sms", "parquet", "vcd", "csv", "state")
DIGITS = ("9" * 30, "9" * 400, "-" + "9" * 400, "9" * 5000, "0." + "3" * 3000, "1e400", "1e999999999", "1e-999999999")
NUMBERS = (*DIGITS, "0", "-1", "1", "2147483648", "9223372036854775808", "-9223372036854775809", "0x7f", "1_0", "nan",
           "inf", "-0", "٣", "²", "1.5", ".5", "5.", "+7", "1,5")  # fmt: skip
WORDS = ('"', "'", "\\", "[", "]", "[" * 3000, "{" * 3000, "(" * 3000, "=", ";", ":", "\0", "\x1a", "\ufeff", "é", "€",
         "\u2028", "\r", "\n", "\n\n", "\t", " ", "#", "true", "null", "x" * 5000, "\\x", "\\xZZ", "$", "%s",
         "{0}")  # fmt: skip
LINES = {
    "toml": ('[[script]]\nat = 0.01\ndo = ["load a.sms", "power off"]', '[[fault]]\nkind = "lose"\nat = 0.01',
             "options = {}", "axes.X.limits = [-99999999999999999999, 5]", "seed = 1", '[[chain]]\nmotors = ["left"]'),
    "talk": ("; options: 'a", "; options: line=5", "; options: X=" + "[" * 3000, "; options: X.limits=[1,2]",
             "; patience: 1e400", "; on-for: " + "9" * 5000, "; line: 9600 9N1", "; model: if2", "; model: 1811",
             "! input1 high", "= X.position 5", "= clock 1e400", "+0.1", "! fault jam X at=9", "! break 1e300",
             '! fault stuck input1 low when="X passes ' + "9" * 5000 + '"', "! master 5 in 1", "! line 9 8N1"),
    "if1": ("X100$", "+0.1", "! input1 high", "U61", "((((", "! X.push 1e30", "+" + "9" * 5000),
    "181x": ("33 00 00 61 A8", "go_relative " + "9" * 5000, "! joystick 1e30", "+0.1", "83", "! write 0 33"),
    "sms": ("WHILE 1", "LOOP", "IF a", "ENDIF", "GOSUB" + "9" * 5000, "a=" + "9" * 5000, "PRINT(#" + "9" * 400 + ")",
            "C5", "aw[0] 1 2 3.", "a=" + "(" * 3000),
}  # fmt: skip
"""Lines of each kind that are worth inserting."""
_NUMBER = re.compile(r"[0-9]+(?:\.[0-9]+)?")


class TooLongError(BaseException):
    """The time limit of a command has passed."""


@dataclass
class Verdict:
    """Findings, with file and command."""

    files: Counter[str] = field(default_factory=Counter)
    refused: Counter[str] = field(default_factory=Counter)
    long: Counter[str] = field(default_factory=Counter)
    """Number of files that need more virtual time than the limit."""
    found: list[str] = field(default_factory=list)
    slowest: dict[str, tuple[float, str]] = field(default_factory=dict)

    def note(self, kind: str, what: str, path: Path, keep: Path | None) -> None:
        """Add a finding."""
        self.found.append(f"{path.name}: {what}")
        if keep is not None:
            keep.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, keep / f"{kind}-{len(self.found)}{path.suffix}")


# Mutations


def mutated(data: bytes, kind: str, chance: random.Random) -> bytes:
    """Return a text, or bytes, with one to four changes."""
    for _ in range(chance.randint(1, 4)):
        textual = kind != "parquet" and chance.random() < 0.8
        data = _text(data, kind, chance) if textual else _bytes(data, chance)
    return data


def _text(data: bytes, kind: str, chance: random.Random) -> bytes:
    text = data.decode("utf-8", "surrogateescape")
    lines = text.splitlines(keepends=True) or [""]
    at = chance.randrange(len(lines))
    match chance.randrange(7):
        case 0 | 1 if numbers := list(_NUMBER.finditer(text)):
            found = chance.choice(numbers)
            text = text[: found.start()] + chance.choice(NUMBERS) + text[found.end() :]
            return text.encode("utf-8", "surrogateescape")
        case 2:
            lines[at] = ""
        case 3:
            lines.insert(at, lines[chance.randrange(len(lines))])
        case 4 if kind in LINES:
            lines.insert(at, chance.choice(LINES[kind]) + "\n")
        case 5:
            place = chance.randrange(len(lines[at]) + 1)
            lines[at] = lines[at][:place] + chance.choice((*WORDS, *NUMBERS)) + lines[at][place:]
        case _:
            words = re.split(r"(\W+)", lines[at])
            words[chance.randrange(len(words))] = chance.choice(re.split(r"\W+", text))
            lines[at] = "".join(words)
    return "".join(lines).encode("utf-8", "surrogateescape")


def _bytes(data: bytes, chance: random.Random) -> bytes:
    at, length = chance.randrange(len(data) + 1), chance.choice((1, 1, 1, 2, 8, 64))
    match chance.randrange(4):
        case 0:
            return data[:at]
        case 1:
            return data[:at] + data[at + length :]
        case 2:
            return data[:at] + chance.randbytes(length) + data[at + length :]
        case _:
            return data[:at] + data[at : at + length] + data[at:]


def other_parquet(path: Path, out: Path, chance: random.Random) -> None:
    """Return a valid Parquet file from another program."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pq.read_table(path)
    about = dict(table.schema.metadata)
    signals = b"axistwin.signals"
    match chance.randrange(7):
        case 0:
            table = table.replace_schema_metadata(None)
        case 1:
            wrong = chance.choice(
                (b"", b"{", b"[]", b"[" * 3000, b"5", b'{"a": 5}', b'{"a": "wire"}', b"null", b"\xff")
            )
            table = table.replace_schema_metadata({**about, signals: wrong})
        case 2:
            table = table.drop_columns([chance.choice(table.column_names)])
        case 3:
            name = chance.choice(table.column_names)
            nulls = pa.nulls(len(table), table.schema.field(name).type)
            table = table.set_column(table.column_names.index(name), name, nulls)
        case 4:
            name = chance.choice(table.column_names)
            kind = chance.choice((pa.int32(), pa.float32(), pa.string(), pa.bool_(), pa.timestamp("ns"), pa.null()))
            made = pa.nulls(len(table), kind) if kind == pa.null() else pa.array([None] * len(table), kind)
            table = table.set_column(table.column_names.index(name), name, made)
        case 5:
            table = table.take(
                pa.array([chance.randrange(len(table)) for _ in range(chance.randrange(20))], pa.int64())
            )
        case _:
            kinds = about[signals].decode()
            for one in ("wire", "integer", "real", "string", "step"):
                kinds = kinds.replace(f'"{one}"', f'"{chance.choice(("wire", "integer", "real", "string", "odd"))}"')
            table = table.replace_schema_metadata({**about, signals: kinds.encode()})
    pq.write_table(table, out)


# Valid files


class Bases:
    """Valid files of each kind, the input of the mutations."""

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self._traces()
        self._states()

    def of(self, kind: str) -> list[Path]:
        """Return the files of a kind, in a fixed order."""
        talks = sorted((ROOT / "tests" / "conversations").glob("*.talk"))
        scenes = [ROOT / "examples" / "xy-table.toml", *sorted((ROOT / "examples").glob("*/scene.toml"))]
        return {
            "toml": [*scenes, _written(self.directory / "chain.toml", CHAIN)],
            "talk": [*talks, _written(self.directory / "motor.talk", MOTOR_TALK)],
            "if1": [ROOT / "examples" / "drill.if1", *sorted((ROOT / "examples").glob("*/*.if1"))],
            "181x": [*sorted((ROOT / "examples").glob("*/*.181x")), _written(self.directory / "a.181x", BOARD)],
            "sms": [*sorted((ROOT / "examples").glob("*/*.sms")), _written(self.directory / "a.sms", SOURCE)],
            "state": [self.directory / "if2.json", self.directory / "smartmotor.json"],
        }.get(kind, [self.directory / f"a.{kind}"])

    def _traces(self) -> None:
        for kind in ("csv", "vcd", "parquet"):
            bench = Bench()
            interface = bench.add("if1", X={"limits": (-50, 5000)})
            bench.add("smartmotor", "motor")
            with tracing(bench, self.directory / f"a.{kind}", ("default", "motor.RPE")):
                bench.run(1.3)
                for words in (b"(", b"U61\r", b"X40@1000S1$\r"):
                    interface.serial.write(words)
                    bench.run(0.5)

    def _states(self) -> None:
        bench = Bench()
        if2 = bench.add("if2", state=self.directory, wiring="3-wire", line="9600 8N1")
        motor = bench.add("smartmotor", state=self.directory)
        bench.run(1.5)
        for words in (b"(", b"U51\r", b":H1:X1000@500S1:$\r", b"[\r"):
            if2.serial.write(words)
            bench.run(1.5)
        motor.serial.write(b"EPTR=0 a=5 VST(a,3) UCI UDI ZS LOAD ")
        bench.run(0.2)
        motor.serial.write(b"a=1 END \xff\xff")
        bench.run(0.5)
        for controller in (if2, motor):
            controller.power(False)


CHAIN = """
seed = 7
[[controller]]
model = "smartmotor"
name = "left"
axes.shaft = { motor = "frame17", limits = [-5000, 5000], load = { inertia = 1e-5 } }
[[controller]]
model = "smartmotor"
name = "right"
options.statements_per_sample = 2
[[controller]]
model = "if2"
name = "table"
line = "9600 8N2"
options.wiring = "3-wire"
axes.X = { limits = [-100, 20000], home = [0, 10], encoder = { counts_per_rev = 4000, backlash = 3 } }
axes.Y.motor = { torque = [[0, 1.2], [5000, 0.4]], inertia = 1e-5 }
[[controller]]
model = "1811"
name = "board"
ports = ["bus://127.0.0.1:0"]
[[chain]]
motors = ["left", "right"]
ports = ["tcp://127.0.0.1:0"]
[[wire]]
from = "table.output1"
to = "table.input1"
delay_ms = 2.5
[[wire]]
from = "board.output1"
to = "left.A"
invert = true
[[fault]]
kind = "lose"
on = "table.serial"
at = 0.01
count = 3
[[fault]]
kind = "jam"
on = "table.X"
when = "table.X passes 1000 up"
duration = 0.5
[[fault]]
kind = "flip"
on = "table.serial"
when = "jam begins"
nth = 2
probability = 0.5
[[script]]
at = 0.02
on = "table"
do = ["input1 high", "X.load 0.2", "fault stuck input2 low duration=0.1"]
[[script]]
at = 0.03
on = "left"
do = ["A 2.5V", "master 4000 in 2", "ambient 40"]
"""
MOTOR_TALK = """; model: smartmotor
; options: shaft.motor=frame17 statements_per_sample=2
; patience: 2.5
+0.5
> UCI UDI ZS A=100 V=400000 MP O=0 P=300 G\\r
+0.2
! master 400 in 0.1
! A 2.5V
! ambient 40
! shaft.load 0.01
! fault jam shaft when="shaft passes 100 up" duration=0.01
! break 0.01
+0.2
> RPW a=5 Ra\\r
= clock 0.9
= shaft.position 300
"""
BOARD = """; hex and names
31 00 00 00 00 03 E8 00 03 D0 90
+0.05
go_relative 1000
! trigger1 high
! joystick 500
83
read_version
48 01 02 03
"""
SOURCE = """'a program with all kinds of things in it
UCI UDI ZS A=100 V=400000 MP O=0
aw[0] 0 100 200 300 400.
C1 a=0 WHILE a<5 P=a*100 G TWAIT a=a+1 LOOP
SWITCH a CASE 5 PRINT("five",#13,a) BREAK DEFAULT b=3 ENDS
IF a==5 GOSUB7 ELSEIF b GOTO1 ELSE b=-(a+2)*3 ENDIF
END
C7 b=b+1 WAIT=100 RETURN
"""


def _written(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


# Commands


Act = Callable[[Path], int]
"""A function that processes a file and returns the exit code."""


def command(*words: str) -> Act:
    """Return a function that runs a command of axistwin; `FILE` stands for the file."""
    return lambda path: execute([str(path) if word == "FILE" else word for word in words])


def conversation(path: Path) -> int:
    """Run `axistwin run` with the model of a conversation, default IF1."""
    found = re.search(r"; model: (\w+)", path.read_text(encoding="utf-8", errors="replace"))
    return execute(["run", found[1] if found else "if1", str(path)])


def plot(path: Path, out: str) -> int:
    """Run `axistwin plot`; drawing takes a second, so only one picture in `DRAWN` is drawn."""
    if crc32(path.read_bytes()) % DRAWN == 0:
        return execute(["plot", str(path), "-o", out])
    of_trace(read_trace(path), ("*",), None, None, path.name)
    return 0


def editing(path: Path) -> int:
    """Run the functions of the language server for an opened text."""
    from pygls.workspace import TextDocument

    from axistwin.ui.editor.checks import diagnose
    from axistwin.ui.editor.documents import Text

    source = path.read_bytes().decode("utf-8", "replace")
    text = Text(TextDocument(path.as_uri(), source))
    diagnose(text)
    editor = text.editing
    if editor is None:
        return 0
    editor.symbols(text.lines)
    chance = random.Random(len(source))
    for _ in range(2):
        line = chance.randrange(len(text.lines)) + 1
        at = chance.randrange(len(text.lines[line - 1]) + 1)
        editor.hover(text.lines, line, at)
        editor.complete(text.lines, line, at)
    return 0


def loading(path: Path) -> int:
    """Load a scene as `serve` does before it opens ports."""
    served = served_scene(str(path), [], alone=True)
    served.ports(served.build())
    return 0


def state(path: Path) -> int:
    """Switch on a controller with this memory."""
    directory = path.parent / "memory"
    directory.mkdir(exist_ok=True)
    for model in ("if2", "smartmotor"):
        shutil.copy(path, directory / f"{model}.json")
        bench = Bench()
        try:
            controller = bench.add(model, state=directory)
        except AxistwinError as error:
            told = error
            continue
        bench.run(0.3)
        _ = dict(controller.programs), dict(controller.registers)
        bench.run(1.2)
        return 0
    raise told


def agreement(path: Path) -> int:
    """Compare `check` with the construction of a scene: both accept the scene, or both refuse it."""
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        accepted = execute(["check", str(path)]) == 0
    try:
        Scene.load(path).build()
        told = ""
    except AxistwinError as error:
        told = str(error)
    assert accepted is not bool(told), f"check accepts what cannot be built: {told}" if told else "check refuses it"
    return 0


def acts(directory: Path) -> dict[str, dict[str, Act]]:
    """Return the commands for each kind."""
    out = str(directory / "out.svg")
    traces = {
        kind: {
            "plot": partial(plot, out=out),
            "diff": command("diff", "FILE", str(directory / f"a.{kind}")),
        }
        for kind in ("csv", "vcd", "parquet")
    }
    check, run = command("check", "FILE"), ("run", "FILE", "--for", "0.1")
    return {
        "toml": {"agreement": agreement, "run": command(*run), "serve": loading, "lsp": editing},
        "talk": {
            "check": check,
            "run": conversation,
            "replay": command("replay", "FILE", "--brief", "--patience", "0.5"),
            "lsp": editing,
        },
        "if1": {"check": check, "run": command("run", "if1", "FILE", "--for", "4"), "lsp": editing},
        "181x": {"check": check, "run": command("run", "1811", "FILE", "--for", "2"), "lsp": editing},
        "sms": {"check": check, "run": command("run", "smartmotor", "FILE", "--for", "0.2"), "lsp": editing},
        "state": {"load": state},
        **traces,
    }


# The campaign


def campaign(
    kinds: tuple[str, ...], files: int, seed: int, keep: Path | None = None, bound_s: float = BOUND_S
) -> Verdict:
    """Test this number of mutated files of each kind; the seed determines the files."""
    verdict = Verdict()
    _warm_up()
    with tempfile.TemporaryDirectory() as name:
        directory = Path(name)
        bases, there = Bases(directory), acts(directory)
        for made in (*(ROOT / "examples").glob("*/*.sms"), *(ROOT / "examples").glob("*/*.if1"),
                     *(ROOT / "examples").glob("*/*.181x"), *(ROOT / "examples").glob("*.if1")):  # fmt: skip
            if not (directory / made.name).exists():
                shutil.copy(made, directory / made.name)
        for kind in kinds:
            sound = bases.of(kind)
            for number in range(files):
                chance = random.Random(f"{seed} {kind} {number}")
                path = directory / f"mutated{number % 10}.{'json' if kind == 'state' else kind}"
                base = chance.choice(sound)
                if kind == "parquet" and chance.random() < 0.5:
                    other_parquet(base, path, chance)
                else:
                    path.write_bytes(mutated(base.read_bytes(), kind, chance))
                verdict.files[kind] += 1
                for what, act in there[kind].items():
                    _one(verdict, kind, f"{what} of number {number}", act, path, keep, bound_s)
    return verdict


def _warm_up() -> None:
    """Run a motor and its program once, so that no file's time includes the compilation of the kernels."""
    bench = Bench()
    motor = bench.add("smartmotor", line="instant")
    bench.run(0.5)
    motor.serial.write(b"UCI UDI ZS LOAD a=1 P=9 A=9 V=9999 G END \xff\xffRUN ")
    bench.run(0.5)


def _one(verdict: Verdict, kind: str, what: str, act: Act, path: Path, keep: Path | None, bound_s: float) -> None:
    out, err = io.StringIO(), io.StringIO()
    began, code = process_time(), 0
    try:
        with _benches() as benches, redirect_stdout(out), redirect_stderr(err), _watchdog(bound_s):
            code = act(path)
    except TooLongError:
        if any(bench.seconds > ASKED_FOR_S for bench in benches):
            verdict.long[kind] += 1
        else:
            verdict.note(kind, f"{what}: no end after {bound_s:g} s", path, keep)
    except AxistwinError as error:
        code = 1
        err.write(f"axistwin: {one_line(str(error))}\n")
    except BaseException:  # noqa: BLE001  # whatever it is, it is to be seen
        verdict.note(kind, f"{what}: {_last(traceback.format_exc())}", path, keep)
    took = process_time() - began
    if took > verdict.slowest.get(kind, (0.0, ""))[0]:
        verdict.slowest[kind] = took, what
    verdict.refused[kind] += code != 0
    if code not in (0, 1, 2):
        verdict.note(kind, f"{what}: exit code {code}", path, keep)
    told = (*out.getvalue().splitlines(), *err.getvalue().splitlines())
    if code and not told:
        verdict.note(kind, f"{what}: exit code {code}, and nothing is told", path, keep)
    longest = max((line for line in err.getvalue().splitlines() if line.startswith("axistwin: ")), key=len, default="")
    if len(longest) > LONGEST_LINE:
        verdict.note(kind, f"{what}: a line of {len(longest)} characters: {longest[:100]}…", path, keep)


def _last(text: str) -> str:
    """Return place and text of an exception."""
    lines = text.strip().splitlines()
    place = [line.strip() for line in lines if line.strip().startswith('File "')][-1]
    return f"{lines[-1][:200]} ({re.sub(r'.*/src/', '', place)})"


@contextmanager
def _benches() -> Iterator[list[Bench]]:
    """Yield a list that collects the benches created in the `with` block."""
    made: list[Bench] = []
    usual = Bench.__init__

    def init(self: Bench) -> None:
        usual(self)
        made.append(self)

    Bench.__init__ = init  # type: ignore[method-assign]
    try:
        yield made
    finally:
        Bench.__init__ = usual  # type: ignore[method-assign]


@contextmanager
def _watchdog(bound_s: float) -> Iterator[None]:
    def over(*_: object) -> None:
        raise TooLongError

    timers = ((signal.ITIMER_PROF, signal.SIGPROF, bound_s), (signal.ITIMER_REAL, signal.SIGALRM, WAITING * bound_s))
    before = [signal.signal(number, over) for _, number, _ in timers]
    for timer, _, seconds in timers:
        signal.setitimer(timer, seconds)
    try:
        yield
    finally:
        for (timer, number, _), handler in zip(timers, before, strict=True):
            signal.setitimer(timer, 0)
            signal.signal(number, handler)


def main() -> int:
    """Print the findings and the verdict."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--files", type=int, default=1000, help="files of each kind")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--keep", type=Path, help="a directory for the files with which something was found")
    given = parser.parse_args()
    began = process_time()
    verdict = campaign(tuple(given.kinds.split(",")), given.files, given.seed, given.keep)
    for line in verdict.found:
        print(line)
    for kind, count in verdict.files.items():
        took, what = verdict.slowest[kind]
        print(f"{kind:8} {count:6} files, {verdict.refused[kind]:6} refusals, slowest {took:.2f} s ({what})", end="")
        print(f", {verdict.long[kind]} ask for more than {ASKED_FOR_S:g} s of virtual time" * bool(verdict.long[kind]))
    total = sum(verdict.files.values())
    print(f"seed {given.seed}: {total} files in {process_time() - began:.0f} s of processor time", end=", ")
    print(f"{len(verdict.found)} found:", "FAILED" if verdict.found else "passed")
    return 1 if verdict.found else 0


if __name__ == "__main__":
    sys.exit(main())
