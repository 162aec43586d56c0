"""The documentation as a folder of HTML pages, made from the Markdown files that come with axistwin.

The pages need no other program and no network.  The tables of commands, options and codes are only on the documentation
site; `axistwin commands`, `axistwin COMMAND --help` and `axistwin check --codes` print these tables.
"""

import html
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

from markdown_it import MarkdownIt
from markdown_it.token import Token

from axistwin.core.version import VERSION
from axistwin.ui.guide.shipped import examples, folder

START = "index"
SITE_ONLY = ("changelog", "contributing", "reference/api")  # Pages left out, because they only include other files.
GENERATED_EXAMPLE = "generated/examples/"
_directive = re.compile(r"^```\{(?P<kind>[\w-]+)\}(?P<argument>[^\n]*)\n(?P<body>.*?)^```\n", re.DOTALL | re.MULTILINE)
_link = re.compile(r"^(?P<path>(?![a-z]+:)[^#]+)\.md(?P<anchor>#.*)?$")
_title = re.compile(r"^# (.*)$", re.MULTILINE)
STYLE = """
:root { color-scheme: light dark; --edge: #8884; --link: light-dark(#0b57a4, #8ab8f5) }
body { margin: 0; font: 16px/1.55 system-ui, sans-serif; display: grid; grid-template-columns: 15rem minmax(0, 1fr) }
nav { padding: 1.5rem 1rem; border-right: 1px solid var(--edge); font-size: .92rem }
nav ul { list-style: none; padding: 0; margin: .3rem 0 1.2rem } nav b { display: block }
main { padding: 1rem 2rem 4rem; max-width: 62rem } a { color: var(--link) }
pre { overflow-x: auto; padding: .8rem 1rem; border: 1px solid var(--edge); border-radius: .4rem }
code, pre { font: .88rem/1.45 ui-monospace, monospace } img { max-width: 100% }
table { border-collapse: collapse; display: block; overflow-x: auto }
td, th { border: 1px solid var(--edge); padding: .3rem .6rem; text-align: left; vertical-align: top }
@media (max-width: 50rem) { body { display: block } nav { border: 0 } }
"""


def names() -> dict[str, str]:
    """Return the titles of all pages, by name, e.g. `tutorials/pyserial`; `index` is first."""
    root = folder("docs")
    found = {path.relative_to(root).with_suffix("").as_posix(): path for path in sorted(root.rglob("*.md"))}
    kept = {name: path for name, path in found.items() if name not in SITE_ONLY and not name.startswith("generated")}
    titles = {name: _first_title(path.read_text(encoding="utf-8"), name) for name, path in kept.items()}
    return {START: titles.pop(START), **titles}


def text(name: str) -> str:
    """Return the Markdown text of a page, without instructions for the program Sphinx."""
    return _directive.sub(_as_text, (folder("docs") / f"{name}.md").read_text(encoding="utf-8"))


def build(target: Path) -> Path:
    """Write all pages, pictures and examples to the folder `target`; return the folder of `index.html`."""
    source, out = folder("docs"), target / "docs"
    listed = names()
    for name in listed:
        _write(out / f"{name}.html", text(name), _contents(source, listed, "../" * name.count("/")))
    shutil.copytree(source / "images", out / "images", dirs_exist_ok=True)
    for example in examples().values():
        for path in example.files:
            place = target / "examples" / path.relative_to(folder("examples"))
            place.parent.mkdir(parents=True, exist_ok=True)
            if path.suffix == ".md":
                _write(place.with_suffix(".html"), path.read_text(encoding="utf-8"), "")
            else:
                shutil.copyfile(path, place)
    return out


def _first_title(page: str, name: str) -> str:
    found = _title.search(page)
    return found[1].replace("`", "") if found else name


def _as_text(directive: "re.Match[str]") -> str:
    if directive["kind"] == "include" and "codes" in directive["argument"]:
        return "`axistwin check --codes` lists the codes.\n"
    return ""


def _contents(source: Path, listed: dict[str, str], up: str) -> str:
    parts = [f'<a href="{up}index.html">axistwin {VERSION}</a>']
    for directive in _directive.finditer((source / f"{START}.md").read_text(encoding="utf-8")):
        caption = re.search(r":caption: (.*)", directive["body"])
        rows = "".join(_rows(directive["body"].split(), listed, up))
        parts.append(f"<b>{html.escape(caption[1] if caption else '')}</b><ul>{rows}</ul>")
    return "".join(parts)


def _rows(words: list[str], listed: dict[str, str], up: str) -> Iterator[str]:
    for name in words:
        if name in listed:
            yield f'<li><a href="{up}{name}.html">{html.escape(listed[name])}</a></li>'
        elif name.startswith(GENERATED_EXAMPLE):
            place = name.removeprefix(GENERATED_EXAMPLE)
            yield f'<li><a href="{up}../examples/{place}.html">{html.escape(place.partition("/")[0])}</a></li>'


def _write(path: Path, page: str, contents: str) -> None:
    parser = MarkdownIt("commonmark").enable("table")
    tokens = parser.parse(page)
    _link_pages(tokens)
    body = parser.renderer.render(tokens, parser.options, {})
    title = html.escape(_first_title(page, path.stem))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        f'<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        f"<title>{title}</title><style>{STYLE}</style><nav>{contents}</nav><main>{body}</main></html>",
        encoding="utf-8",
    )


def _link_pages(tokens: list[Token]) -> None:
    for place, token in enumerate(tokens):
        if token.type == "heading_open":
            heading = tokens[place + 1].content.lower()
            token.attrSet("id", re.sub(r"[^\w\- ]", "", heading).strip().replace(" ", "-"))
        for child in token.children or ():
            if child.type == "link_open" and (found := _link.match(str(child.attrGet("href")))):
                child.attrSet("href", f"{found['path']}.html{found['anchor'] or ''}")
