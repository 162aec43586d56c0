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
    """Python wrapper for a WebAssembly function that is loaded in the browser.

    The arguments are arrays, followed by one integer.  The result is an integer.
    """

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
        """Call the WebAssembly function, and return the function's result.

        The array arguments are copied into WebAssembly memory before the call, and back after the call.
        """
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
        """Divide the memory of the WebAssembly module into regions, one for each array argument.

        `sizes`: the sizes of the arrays in bytes.
        """
        if self._sizes == sizes:
            return
        missing = pages(sum(sizes)) - pages(self._memory.buffer.byteLength)
        if missing > 0:
            self._memory.grow(missing)
        self._sizes = list(sizes)
        self._places = [sum(sizes[:n]) for n in range(len(sizes))]
        self._parts = [self._bytes(self._memory, *part) for part in zip(self._places, sizes, strict=True)]
