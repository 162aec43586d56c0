"""Compile the functions that compute a sample.  The same source runs on lists (plain Python) or on arrays (Numba), with
identical results.

`@sampled` marks a function and returns it unchanged.  `best(function)` returns a compiled copy of the function, if
compilation is available.  All marked functions are compiled together, and call one another through copies of their
globals.  Sampled functions must therefore import one another by name (`from ...servo import rotate`), never by module.
Numba is imported at the first compilation.

The environment variable AXISTWIN_JIT is `auto` (compile if Numba is installed), `on` (raise an error without Numba) or
`off`.  Machine code is kept in the user's cache directory, under a fingerprint of all compiled code.
"""

import os
import sys
from array import array
from collections.abc import Callable, Mapping
from functools import cache
from logging import getLogger
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, TypeVar, cast

from axistwin.core.errors import MissingExtraError, UsageError, installation, installed
from axistwin.core.storage import user_cache, write_whole

F = TypeVar("F", bound=Callable[..., object])

SLOW = "SmartMotors run in plain Python, many times slower"
SETTINGS = "auto", "on", "off"
COMPILING = "compiling for SmartMotors: this takes some seconds, once for each version"
SEAL = "whole.json"
FORGOTTEN_S = 30 * 24 * 3600
OPTIONS = {
    "error_model": "numpy", "_nrt": False, "forceinline": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True,
}  # fmt: skip
"""No test for division by zero, so functions must not rely on it; no reference counts of arrays, which take ten times
as long as all else; no calls within a sample, as a call passes seven numbers for each array, which takes as long as
the arithmetic; no entry from Python, except for functions that Python calls."""
_log = getLogger("axistwin.smartmotor")
_sampled: dict[tuple[str, str], FunctionType] = {}


def sampled(function: F) -> F:
    """Mark a function that runs in every sample, written in Numba's subset of Python."""
    _sampled[function.__module__, function.__qualname__] = cast("FunctionType", function)
    return function


@cache
def setting() -> str:
    """Return the value of the environment variable AXISTWIN_JIT, which is read once."""
    given = os.environ.get("AXISTWIN_JIT", "auto")
    if given not in SETTINGS:
        raise UsageError(f"AXISTWIN_JIT={given}: expected one of {', '.join(SETTINGS)}")
    return given


@cache
def available() -> bool:
    """Return True if a compiler is available.  Raises MissingExtraError if AXISTWIN_JIT=on and Numba is missing."""
    if setting() == "off":
        return False
    if installed("numba"):
        return True
    if setting() == "on":
        raise MissingExtraError(library="numba", extra="fast")
    return False


def note() -> str:
    """Return a hint for the user if Numba is missing and would make SmartMotors faster; otherwise ""."""
    return "" if setting() == "off" or available() else f"{SLOW}: {installation('fast', 'numba')}"


def best(function: F) -> F:
    """Return a copy that its first call compiles, or the function itself without a compiler."""
    return cast("F", compiled(cast("FunctionType", function))) if available() else function


def view(numbers: "array[int] | array[float]") -> Any:
    import numpy as np  # lazy import: NumPy is needed only for compiled code

    return np.frombuffer(numbers, numbers.typecode)


def compiled(function: FunctionType) -> Callable[..., Any]:
    """Return a compiled copy of a function.  Python code can call the copy.  The machine code of the copy is cached."""
    return _compiled(function, tuple(_sampled.values()))


@cache
def _compiled(function: FunctionType, functions: tuple[FunctionType, ...]) -> Callable[..., Any]:
    compiler, kept = _numba(), _cache_directory(functions)
    if kept is not None and not _whole(kept):
        _log.info(COMPILING)
    kept_before, compiler.config.CACHE_DIR = compiler.config.CACHE_DIR, str(kept or "")
    try:
        options = {**OPTIONS, "no_cpython_wrapper": False, "cache": kept is not None}
        copied = _copied(function, _spaces(functions)[function.__module__], compiler.njit(**options))
        return copied if kept is None else _Sealing(copied, kept)
    finally:
        compiler.config.CACHE_DIR = kept_before


def is_cached() -> bool:
    """True if all machine code is in the user's cache, or if machine code is never cached."""
    kept = _cache_directory(tuple(_sampled.values()))
    return kept is not None and _whole(kept)


class _Sealing:
    def __init__(self, function: Callable[..., Any], directory: Path) -> None:
        self._function, self._directory = function, directory
        self._sealed = False

    def __call__(self, *args: object) -> Any:
        result = self._function(*args)
        if not self._sealed:
            self._sealed = True
            _seal(self._directory)
        return result


def _sums(directory: Path) -> dict[str, str]:
    from hashlib import sha256  # lazy import: the module hashlib loads slowly, because it loads the OpenSSL library

    files = sorted(path for path in directory.rglob("*.nb*") if path.is_file())
    return {str(path.relative_to(directory)): sha256(path.read_bytes()).hexdigest() for path in files}


def _seal(directory: Path) -> None:
    """Store checksums that mark the cached code as complete; delete caches unused for 30 days."""
    import json  # lazy imports: the modules json and shutil are needed only for the cache of machine code
    from shutil import rmtree

    try:
        write_whole(directory / SEAL, json.dumps(_sums(directory)).encode())
        os.utime(directory)
        newest = directory.stat().st_mtime
        for other in directory.parent.glob("smartmotor-*"):
            if newest - other.stat().st_mtime > FORGOTTEN_S:
                rmtree(other, ignore_errors=True)
    except OSError:
        return  # If the file of checksums is missing, axistwin compiles the machine code again at its next start.


def _whole(directory: Path) -> bool:
    """Return True if the cached machine code is complete and not damaged.  Damaged files are removed."""
    import json  # lazy import: the module json is needed only for the cache of machine code

    try:
        sealed = json.loads((directory / SEAL).read_bytes())
    except (OSError, ValueError):
        sealed = {}
    damaged = [name for name, digest in _sums(directory).items() if sealed.get(name) != digest]
    for name in damaged:
        (directory / name).unlink(missing_ok=True)
    return bool(sealed) and not damaged


@cache
def _spaces(functions: tuple[FunctionType, ...]) -> Mapping[str, dict[str, Any]]:
    compiler = _numba().njit(**OPTIONS)
    spaces = {function.__module__: dict(function.__globals__) for function in functions}
    copies = {function: _copied(function, spaces[function.__module__], compiler) for function in functions}
    for space in spaces.values():
        for name, value in space.items():
            if isinstance(value, FunctionType) and value in copies:
                space[name] = copies[value]
    return spaces


Compiler = Callable[[FunctionType], Callable[..., Any]]


def _copied(function: FunctionType, space: dict[str, Any], compiler: Compiler) -> Callable[..., Any]:
    copy = FunctionType(function.__code__, space, function.__name__, function.__defaults__)
    copy.__module__, copy.__qualname__ = function.__module__, function.__qualname__
    return compiler(copy)


@cache
def _numba() -> Any:
    """Import Numba on demand, because the import takes half a second."""
    try:
        import numba
    except ImportError as reason:
        raise UsageError(f"numba cannot be loaded ({reason}): install numba again, or set AXISTWIN_JIT=off") from reason
    return numba


def _cache_directory(functions: tuple[FunctionType, ...]) -> Path | None:
    if not all(os.path.exists(function.__code__.co_filename) for function in functions):
        return None
    try:
        directory = user_cache() / f"smartmotor-{fingerprint(functions)}"
        directory.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):  # `user_cache` raises RuntimeError if the user has no home directory.
        return None
    return directory if os.access(directory, os.W_OK) else None


def fingerprint(functions: tuple[FunctionType, ...]) -> str:
    """Return a hash of code and globals of functions, and of the compiler's version and options."""
    from hashlib import sha256  # lazy imports: the modules hashlib and importlib.metadata load slowly
    from importlib.metadata import version

    digest = sha256(f"{sys.version} {version('numba')} {version('llvmlite')} {OPTIONS}".encode())
    for function in functions:
        digest.update(_ingredients(function).encode())
    return digest.hexdigest()[:16]


def _ingredients(function: FunctionType) -> str:
    code, known = function.__code__, function.__globals__
    spaces = known, *(vars(known[name]) for name in code.co_names if isinstance(known.get(name), ModuleType))
    found = [(name, space.get(name)) for space in spaces for name in code.co_names]
    constants = [(name, value) for name, value in found if isinstance(value, bool | int | float | tuple)]
    parts = function.__module__, function.__qualname__, function.__defaults__, code.co_varnames, code.co_names
    return repr((*parts, code.co_consts, constants, code.co_code))
