"""Checks of documents, executed in the background process.

The process encodes its findings itself: the encoding of some thousand findings would delay the server's answers.
"""

import json
from typing import NamedTuple

from lsprotocol import types as lsp
from lsprotocol.converters import get_converter
from pygls.workspace import PositionCodec, TextDocument

from axistwin.controllers.diagnostics import Diagnostic, Fix, Severity
from axistwin.core.errors import UsageError
from axistwin.scenes.diagnostics.checking import SCENE, diagnose_text, product_for
from axistwin.scenes.diagnostics.scenes import diagnose_scene
from axistwin.ui.editor.documents import LIMIT, Text

SEVERITIES = {Severity.ERROR: lsp.DiagnosticSeverity.Error, Severity.WARNING: lsp.DiagnosticSeverity.Warning}
KEPT = 16  # Number of documents whose findings the process keeps, for fixes.
_kept: dict[str, tuple[str, list[Diagnostic]]] = {}  # By URI: the text that was checked last, and its findings.


class Snapshot(NamedTuple):
    """A copy of a document in the editor, with its version."""

    uri: str
    source: str
    version: int | None
    encoding: lsp.PositionEncodingKind | str | None  # The unit of columns that server and editor have agreed on.

    @property
    def text(self) -> Text:
        """The document as text, with methods that convert a line and a column to an editor position, and back."""
        return Text(TextDocument(self.uri, self.source, position_codec=PositionCodec(self.encoding)))


def notification(snapshot: Snapshot) -> bytes:
    text = snapshot.text
    listed = [_too_long(text)] if text.too_long else [_diagnostic(text, each) for each in _checked(snapshot.uri, text)]
    params = lsp.PublishDiagnosticsParams(snapshot.uri, listed, snapshot.version)
    return json.dumps(get_converter().unstructure(lsp.PublishDiagnosticsNotification(params))).encode()


def actions(snapshot: Snapshot, wanted: lsp.Range) -> list[lsp.CodeAction]:
    """Return the fixes in a range of a document; the last check is used if the text has not changed."""
    text = snapshot.text
    if text.too_long:
        return []
    source, found = _kept.get(snapshot.uri, ("", []))
    found = found if source == text.text else _checked(snapshot.uri, text)
    fixed = [(each.fix, _diagnostic(text, each)) for each in found if each.fix is not None]
    return [
        _action(text, fix, diagnostic)
        for fix, diagnostic in fixed
        if diagnostic.range.start <= wanted.end and wanted.start <= diagnostic.range.end
    ]


def diagnose(text: Text) -> list[Diagnostic]:
    """Check a document, and return its errors and warnings.  A TOML file without [[controller]] is not a scene."""
    if text.editing is None:
        return []
    if text.suffix == SCENE:
        return diagnose_scene(text.path, text.text) if "[[controller]]" in text.text else []
    try:
        return diagnose_text(text.text, text.suffix, product_for(text.suffix, text.text))
    except UsageError as error:
        return [Diagnostic(1, 1, Severity.WARNING, str(error))]


def _checked(uri: str, text: Text) -> list[Diagnostic]:
    _kept.pop(uri, None)
    _kept[uri] = text.text, diagnose(text)
    if len(_kept) > KEPT:
        del _kept[next(iter(_kept))]
    return _kept[uri][1]


def _too_long(text: Text) -> lsp.Diagnostic:
    message = f"more than {LIMIT:,} characters: not checked during typing, use axistwin check"
    return lsp.Diagnostic(text.span((1, 1), (1, 1)), message, lsp.DiagnosticSeverity.Information, source="axistwin")


def _diagnostic(text: Text, found: Diagnostic) -> lsp.Diagnostic:
    return lsp.Diagnostic(
        text.span((found.line, found.column), found.end),
        found.message + (f" (manual: {found.chapter})" if found.chapter else ""), SEVERITIES[found.severity],
        code=found.code, source="axistwin",
    )  # fmt: skip


def _action(text: Text, fix: Fix, diagnostic: lsp.Diagnostic) -> lsp.CodeAction:
    edits = [lsp.TextEdit(text.span(edit[:2], edit[2:4]), edit.text) for edit in fix.edits]
    change = lsp.WorkspaceEdit(changes={text.document.uri: edits})
    return lsp.CodeAction(
        fix.title[:1].upper() + fix.title[1:], lsp.CodeActionKind.QuickFix, diagnostics=[diagnostic],
        is_preferred=fix.sure, edit=change,
    )  # fmt: skip
