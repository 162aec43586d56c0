"""The documentation site: `make docs` builds it into build/docs; a warning fails the build."""

import os
import re
import sys
from pathlib import Path

from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx

sys.path.insert(0, str(Path(__file__).parent))

import generate

import axistwin
from axistwin.ui.playground.building import build

project = "axistwin"
author = "The axistwin developers"
release = version = axistwin.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["generated/codes.md", "generated/families", "generated/try.md"]  # included by other pages
myst_enable_extensions = ["deflist", "fieldlist"]
myst_heading_anchors = 3
default_role = "literal"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
nitpicky = False
highlight_language = "text"
html_theme = "furo"
html_title = f"axistwin {version}"
html_copy_source = False
html_show_sourcelink = False


ENGINE = Path(os.environ.get("AXISTWIN_ENGINE", Path(__file__).parents[1] / "build" / "engine"))
"""Folder of the playground's engine, made by `make engine`; the site contains the playground if it exists."""
OURS = ("sms", "talk", "if1", "181x", "csv", "basic")
"""Languages of code blocks without a Pygments lexer."""
EXAMPLES = re.compile(r"\]\(((?:\.\./)*)\.\./examples/([\w-]+)/README\.md\)")


def setup(app: Sphinx) -> None:
    """Write the generated pages before Sphinx reads any page."""
    generate.write(Path(__file__).parent / "generated", with_playground=ENGINE.is_dir())
    for kind in OURS:
        app.add_lexer(kind, TextLexer)
    app.connect("source-read", link_examples)
    app.connect("build-finished", add_playground)


def add_playground(app: Sphinx, failure: Exception | None) -> None:
    """Write the playground into the site."""
    if failure is None and ENGINE.is_dir():
        build(Path(app.outdir) / "playground", ENGINE)


def link_examples(app: Sphinx, name: str, source: list[str]) -> None:  # noqa: ARG001
    """Link to the site's copy of an example's page."""
    source[0] = EXAMPLES.sub(r"](\1generated/examples/\2/README.md)", source[0])
