"""The example and the table in `docs/programs.md` are correct."""

import re
from pathlib import Path

from axistwin.bench import product
from axistwin.controllers.registry import OURS

PAGE = (Path(__file__).parents[2] / "docs" / "programs.md").read_text(encoding="utf-8")
((_, PROGRAM), (_, SHOWN)) = re.findall(r"^```(\w*)\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)


def test_the_example_of_the_page_is_correct(capsys):
    exec(compile(PROGRAM, "docs/programs.md", "exec"), {})
    assert capsys.readouterr().out == SHOWN


def test_the_names_are_those_of_the_products():
    names = {name for model in OURS for name in (product(model).programs[0], product(model).programs[-1])}
    assert all(f"`{name}`" in PAGE for name in names)
