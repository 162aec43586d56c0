"""Diagnostics: check programs and scenes, for `axistwin check` and the language server."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.diagnostics.checking import diagnose_text, product_for, read_acts, sessions
    from axistwin.diagnostics.refused_lines import RefusedLines
    from axistwin.diagnostics.scenes import diagnose_scene
else:
    __getattr__ = lazy(
        __name__,
        checking="diagnose_text product_for read_acts sessions",
        refused_lines="RefusedLines",
        scenes="diagnose_scene",
    )

__all__ = ["RefusedLines", "diagnose_scene", "diagnose_text", "product_for", "read_acts", "sessions"]
