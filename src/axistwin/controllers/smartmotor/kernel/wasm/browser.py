"""Call compiled functions in a browser, where Pyodide runs Python."""

from collections.abc import Collection, Sequence
from types import FunctionType
from typing import Any

from axistwin.controllers.smartmotor.kernel.wasm.code import pages
from axistwin.controllers.smartmotor.kernel.wasm.functions import compiled

_START = """(code, name) => {
  const { memory, [name]: run } = new WebAssembly.Instance(new WebAssembly.Module(code)).exports;
  return { memory, run: (...numbers) => Number(run(...numbers.slice(0, -1), BigInt(numbers.at(-1)))) };
}"""


class Loaded:
    """A compiled function that returns an integer; its arguments are arrays, and one integer at the end."""

    def __init__(self, function: FunctionType, functions: Collection[FunctionType]) -> None:
        from pyodide.code import run_js  # type: ignore[import-not-found]
        from pyodide.ffi import to_js  # type: ignore[import-not-found]

        started = run_js(_START)(to_js(compiled(function, functions)), function.__name__)
        self._run, self._memory = started.run, started.memory
        self._bytes = run_js("(memory, place, size) => new Uint8Array(memory.buffer, place, size)")
        self._sizes: list[int] = []
        self._places: list[int] = []
        self._parts: list[Any] = []

    def __call__(self, *arguments: Any) -> int:
        """Copy the arrays into the memory of the module, call the function, and copy the arrays back."""
        *arrays, number = arguments
        self._divide([each.itemsize * len(each) for each in arrays])
        shared = [(part, memoryview(each).cast("B")) for part, each in zip(self._parts, arrays, strict=True)]
        for part, numbers in shared:
            part.assign(numbers)
        result = int(self._run(*self._places, number))
        for part, numbers in shared:
            part.assign_to(numbers)
        return result

    def _divide(self, sizes: Sequence[int]) -> None:
        if self._sizes == sizes:
            return
        missing = pages(sum(sizes)) - pages(self._memory.buffer.byteLength)
        if missing > 0:
            self._memory.grow(missing)
        self._sizes = list(sizes)
        self._places = [sum(sizes[:n]) for n in range(len(sizes))]
        self._parts = [self._bytes(self._memory, *part) for part in zip(self._places, sizes, strict=True)]
