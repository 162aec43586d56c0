"""The language server: provides diagnostics and `axistwin.editor` by the Language Server Protocol.

In the protocol, columns are in UTF-16 units and the first line is 0.
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
from axistwin.editor.background import Background, undisturbed
from axistwin.editor.compumotor import Commands
from axistwin.editor.digiplan import CommandLines
from axistwin.editor.scene import Scenes
from axistwin.editor.smartmotor import SourceEditing, parsed
from axistwin.editor.talk import Conversations
from axistwin.errors import UsageError
from axistwin.version import VERSION

LIMIT = 1 << 17
"""Largest number of characters of a text that is checked while the user types."""
PAUSE_S = 0.2
"""Pause in typing, in seconds, after which diagnostics are sent to the editor."""
_ODD_ENDS = str.maketrans(dict.fromkeys("\x0b\x0c\x1c\x1d\x1e\x85\u2028\u2029", " "))
"""Characters that end a line in Python but not in the protocol."""
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
    """A document with its current text in the editor."""

    def __init__(self, document: TextDocument) -> None:
        self.document = document
        self.path = Path(document.path or document.uri)
        try:
            self.text = document.source.translate(_ODD_ENDS)
        except (OSError, UnicodeDecodeError):  # the document has been closed, and its file cannot be read
            self.text = ""
        self.lines = self.text.splitlines() or [""]
        if self.text.endswith(("\n", "\r")):
            self.lines.append("")

    @property
    def editing(self) -> Editing | None:
        """The language support for this kind of text; None if there is none, or if the text is too long."""
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
        """True if the text is too long for checking during typing."""
        return len(self.text) > LIMIT

    def diagnose(self) -> list[Diagnostic]:
        """Return the diagnostics of the document.  A TOML file without [[controller]] is not a scene."""
        suffix = self.path.suffix.lower()
        if self.editing is None:
            return []
        if suffix == ".sms":
            for line in self.lines:
                parsed(line)  # so that the next completion needs no line to be read
        if suffix == SCENE:
            return diagnose_scene(self.path, self.text) if "[[controller]]" in self.text else []
        try:
            return diagnose_text(self.text, suffix, product_for(suffix, self.text))
        except UsageError as error:
            return [Diagnostic(1, 1, Severity.WARNING, str(error))]

    def position(self, line: int, column: int) -> lsp.Position:
        """Convert a line and a column, both from 1, to a position of the protocol."""
        here = lsp.Position(min(line, len(self.lines)) - 1, column - 1)
        if self.lines[here.line].isascii():
            return here  # for ASCII lines this is exact, and the codec is slow for long lines
        return self.document.position_codec.position_to_client_units(self.lines, here)

    def span(self, begin: tuple[int, int], end: tuple[int, int]) -> lsp.Range:
        """Convert two places (line and column from 1) to a range of the protocol."""
        return lsp.Range(self.position(*begin), self.position(*end))

    def at(self, position: lsp.Position) -> tuple[int, int]:
        """Convert a position of the protocol to a line from 1 and an index into that line."""
        here = self.document.position_codec.position_from_client_units(self.lines, position)
        line = min(here.line, len(self.lines) - 1)
        return line + 1, min(here.character, len(self.lines[line]))


class Server(LanguageServer):
    """The language server for one editor."""

    def __init__(self) -> None:
        super().__init__("axistwin", VERSION)
        self.asked_to_end = False
        self._background = Background()
        self._due: dict[str, asyncio.TimerHandle] = {}
        self._checks: dict[str, asyncio.Task[None]] = {}
        self._published: dict[str, tuple[str, list[Diagnostic]]] = {}

    def text(self, uri: str) -> Text:
        """Return the document with its current text."""
        return Text(self.workspace.get_text_document(uri))

    def publish(self, uri: str) -> None:
        """Check a document in the background, and publish the diagnostics unless the text changes meanwhile."""
        self._cancel(uri)
        self._checks[uri] = asyncio.get_running_loop().create_task(self._publish(uri))

    async def _publish(self, uri: str) -> None:
        text = self.text(uri)
        listed = await self.found(text)
        found = [_diagnostic(text, each) for each in listed]
        found += [_too_long(text)] if text.too_long else []
        params = lsp.PublishDiagnosticsParams(uri, found, text.document.version)
        self.text_document_publish_diagnostics(params)

    def publish_soon(self, uri: str) -> None:
        """Send the diagnostics of a document after a pause in typing."""
        self._cancel(uri)
        self._due[uri] = asyncio.get_running_loop().call_later(PAUSE_S, self.publish, uri)

    async def found(self, text: Text) -> list[Diagnostic]:
        """Return the diagnostics of a document; those of the last check are reused if the text is unchanged."""
        about, found = self._published.get(text.document.uri, ("", []))
        if about != text.text:
            found = await self._background.run(text.diagnose)
            self._published[text.document.uri] = text.text, found
        return found

    def close_document(self, uri: str) -> None:
        """Remove the diagnostics of a closed document."""
        self._cancel(uri)
        self._published.pop(uri, None)
        self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, []))

    def _cancel(self, uri: str) -> None:
        for due in (self._due.pop(uri, None), self._checks.pop(uri, None)):
            if due is not None:
                due.cancel()


def make() -> Server:
    """Create a language server with all its features."""
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
    """Handle an opened document."""
    server.publish(params.text_document.uri)


def did_change(server: Server, params: lsp.DidChangeTextDocumentParams) -> None:
    """Handle an edit."""
    server.publish_soon(params.text_document.uri)


def did_close(server: Server, params: lsp.DidCloseTextDocumentParams) -> None:
    """Handle a closed document."""
    server.close_document(params.text_document.uri)


def shutdown(server: Server, _: None) -> None:
    """Handle the request to shut down: the editor will send `exit` next."""
    server.asked_to_end = True


def _too_long(text: Text) -> lsp.Diagnostic:
    message = f"more than {LIMIT:,} characters: not checked during typing, use axistwin check"
    return lsp.Diagnostic(text.span((1, 1), (1, 1)), message, lsp.DiagnosticSeverity.Information, source="axistwin")


def _diagnostic(text: Text, found: Diagnostic) -> lsp.Diagnostic:
    return lsp.Diagnostic(
        text.span((found.line, found.column), found.end),
        found.message + (f" (manual: {found.chapter})" if found.chapter else ""),
        SEVERITIES[found.severity],
        code=found.code,
        source="axistwin",
    )


# Requests


def hover(server: Server, params: lsp.HoverParams) -> lsp.Hover | None:
    """Return the meaning of the word at the cursor."""
    text = server.text(params.text_document.uri)
    line, at = text.at(params.position)
    found = text.editing.hover(text.lines, line, at) if text.editing is not None else None
    if found is None:
        return None
    span = text.span((line, found.begin + 1), (line, found.end + 1))
    return lsp.Hover(lsp.MarkupContent(lsp.MarkupKind.Markdown, found.text), span)


def complete(server: Server, params: lsp.CompletionParams) -> lsp.CompletionList:
    """Return the completions at the cursor."""
    with undisturbed():
        text = server.text(params.text_document.uri)
        line, at = text.at(params.position)
        found = text.editing.complete(text.lines, line, at) if text.editing is not None else []
        return lsp.CompletionList(False, [_item(each, number) for number, each in enumerate(found)])


def _item(item: Item, number: int) -> lsp.CompletionItem:
    """Return a completion; completions are sorted in the order of the manual."""
    documentation = lsp.MarkupContent(lsp.MarkupKind.Markdown, item.text) if item.text else None
    return lsp.CompletionItem(
        item.label,
        kind=ITEMS[item.kind],
        detail=item.detail or None,
        documentation=documentation,
        insert_text=item.insert or None,
        sort_text=f"{number:04}",
    )


def symbols(server: Server, params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
    """Return the named parts of a document, e.g. its labels and sequences."""
    text = server.text(params.text_document.uri)
    found = text.editing.symbols(text.lines) if text.editing is not None else []
    return [_symbol(text, each) for each in found]


def _symbol(text: Text, symbol: Symbol) -> lsp.DocumentSymbol:
    whole = text.span(symbol.begin, symbol.end)
    children = [_symbol(text, each) for each in symbol.children]
    return lsp.DocumentSymbol(symbol.name, SYMBOLS[symbol.kind], whole, whole, symbol.detail, children=children)


async def code_actions(server: Server, params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
    """Return the fixes of the diagnostics in a range."""
    text = server.text(params.text_document.uri)
    found = [(each, _diagnostic(text, each)) for each in await server.found(text)]
    return [
        _action(text, each.fix, diagnostic)
        for each, diagnostic in found
        if each.fix is not None and _overlap(diagnostic.range, params.range)
    ]


def _overlap(one: lsp.Range, other: lsp.Range) -> bool:
    return one.start <= other.end and other.start <= one.end


def _action(text: Text, fix: Fix, diagnostic: lsp.Diagnostic) -> lsp.CodeAction:
    edits = [lsp.TextEdit(text.span(edit[:2], edit[2:4]), edit.text) for edit in fix.edits]
    change = lsp.WorkspaceEdit(changes={text.document.uri: edits})
    return lsp.CodeAction(
        fix.title[:1].upper() + fix.title[1:],
        lsp.CodeActionKind.QuickFix,
        diagnostics=[diagnostic],
        is_preferred=fix.sure,
        edit=change,
    )


def definition(server: Server, params: lsp.DefinitionParams) -> lsp.Location | None:
    """Return the place of a label, or the file that a scene names."""
    text = server.text(params.text_document.uri)
    line, at = text.at(params.position)
    editing = text.editing
    if isinstance(editing, Scenes):
        name = editing.file(text.lines, line, at)
        path = text.path.parent / name if name else None
        start = lsp.Position(0, 0)
        return lsp.Location(path.resolve().as_uri(), lsp.Range(start, start)) if path and path.is_file() else None
    found = editing.definition(text.lines, line, at) if isinstance(editing, SourceEditing) else None
    return None if found is None else _location(text, *found)


def references(server: Server, params: lsp.ReferenceParams) -> list[lsp.Location]:
    """Return the places of a label and of the statements that call the label."""
    text = server.text(params.text_document.uri)
    line, at = text.at(params.position)
    editing = text.editing
    found = editing.references(text.lines, line, at) if isinstance(editing, SourceEditing) else []
    return [_location(text, *each) for each in found]


def _location(text: Text, line: int, column: int, length: int) -> lsp.Location:
    return lsp.Location(text.document.uri, text.span((line, column), (line, column + length)))


FEATURES: dict[str, Callable[..., object]] = {
    lsp.TEXT_DOCUMENT_DID_OPEN: did_open,
    lsp.TEXT_DOCUMENT_DID_CHANGE: did_change,
    lsp.TEXT_DOCUMENT_DID_CLOSE: did_close,
    lsp.SHUTDOWN: shutdown,
    lsp.TEXT_DOCUMENT_HOVER: hover,
    lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL: symbols,
    lsp.TEXT_DOCUMENT_DEFINITION: definition,
    lsp.TEXT_DOCUMENT_REFERENCES: references,
}
"""Handlers of protocol features that have no options."""
