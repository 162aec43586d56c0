"""Diagnostics: check programs and scenes, for `axistwin check` and the language server."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.diagnostics.checking import diagnose, diagnose_text, product_for
    from axistwin.diagnostics.codes import select, tables
    from axistwin.diagnostics.fix import fix_text
    from axistwin.diagnostics.scenes import diagnose_scene
else:
    __getattr__ = lazy(
        __name__,
        checking="diagnose diagnose_text product_for",
        codes="select tables",
        fix="fix_text",
        scenes="diagnose_scene",
    )

__all__ = ["diagnose", "diagnose_scene", "diagnose_text", "fix_text", "product_for", "select", "tables"]
