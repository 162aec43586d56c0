"""The settings in docs/editors.md are valid for their editors."""

import json
import re
import tomllib
from pathlib import Path

PAGE = (Path(__file__).parents[2] / "docs" / "editors.md").read_text(encoding="utf-8")


def block(language):
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


def test_the_settings_of_vs_code_and_helix_can_be_read():
    (settings,) = map(json.loads, block("json"))
    assert [settings["glspc.server.command"], *settings["glspc.server.commandArguments"]] == ["axistwin", "lsp"]
    (languages,) = map(tomllib.loads, block("toml"))
    assert languages["language-server"]["axistwin"] == {"command": "axistwin", "args": ["lsp"]}


def test_the_lines_for_neovim_and_emacs_start_the_server():
    assert 'cmd = { "axistwin", "lsp" }' in "".join(block("lua"))
    (lisp,) = block("elisp")
    assert '("axistwin" "lsp")' in lisp
