"""`axistwin lsp`: the language server, started by editors."""

import gc
import os
import re
import sys
from typing import BinaryIO, cast

import click

from axistwin.core.errors import UsageError, require

LENGTH = re.compile(rb"Content-Length: [1-9][0-9]{0,8}\r\n")


@click.command()
def lsp() -> int:
    """Run the language server for editors on standard input and output.

    In programs (.sms, .if1, .181x), conversations (.talk) and scenes (.toml) the editor then shows the diagnostics of
    `axistwin check` during typing, the meaning of a command (parameters, units, the manual's chapter), completions,
    fixes, and the labels, sequences and moves of a program.  docs/editors.md has the settings for VS Code, Neovim,
    Helix and Emacs.

    Needs the extra lsp: pip install ".[lsp]" in a clone.  Exit code 1 if the editor ends it without a `shutdown`.

    \b
    Example, in Helix's languages.toml:
      [language-server.axistwin]
      command = "axistwin"
      args = ["lsp"]
    """
    require("pygls", "lsp")
    from axistwin.ui.editor.server import make

    # Pass copies of stdin and stdout to the language server, because the server closes the streams that it uses.
    with os.fdopen(os.dup(sys.stdin.fileno()), "rb") as heard, os.fdopen(os.dup(sys.stdout.fileno()), "wb") as said:
        server = make()
        # Shorten garbage collections: without gc.freeze(), a garbage collection delays a request by 50 ms.
        gc.freeze()
        server.start_io(cast("BinaryIO", _Checked(heard)), said)
    return 0 if server.asked_to_end else 1


class _Checked:
    """The editor's messages.  A wrong length would lose all later messages, so it ends the server."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream, self.read, self.close = stream, stream.read, stream.close

    def readline(self) -> bytes:
        line = self._stream.readline()
        if line.lower().startswith(b"content-length") and not LENGTH.fullmatch(line):
            raise UsageError(
                f"invalid header {line[:60]!r} from the editor: expected the number of bytes, e.g. Content-Length: 120"
            )
        return line
