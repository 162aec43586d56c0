"""The language server: provides diagnostics and `axistwin.ui.editor` by the Language Server Protocol.

In the protocol, columns are in UTF-16 units and the first line is 0.
"""

import asyncio
from collections.abc import Callable

from lsprotocol import types as lsp
from pygls.lsp.server import LanguageServer
from pygls.workspace import TextDocument

from axistwin.core.version import VERSION
from axistwin.ui.editor import checks
from axistwin.ui.editor.answers import Item, Symbol
from axistwin.ui.editor.background import Background
from axistwin.ui.editor.checks import Snapshot
from axistwin.ui.editor.documents import Text
from axistwin.ui.editor.scene import Scenes
from axistwin.ui.editor.smartmotor import SourceEditing

PAUSE_S = 0.2  # Pause in typing, in seconds, after which diagnostics are sent to the editor.
EXAMPLES = {
    "a.sms": "", "a.if1": "", "a.181x": "", "a.talk": "; model: 1811\n> ", "b.talk": "; model: if1\n! ",
    "a.toml": '[[controller]]\nmodel = "smartmotor"\nmaster = ',
}  # fmt: skip
"""Texts of each kind that end at a completion."""
ITEMS = {
    "command": lsp.CompletionItemKind.Keyword, "value": lsp.CompletionItemKind.Value,
    "variable": lsp.CompletionItemKind.Variable, "label": lsp.CompletionItemKind.Reference,
    "key": lsp.CompletionItemKind.Property, "pin": lsp.CompletionItemKind.Field,
}  # fmt: skip
SYMBOLS = {
    "label": lsp.SymbolKind.Function, "sequence": lsp.SymbolKind.Array, "step": lsp.SymbolKind.Event,
    "move": lsp.SymbolKind.Constant, "table": lsp.SymbolKind.Object,
}  # fmt: skip


class Server(LanguageServer):
    """The language server for one editor."""

    def __init__(self) -> None:
        super().__init__("axistwin", VERSION)
        self.asked_to_end = False
        self._background = Background()
        self._due: dict[str, asyncio.TimerHandle] = {}
        self._checks: dict[str, asyncio.Task[None]] = {}

    def text(self, uri: str) -> Text:
        return Text(self.workspace.get_text_document(uri))

    def publish(self, uri: str) -> None:
        """Check a document in the background, and send its diagnostics; a newer check cancels this one."""
        self._cancel(uri)
        self._checks[uri] = asyncio.get_running_loop().create_task(self._publish(uri))

    async def _publish(self, uri: str) -> None:
        message = await self._background.run(checks.notification, self._snapshot(uri))
        assert self.protocol.writer is not None, "the server has been started"
        self.protocol.writer.write(b"Content-Length: %d\r\n\r\n%s" % (len(message), message))

    def publish_soon(self, uri: str) -> None:
        """Check a document after a pause in typing, and send its diagnostics to the editor."""
        self._cancel(uri)
        self._due[uri] = asyncio.get_running_loop().call_later(PAUSE_S, self.publish, uri)

    async def actions(self, uri: str, wanted: lsp.Range) -> list[lsp.CodeAction]:
        return await self._background.run(checks.actions, self._snapshot(uri), wanted)

    def close_document(self, uri: str) -> None:
        self._cancel(uri)
        self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, []))

    def shutdown(self) -> None:
        self._background.close()
        super().shutdown()  # type: ignore[no-untyped-call]

    def _snapshot(self, uri: str) -> Snapshot:
        document = self.text(uri).document
        return Snapshot(uri, document.source, document.version, document.position_codec.encoding)

    def _cancel(self, uri: str) -> None:
        for due in (self._due.pop(uri, None), self._checks.pop(uri, None)):
            if due is not None:
                due.cancel()


def make() -> Server:
    server = Server()
    for feature, answer in FEATURES.items():
        server.feature(feature)(answer)
    options = lsp.CompletionOptions(trigger_characters=["=", "!", ".", ":", " ", '"', "["])
    server.feature(lsp.TEXT_DOCUMENT_COMPLETION, options)(complete)
    actions = lsp.CodeActionOptions([lsp.CodeActionKind.QuickFix])
    server.feature(lsp.TEXT_DOCUMENT_CODE_ACTION, actions)(code_actions)
    _load_languages(server)
    return server


def _load_languages(server: Server) -> None:
    """Load all completions, so that the first one in each type of file is not slow."""
    for name, lines in EXAMPLES.items():
        text = Text(TextDocument(f"file:///{name}", lines))
        server.protocol._converter.unstructure(_completions(text, len(text.lines), len(text.lines[-1])))


# Documents


def did_open(server: Server, params: lsp.DidOpenTextDocumentParams) -> None:
    server.publish(params.text_document.uri)


def did_change(server: Server, params: lsp.DidChangeTextDocumentParams) -> None:
    server.publish_soon(params.text_document.uri)


def did_close(server: Server, params: lsp.DidCloseTextDocumentParams) -> None:
    server.close_document(params.text_document.uri)


def shutdown(server: Server, _: None) -> None:
    """Handle the request `shutdown`, after which the editor sends `exit`."""
    server.asked_to_end = True


# Requests


def hover(server: Server, params: lsp.HoverParams) -> lsp.Hover | None:
    text = server.text(params.text_document.uri)
    line, at = text.at(params.position)
    found = text.editing.hover(text.lines, line, at) if text.editing is not None else None
    if found is None:
        return None
    span = text.span((line, found.begin + 1), (line, found.end + 1))
    return lsp.Hover(lsp.MarkupContent(lsp.MarkupKind.Markdown, found.text), span)


def complete(server: Server, params: lsp.CompletionParams) -> lsp.CompletionList:
    text = server.text(params.text_document.uri)
    return _completions(text, *text.at(params.position))


def _completions(text: Text, line: int, at: int) -> lsp.CompletionList:
    found = text.editing.complete(text.lines, line, at) if text.editing is not None else []
    return lsp.CompletionList(False, [_item(each, number) for number, each in enumerate(found)])


def _item(item: Item, number: int) -> lsp.CompletionItem:
    """Return a completion; completions are sorted in the order of the manual."""
    documentation = lsp.MarkupContent(lsp.MarkupKind.Markdown, item.text) if item.text else None
    return lsp.CompletionItem(
        item.label, kind=ITEMS[item.kind], detail=item.detail or None, documentation=documentation,
        insert_text=item.insert or None, sort_text=f"{number:04}",
    )  # fmt: skip


def symbols(server: Server, params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
    text = server.text(params.text_document.uri)
    found = text.editing.symbols(text.lines) if text.editing is not None else []
    return [_symbol(text, each) for each in found]


def _symbol(text: Text, symbol: Symbol) -> lsp.DocumentSymbol:
    whole = text.span(symbol.begin, symbol.end)
    children = [_symbol(text, each) for each in symbol.children]
    return lsp.DocumentSymbol(symbol.name, SYMBOLS[symbol.kind], whole, whole, symbol.detail, children=children)


async def code_actions(server: Server, params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
    return await server.actions(params.text_document.uri, params.range)


def definition(server: Server, params: lsp.DefinitionParams) -> lsp.Location | None:
    """Return the definition of the label under the cursor, or the file whose name is under the cursor."""
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
    text = server.text(params.text_document.uri)
    line, at = text.at(params.position)
    editing = text.editing
    found = editing.references(text.lines, line, at) if isinstance(editing, SourceEditing) else []
    return [_location(text, *each) for each in found]


def _location(text: Text, line: int, column: int, length: int) -> lsp.Location:
    return lsp.Location(text.document.uri, text.span((line, column), (line, column + length)))


FEATURES: dict[str, Callable[..., object]] = {
    lsp.TEXT_DOCUMENT_DID_OPEN: did_open, lsp.TEXT_DOCUMENT_DID_CHANGE: did_change,
    lsp.TEXT_DOCUMENT_DID_CLOSE: did_close, lsp.SHUTDOWN: shutdown, lsp.TEXT_DOCUMENT_HOVER: hover,
    lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL: symbols, lsp.TEXT_DOCUMENT_DEFINITION: definition,
    lsp.TEXT_DOCUMENT_REFERENCES: references,
}  # fmt: skip
"""Handlers of protocol features that have no options."""
