"""The documentation site: `make docs` builds it into build/docs; a warning fails the build."""

import re
import sys
from pathlib import Path

from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx

sys.path.insert(0, str(Path(__file__).parent))

import generate

import axistwin

project = "axistwin"
author = "The axistwin developers"
release = version = axistwin.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["generated/codes.md"]  # included by diagnostics.md
myst_enable_extensions = ["deflist", "fieldlist"]
myst_heading_anchors = 3
default_role = "literal"
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
nitpicky = False
highlight_language = "text"
html_theme = "furo"
html_title = f"axistwin {version}"
html_copy_source = False
html_show_sourcelink = False


OURS = ("sms", "talk", "if1", "181x", "csv", "basic")
"""Languages of code blocks without a Pygments lexer."""
EXAMPLES = re.compile(r"\]\(((?:\.\./)*)\.\./examples/([\w-]+)/README\.md\)")


def setup(app: Sphinx) -> None:
    """Write the generated pages before Sphinx reads any page."""
    generate.write(Path(__file__).parent / "generated")
    for kind in OURS:
        app.add_lexer(kind, TextLexer)
    app.connect("source-read", link_examples)


def link_examples(app: Sphinx, name: str, source: list[str]) -> None:  # noqa: ARG001
    """Link to the site's copy of an example's page."""
    source[0] = EXAMPLES.sub(r"](\1generated/examples/\2/README.md)", source[0])
