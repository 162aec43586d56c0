"""The conversation with a controller: the messages at an endpoint with the tutor's notes, for all pages."""

from importlib import resources


def asset(name: str) -> str:
    """Return the text of the file `log.js` or `log.css`, which a page with a conversation contains."""
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")
