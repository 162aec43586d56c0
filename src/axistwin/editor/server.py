"""The language server: what the checkers and `axistwin.editor` say, in the terms of the Language Server Protocol.

Columns there are of UTF-16, lines count from 0; the protocol's own position codec converts.
"""

import asyncio
from collections.abc import Callable
from pathlib import Path

from lsprotocol import types as lsp
from pygls.lsp.server import LanguageServer
from pygls.workspace import TextDocument

from axistwin.controllers.diagnostics import Diagnostic, Fix, Severity
from axistwin.diagnostics.checking import SCENE, diagnose_text, product_for
from axistwin.diagnostics.scenes import diagnose_scene
from axistwin.editor.answers import Editing, Item, Symbol
from axistwin.editor.compumotor import Commands
from axistwin.editor.digiplan import CommandLines
from axistwin.editor.scene import Scenes
from axistwin.editor.smartmotor import SourceEditing
from axistwin.editor.talk import Conversations
from axistwin.errors import UsageError
from axistwin.version import VERSION

LIMIT = 1 << 17
"""Characters of a text that are looked at while somebody types: that takes a second or two."""
PAUSE_S = 0.2
"""What is wrong is told when nobody has typed for so long."""
_ODD_ENDS = str.maketrans(dict.fromkeys("\x0b\x0c\x1c\x1d\x1e\x85\u2028\u2029", " "))
"""What ends a line for Python and not for the protocol."""
SEVERITIES = {Severity.ERROR: lsp.DiagnosticSeverity.Error, Severity.WARNING: lsp.DiagnosticSeverity.Warning}
ITEMS = {
    "command": lsp.CompletionItemKind.Keyword,
    "value": lsp.CompletionItemKind.Value,
    "variable": lsp.CompletionItemKind.Variable,
    "label": lsp.CompletionItemKind.Reference,
    "key": lsp.CompletionItemKind.Property,
    "pin": lsp.CompletionItemKind.Field,
}
SYMBOLS = {
    "label": lsp.SymbolKind.Function,
    "sequence": lsp.SymbolKind.Array,
    "step": lsp.SymbolKind.Event,
    "move": lsp.SymbolKind.Constant,
    "table": lsp.SymbolKind.Object,
}


class Text:
    """A document as it is in the editor now."""

    def __init__(self, document: TextDocument) -> None:
        self.document = document
        self.path = Path(document.path or document.uri)
        try:
            self.text = document.source.translate(_ODD_ENDS)
        except (OSError, UnicodeDecodeError):  # not open in the editor, and not to be read: closed, removed, unsaved
            self.text = ""
        self.lines = self.text.splitlines() or [""]
        if self.text.endswith(("\n", "\r")):
            self.lines.append("")

    @property
    def editing(self) -> Editing | None:
        """Who answers for this kind of text, unless it would take long."""
        if self.too_long:
            return None
        match self.path.suffix.lower():
            case ".if1":
                return CommandLines()
            case ".181x":
                return Commands(product_for(".181x", self.text))
            case ".sms":
                return SourceEditing()
            case ".talk":
                return Conversations()
            case ".toml":
                return Scenes()
        return None

    @property
    def too_long(self) -> bool:
        """Whether one would wait for what there is to say about it."""
        return len(self.text) > LIMIT

    def diagnose(self) -> list[Diagnostic]:
        """What is wrong with it.  A TOML file that has no [[controller]] is somebody else's."""
        suffix = self.path.suffix.lower()
        if self.editing is None:
            return []
        if suffix == SCENE:
            return diagnose_scene(self.path, self.text) if "[[controller]]" in self.text else []
        try:
            return diagnose_text(self.text, suffix, product_for(suffix, self.text))
        except UsageError as error:
            return [Diagnostic(1, 1, Severity.WARNING, str(error))]

    def position(self, line: int, column: int) -> lsp.Position:
        """A place, from 1, as the protocol has it."""
        here = lsp.Position(min(line, len(self.lines)) - 1, column - 1)
        if self.lines[here.line].isascii():
            return here  # the codec counts from the line's beginning, which takes its time in long ones
        return self.document.position_codec.position_to_client_units(self.lines, here)

    def span(self, begin: tuple[int, int], end: tuple[int, int]) -> lsp.Range:
        """From a place to another."""
        return lsp.Range(self.position(*begin), self.position(*end))

    def at(self, position: lsp.Position) -> tuple[int, int]:
        """A place of the protocol as a line from 1 and an index into it."""
        here = self.document.position_codec.position_from_client_units(self.lines, position)
        line = min(here.line, len(self.lines) - 1)
        return line + 1, min(here.character, len(self.lines[line]))


class Server(LanguageServer):
    """One editor's server."""

    def __init__(self) -> None:
        super().__init__("axistwin", VERSION)
        self.asked_to_end = False
        self._due: dict[str, asyncio.TimerHandle] = {}
        self._told: dict[str, tuple[str, list[Diagnostic]]] = {}

    def text(self, uri: str) -> Text:
        """The document as it is now."""
        return Text(self.workspace.get_text_document(uri))

    def publish(self, uri: str) -> None:
        """Tell the editor what is wrong with a document."""
        text = self.text(uri)
        self._told[uri] = text.text, text.diagnose()
        found = [_diagnostic(text, each) for each in self._told[uri][1]]
        found += [_too_long(text)] if text.too_long else []
        params = lsp.PublishDiagnosticsParams(uri, found, text.document.version)
        self.text_document_publish_diagnostics(params)

    def publish_soon(self, uri: str) -> None:
        """The same, of the newest version, when nobody has typed for a moment."""
        self._cancel(uri)
        self._due[uri] = asyncio.get_running_loop().call_later(PAUSE_S, self.publish, uri)

    def found(self, text: Text) -> list[Diagnostic]:
        """What is wrong with a document: as it has been told, if that is what it was about."""
        about, found = self._told.get(text.document.uri, ("", []))
        return found if about == text.text else text.diagnose()

    def forget(self, uri: str) -> None:
        """It has been closed: nothing is wrong with what is not there."""
        self._cancel(uri)
        self._told.pop(uri, None)
        self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, []))

    def _cancel(self, uri: str) -> None:
        due = self._due.pop(uri, None)
        if due is not None:
            due.cancel()


def make() -> Server:
    """A server with everything it can do."""
    server = Server()
    for feature, answer in FEATURES.items():
        server.feature(feature)(answer)
    options = lsp.CompletionOptions(trigger_characters=["=", "!", ".", ":", " ", '"', "["])
    server.feature(lsp.TEXT_DOCUMENT_COMPLETION, options)(complete)
    actions = lsp.CodeActionOptions([lsp.CodeActionKind.QuickFix])
    server.feature(lsp.TEXT_DOCUMENT_CODE_ACTION, actions)(code_actions)
    return server


# Documents


def did_open(server: Server, params: lsp.DidOpenTextDocumentParams) -> None:
    """A document is there."""
    server.publish(params.text_document.uri)


def did_change(server: Server, params: lsp.DidChangeTextDocumentParams) -> None:
    """Somebody has typed."""
    server.publish_soon(params.text_document.uri)


def did_close(server: Server, params: lsp.DidCloseTextDocumentParams) -> None:
    """A document is not there any more."""
    server.forget(params.text_document.uri)


def shutdown(server: Server, _: None) -> None:
    """The editor is going to end the server."""
    server.asked_to_end = True


def _too_long(text: Text) -> lsp.Diagnostic:
    message = f"more than {LIMIT:,} characters: not looked at while you type; use axistwin check"
    return lsp.Diagnostic(text.span((1, 1), (1, 1)), message, lsp.DiagnosticSeverity.Information, source="axistwin")


def _diagnostic(text: Text, found: Diagnostic) -> lsp.Diagnostic:
    return lsp.Diagnostic(
        text.span((found.line, found.column), found.end),
        found.message + (f" (manual: {found.chapter})" if found.chapter else ""),
        SEVERITIES[found.severity],
        code=found.code,
        source="axistwin",
    )


# Questions


def hover(server: Server, params: lsp.HoverParams) -> lsp.Hover | None:
    """What a word means."""
    text = server.text(params.text_document.uri)
    line, at = text.at(params.position)
    found = text.editing.hover(text.lines, line, at) if text.editing is not None else None
    if found is None:
        return None
    span = text.span((line, found.begin + 1), (line, found.end + 1))
    return lsp.Hover(lsp.MarkupContent(lsp.MarkupKind.Markdown, found.text), span)


def complete(server: Server, params: lsp.CompletionParams) -> lsp.CompletionList:
    """What may be written."""
    text = server.text(params.text_document.uri)
    line, at = text.at(params.position)
    found = text.editing.complete(text.lines, line, at) if text.editing is not None else []
    return lsp.CompletionList(False, [_item(each, number) for number, each in enumerate(found)])


def _item(item: Item, number: int) -> lsp.CompletionItem:
    """In the order in which the manual has them."""
    told = lsp.MarkupContent(lsp.MarkupKind.Markdown, item.text) if item.text else None
    return lsp.CompletionItem(
        item.label,
        kind=ITEMS[item.kind],
        detail=item.detail or None,
        documentation=told,
        insert_text=item.insert or None,
        sort_text=f"{number:04}",
    )


def symbols(server: Server, params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
    """What the document is made of."""
    text = server.text(params.text_document.uri)
    found = text.editing.symbols(text.lines) if text.editing is not None else []
    return [_symbol(text, each) for each in found]


def _symbol(text: Text, symbol: Symbol) -> lsp.DocumentSymbol:
    whole = text.span(symbol.begin, symbol.end)
    children = [_symbol(text, each) for each in symbol.children]
    return lsp.DocumentSymbol(symbol.name, SYMBOLS[symbol.kind], whole, whole, symbol.detail, children=children)


def code_actions(server: Server, params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
    """The fixes of what is found there."""
    text = server.text(params.text_document.uri)
    found = ((each, _diagnostic(text, each)) for each in server.found(text))
    return [
        _action(text, each.fix, told)
        for each, told in found
        if each.fix is not None and _meet(told.range, params.range)
    ]


def _meet(one: lsp.Range, other: lsp.Range) -> bool:
    return one.start <= other.end and other.start <= one.end


def _action(text: Text, fix: Fix, told: lsp.Diagnostic) -> lsp.CodeAction:
    edits = [lsp.TextEdit(text.span(edit[:2], edit[2:4]), edit.text) for edit in fix.edits]
    change = lsp.WorkspaceEdit(changes={text.document.uri: edits})
    return lsp.CodeAction(
        fix.title[:1].upper() + fix.title[1:],
        lsp.CodeActionKind.QuickFix,
        diagnostics=[told],
        is_preferred=fix.sure,
        edit=change,
    )


FEATURES: dict[str, Callable[..., object]] = {
    lsp.TEXT_DOCUMENT_DID_OPEN: did_open,
    lsp.TEXT_DOCUMENT_DID_CHANGE: did_change,
    lsp.TEXT_DOCUMENT_DID_CLOSE: did_close,
    lsp.SHUTDOWN: shutdown,
    lsp.TEXT_DOCUMENT_HOVER: hover,
    lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL: symbols,
}
"""What needs no options."""
