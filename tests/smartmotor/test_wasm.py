"""The kernel as WebAssembly, in node: the same results as plain Python, bit by bit."""

import json
import math
import shutil
import subprocess
from array import array
from base64 import b64encode
from collections.abc import MutableSequence
from importlib.util import find_spec
from pathlib import Path

import pytest

from axistwin import Bench
from axistwin.bench import read_options
from axistwin.controllers.smartmotor.kernel import core, jit, kernel
from axistwin.controllers.smartmotor.kernel.wasm import compiled
from axistwin.conversations import load, play
from axistwin.programs import options

CONVERSATIONS = sorted(Path(__file__).parents[1].glob("conversations/smartmotor_*.talk"))
Ints, Floats = MutableSequence[int], MutableSequence[float]
NODE = """
const fs = require("node:fs"), [module, calls] = process.argv.slice(1).map((name) => fs.readFileSync(name));
const { memory, ...functions } = new WebAssembly.Instance(new WebAssembly.Module(module)).exports;
const [run] = Object.values(functions);
JSON.parse(calls).forEach(({ before, after, number, result }, n) => {
  const given = before.map((text) => Buffer.from(text, "base64")), places = [];
  let size = 0;
  for (const part of given) { places.push(size); size += part.length; }
  while (memory.buffer.byteLength < size) memory.grow(1);
  const bytes = new Uint8Array(memory.buffer);
  given.forEach((part, k) => bytes.set(part, places[k]));
  const found = Number(run(...places, BigInt(number)));
  if (found !== result) console.log(`call ${n}: ${found} instead of ${result}`);
  given.forEach((part, k) => {
    const there = Buffer.from(bytes.slice(places[k], places[k] + part.length)).toString("base64");
    if (there !== after[k]) console.log(`call ${n}: array ${k} differs`);
  });
});
"""


@pytest.fixture(scope="module")
def node():
    """Return the path of node, either the system's or that inside playwright."""
    path = shutil.which("node")
    if path is None and (found := find_spec("playwright")) and found.origin:
        path = str(Path(found.origin).parent / "driver" / "node")
    if path is None or not Path(path).exists():
        pytest.skip("there is no node here, neither of the system nor of playwright")
    return path


def in_text(arrays):
    return [b64encode(numbers.tobytes()).decode() for numbers in arrays]


def recorded(function, calls):
    """Return a function that records each of its calls: the arrays before and after, the number, and the result."""

    def run(*arguments):
        *arrays, number = arguments
        before = in_text(arrays)
        result = function(*arguments)
        calls.append({"before": before, "after": in_text(arrays), "number": number, "result": int(result)})
        return result

    return run


def differences(node, folder, function, functions, calls):
    """Repeat recorded calls in node, and return the differences that it prints."""
    (folder / "module.wasm").write_bytes(compiled(function, functions))
    (folder / "calls.json").write_text(json.dumps(calls))
    command = [node, "-e", NODE, folder / "module.wasm", folder / "calls.json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout


def test_every_block_of_the_recorded_conversations_is_the_same(node, tmp_path, monkeypatch):
    calls = []
    monkeypatch.setattr(core, "advance", recorded(kernel.advance, calls))
    monkeypatch.setattr(core.Engine, "_compiled", lambda engine: None)
    for file in CONVERSATIONS:
        conversation, bench = load(file), Bench()
        if conversation.headers["model"].endswith(".toml"):  # a scene
            continue
        bench.add(conversation.headers["model"], **read_options(options(conversation)))
        assert not play(conversation, bench), file.name
    assert len(calls) > 300
    assert differences(node, tmp_path, kernel.advance, jit._sampled.values(), calls) == ""


LEAST, MOST = -(2**63), 2**63 - 1


def integers(a: int, b: int, out: Ints, at: int) -> int:
    """Write the results of all operations with two integers."""
    out[at] = a // b
    out[at + 1] = a % b
    out[at + 2], out[at + 3] = a & b | 5, (a ^ b) - ~a
    out[at + 4] = min(a, b, 3)
    out[at + 5] = max(a, b) * abs(a - b)
    out[at + 6] = a >> (b & 7)
    out[at + 7] += a << (b & 7)
    out[at + 8] = a and b
    out[at + 9] = a or b or 7
    out[at + 10] = 1 if -9 < a <= b != 4 else -1
    out[at + 11] = int(not a)
    out[at + 12] = 1 if a in (1, 2, b) and b != 2 else 0
    out[at + 13] = int(a > b) + (a < b or a == 3)
    return at + 14


def floats(a: int, b: int, out: Floats, at: int) -> int:
    """Write the results of all operations with a float."""
    x = a / b
    y = 0.1 * a - b
    out[at] = x + y * a
    out[at + 1] = -x if x > y and a else math.sqrt(abs(y))
    out[at + 2] = min(max(x, -2.0), 2.5)
    out[at + 3] -= math.floor(y) + int(x) / 3
    out[at + 4] = 1e300 * x * 1e300
    return at + 5


def loops(n: int, out: Ints) -> int:
    """Return a sum by loops with all kinds of exits."""
    total = 0
    for k in range(n):
        if k == 7:
            continue
        for j in range(k, 3 * k, 2):
            if j > 20:
                break
            total += j
        while True:
            total = quotient(total, 3) if total > 1000 else total + 1
            if total % 5 == 0:
                break
    out[n] = out[0] = total
    return total


def quotient(a: int, b: int) -> int:
    """Return a function's result from within another function."""
    if b == 0:
        return 0
    return a // b


def every_operation(out: Ints, values: Floats, n: int) -> int:
    """Apply every operation to many pairs of integers."""
    at, place = 0, 20
    for a in range(n):
        for b in range(n):
            if b != 9:
                place = integers(a - 9, b - 9, out, place)
                at = floats(a - 9, b - 9, values, at)
    return loops(n, out)


def test_every_operation_of_the_subset_is_that_of_python(node, tmp_path):
    calls = []
    n = 19
    out, values = array("q", bytes(8 * (20 + 14 * n * n))), array("d", bytes(8 * 5 * n * n))
    assert recorded(every_operation, calls)(out, values, n) == out[0] != 0
    functions = every_operation, integers, floats, loops, quotient
    assert differences(node, tmp_path, every_operation, functions, calls) == ""


def not_sampled(out: Ints, n: int) -> int:
    """Call a function that is not marked as sampled."""
    return quotient(n, 2)


def both(out: Ints, n: int) -> int:
    """Use one variable for an integer and a float."""
    value = n
    value = n / 2
    return int(value)


def text(out: Ints, n: int) -> int:
    """Use a construct that the kernel does not need."""
    out[0] = len("text")
    return n


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (
            not_sampled,
            "cannot compile the call of quotient in not_sampled: expected a function with the decorator @sampled",
        ),
        (both, "the variable value in the function both gets values of several types: expected one type, e.g. int"),
        (text, "cannot compile the call of len in text: expected a function with the decorator @sampled"),
    ],
)
def test_what_is_outside_the_subset_is_refused(function, words):
    with pytest.raises(NotImplementedError, match=words):
        compiled(function, [function])
