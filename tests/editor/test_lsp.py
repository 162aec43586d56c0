"""The language server over standard input and output, as an editor uses it."""

import asyncio
import json
import subprocess
import sys
from types import SimpleNamespace

import pytest

from axistwin.cli.authoring import lsp
from axistwin.cli.program import axistwin
from axistwin.core.errors import MissingExtraError

from .lsp_client import ROOT, Client

SOURCE = """\
UCI UDI ZS
A100 'ä
GOSUB5
END
C5 'the stroke
V=100000
RETURN
"""


@pytest.fixture(scope="module")
def client():
    with Client() as made:
        yield made


def spans(found):
    return [
        (d["code"], d["range"]["start"]["line"], d["range"]["start"]["character"], d["range"]["end"]["character"])
        for d in found
    ]


@pytest.mark.slow
def test_the_capabilities_of_the_server(client):
    assert client.capabilities["hoverProvider"] and client.capabilities["documentSymbolProvider"]
    assert client.capabilities["codeActionProvider"]["codeActionKinds"] == ["quickfix"]
    assert "=" in client.capabilities["completionProvider"]["triggerCharacters"]


def test_diagnostics_are_published_during_typing(client):
    uri = "file:///bench/home.sms"
    assert spans(client.open(uri, SOURCE)) == [("SM103", 1, 0, 4)]
    change = {"range": {"start": {"line": 1, "character": 1}, "end": {"line": 1, "character": 1}}, "text": "="}
    client.tell("textDocument/didChange", {"textDocument": {"uri": uri, "version": 2}, "contentChanges": [change]})
    assert client.diagnostics(uri, 2) == []
    client.tell("textDocument/didClose", {"textDocument": {"uri": uri}})


def test_only_the_latest_text_is_checked_during_fast_typing(client):
    uri, last = "file:///bench/quick.sms", 40
    client.open(uri, "END\n")
    changes = (
        {"textDocument": {"uri": uri, "version": version}, "contentChanges": [{"text": f"A{version}\n"}]}
        for version in range(2, last + 1)
    )
    client.tell_all("textDocument/didChange", changes)
    assert spans(client.diagnostics(uri, last)) == [("SM103", 0, 0, 3)]
    told = [message for message in client.notified if message.get("params", {}).get("uri") == uri]
    assert len(told) < last / 4


def test_a_text_that_is_too_long_is_not_checked(client):
    uri = "file:///bench/long.sms"
    (told,) = client.open(uri, "A100\n" * 30_000)
    assert told["message"] == "more than 131,072 characters: not checked during typing, use axistwin check"
    assert told["severity"] == 3 and client.at("hover", uri, 0, 0) is None
    client.tell(
        "textDocument/didChange", {"textDocument": {"uri": uri, "version": 2}, "contentChanges": [{"text": ""}]}
    )
    assert client.diagnostics(uri, 2) == []


@pytest.mark.slow
def test_the_process_of_the_server_checks_nothing(monkeypatch):
    """A check in this process would delay completion: one thread of Python runs at a time."""
    from pygls.workspace import TextDocument  # lazy imports: pygls is needed by no other test in this process

    from axistwin.ui.editor import checks
    from axistwin.ui.editor.documents import Text
    from axistwin.ui.editor.server import make

    written, server = [], make()
    server.protocol.set_writer(SimpleNamespace(write=written.append))
    monkeypatch.setattr(server, "text", lambda uri: Text(TextDocument(uri, "A100\n", version=3)))
    monkeypatch.setattr(checks, "diagnose", None)

    async def play():
        server.publish("file:///a.sms")
        await asyncio.gather(*(asyncio.all_tasks() - {asyncio.current_task()}))

    asyncio.run(play())
    server.shutdown()
    head, _, body = written[0].partition(b"\r\n\r\n")
    assert head == b"Content-Length: %d" % len(body)
    published = json.loads(body)
    assert (published["method"], published["params"]["version"]) == ("textDocument/publishDiagnostics", 3)
    assert spans(published["params"]["diagnostics"]) == [("SM103", 0, 0, 4)]


@pytest.mark.slow
def test_the_exit_code_without_a_shutdown_request():
    """ "The server should exit with success code 0 if the shutdown request has been received before; otherwise 1"."""
    client = Client()
    client.tell("exit", None)
    client.process.stdin.close()
    assert client.process.wait() == 1
    client.process.stdout.close()


def test_a_fix_is_offered_and_a_sure_fix_is_preferred(client):
    uri = "file:///bench/fix.if1"
    client.open(uri, "X100$\n:X100:Y\n")
    place = {"line": 1, "character": 7}
    (action,) = client.ask(
        "textDocument/codeAction",
        {"textDocument": {"uri": uri}, "range": {"start": place, "end": place}, "context": {"diagnostics": []}},
    )
    assert (action["title"], action["kind"], action["isPreferred"]) == ("End the sequence with :$", "quickfix", True)
    assert action["edit"]["changes"][uri] == [{"range": {"start": place, "end": place}, "newText": ":$"}]


def test_columns_are_utf_16_units(client):
    uri = "file:///bench/wide.talk"
    found = client.open(uri, "; model: if1\n; \U0001f600\n> (U61\\r\n> X1\\q\n; \U0001f600 = \n= \U0001f600\n")
    assert spans(found) == [("AX105", 3, 4, 6), ("AX103", 5, 4, 4)]


def test_hover_shows_the_command_its_units_and_the_chapter(client):
    uri = "file:///bench/move.if1"
    client.open(uri, "X1000@500$\n")
    told = client.at("hover", uri, 0, 7)
    assert told["range"] == {"start": {"line": 0, "character": 5}, "end": {"line": 0, "character": 8}}
    assert "**@** speed data" in told["contents"]["value"] and "speed 1…99999 steps/s" in told["contents"]["value"]
    assert told["contents"]["value"].endswith("Manual: Speed")


def test_completion_offers_labels(client):
    uri = "file:///bench/labels.sms"
    client.open(uri, SOURCE)
    assert [each["label"] for each in client.at("completion", uri, 2, 5)["items"]] == ["GOSUB5"]


def test_symbols_are_the_labels(client):
    uri = "file:///bench/symbols.sms"
    client.open(uri, SOURCE)
    (symbol,) = client.ask("textDocument/documentSymbol", {"textDocument": {"uri": uri}})
    assert (symbol["name"], symbol["detail"], symbol["range"]["start"]["line"]) == ("C5", "the stroke", 4)


def test_a_scene_and_another_toml_file(client):
    scene = "file:///bench/bench.toml"
    assert spans(client.open(scene, '[[controller]]\nmodle = "if1"\n')) == [("SC103", 0, 0, 14), ("SC102", 1, 0, 5)]
    assert client.open("file:///bench/pyproject.toml", "[project]\nname = 1\n") == []


def test_each_bad_wire_and_fault_is_marked_at_its_value(client):
    lines = (
        '[[controller]]\nmodel = "if1"\n[[fault]]\nkind = "löse"\n[[wire]]\nfrom = "if1.outputé"\nto = "if1.input1"\n'
        '[[wire]]\nfrom = "if1.output1"\nto = "if1.input9"\n'
    )
    found = client.open("file:///bench/two.toml", lines)
    assert spans(found) == [("SC110", 3, 7, 13), ("SC110", 5, 7, 20), ("SC110", 9, 5, 17)]
    assert "unknown kind of fault 'löse': did you mean 'lose'?" in found[0]["message"]


def test_a_call_leads_to_its_label_and_a_label_to_its_calls(client):
    uri = "file:///bench/calls.sms"
    client.open(uri, "GOSUB5\nIF a GOTO5 ENDIF\nGOTO7\nEND\nC5\nRETURN\n")
    label = {"uri": uri, "range": {"start": {"line": 4, "character": 0}, "end": {"line": 4, "character": 2}}}
    assert client.at("definition", uri, 0, 2) == label and client.at("definition", uri, 2, 2) is None
    assert client.at("definition", uri, 3, 1) is None
    asked = {
        "textDocument": {"uri": uri}, "position": {"line": 4, "character": 1}, "context": {"includeDeclaration": True},
    }  # fmt: skip
    places = [found["range"]["start"] for found in client.ask("textDocument/references", asked)]
    assert [(place["line"], place["character"]) for place in places] == [(0, 0), (1, 5), (4, 0)]


def test_a_file_that_a_scene_names_is_opened(client, tmp_path):
    (tmp_path / "moves.if1").write_text("X1$\n")
    uri = (tmp_path / "bench.toml").as_uri()
    client.open(uri, '[[controller]]\nmodel = "if1"\nhost = ["moves.if1", "none.if1"]\n')
    assert client.at("definition", uri, 2, 10)["uri"] == (tmp_path / "moves.if1").as_uri()
    assert client.at("definition", uri, 2, 24) is None and client.at("definition", uri, 1, 2) is None


def test_a_conversation_without_a_model_has_a_warning(client):
    (found,) = client.open("file:///bench/whose.talk", "> (U61\\r\n")
    assert "unknown controller model" in found["message"]


def test_a_text_of_another_kind_is_ignored(client):
    uri = "file:///bench/notes.txt"
    assert client.open(uri, "x\n") == [] and client.at("hover", uri, 0, 0) is None
    assert client.at("completion", uri, 0, 0)["items"] == []


def test_without_the_extra_the_error_says_what_to_install(monkeypatch):
    for name in [each for each in sys.modules if each.partition(".")[0] in ("pygls", "lsprotocol")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.delitem(sys.modules, "axistwin.ui.editor.server", raising=False)
    monkeypatch.setitem(sys.modules, "pygls", None)
    monkeypatch.setitem(sys.modules, "lsprotocol", None)
    with pytest.raises(MissingExtraError, match=r'needs pygls: pip install ".*pygls.*", or in a clone .*"\.\[lsp\]"'):
        axistwin(["lsp"], standalone_mode=False)


def test_other_commands_do_not_import_the_server():
    code = (
        "import sys, axistwin.cli.authoring.lsp; "
        "print([m for m in sys.modules if m.startswith(('pygls', 'lsprotocol'))])"
    )
    told = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True,
        env={"PYTHONPATH": str(ROOT / "src"), "PATH": ""},
    ).stdout  # fmt: skip
    assert told == "[]\n" and lsp.lsp.name == "lsp"


def test_a_document_that_is_not_open_is_empty(client):
    for uri in ("file:///nothing/here.sms", "untitled:Untitled-1"):
        assert client.ask("textDocument/documentSymbol", {"textDocument": {"uri": uri}}) == []


def test_a_suffix_in_capitals_is_accepted(client):
    assert spans(client.open("file:///OLD.SMS", "FLY"))[0][0] == "SM101"


def test_a_long_line_with_many_diagnostics_is_checked_fast(client):
    assert len(client.open("file:///long.sms", "GOSUB5 " * 8000)) >= 8000
    assert [each["code"] for each in client.open("file:///deep.toml", "[[controller]]\na=" + "[" * 3000)] == ["SC101"]
    lists = "[[controller]]\na=" + "[" * 300 + "]" * 300
    assert [each["code"] for each in client.open("file:///lists.toml", lists)] == ["SC101"]


@pytest.mark.slow
@pytest.mark.parametrize("length", [b"abc", b"-1", b"9" * 30])
def test_a_wrong_length_ends_the_server_in_a_line(length):
    ended = subprocess.run(
        [sys.executable, "-c", "from axistwin.cli.program import main; main(['lsp'])"],
        input=b"Content-Length: " + length + b"\r\n\r\n{}", capture_output=True, check=False,
    )  # fmt: skip
    assert (ended.returncode, ended.stderr.count(b"\n")) == (2, 1)
    assert b"expected the number of bytes, e.g. Content-Length: 120" in ended.stderr
