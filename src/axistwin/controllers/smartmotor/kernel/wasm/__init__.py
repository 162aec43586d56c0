"""The kernel in browsers: the sampled functions compiled to WebAssembly."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.controllers.smartmotor.kernel.wasm.functions import compiled
else:
    __getattr__ = lazy(
        __name__,
        functions="compiled",
    )

__all__ = ["compiled"]
