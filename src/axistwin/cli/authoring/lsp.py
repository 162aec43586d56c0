"""`axistwin lsp`: the language server, started by editors."""

import gc
import os
import sys

import click

from axistwin.errors import require


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
    from axistwin.editor.server import make

    # Pass copies of stdin and stdout to the language server, because the server closes the streams that it uses.
    with os.fdopen(os.dup(sys.stdin.fileno()), "rb") as heard, os.fdopen(os.dup(sys.stdout.fileno()), "wb") as said:
        server = make()
        # Shorten garbage collections: without gc.freeze(), a garbage collection delays a request by 50 ms.
        gc.freeze()
        server.start_io(heard, said)
    return 0 if server.asked_to_end else 1
