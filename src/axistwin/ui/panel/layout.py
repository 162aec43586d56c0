"""The layout of a user's page: open tabs, drawers and colours, stored in a cookie of the browser.

The server keeps the layout of each user while it runs.  With the cookie, the layout also outlives the server.
"""

import json
from urllib.parse import unquote

from axistwin.ui.panel.people import Person

COOKIE = "axistwin-layout"
MOST = 2000  # Largest length of the stored text; browsers store 4096 bytes, after the encoding of quotes and spaces.
KEEP = (
    'document.cookie = "axistwin-layout=" + encodeURIComponent({text}) + "; max-age=31536000; path=/; samesite=strict"'
)
"""JavaScript that stores the text."""


def written(person: Person) -> str:
    """Return the layout of a user as text: settings that are words, or on or off; the oldest are left out."""
    kept = [(key, value) for key, value in person.settings.items() if isinstance(value, bool | str)]
    while len(text := json.dumps(dict(kept), separators=(",", ":"))) > MOST:
        kept.pop(0)
    return text


def restore(person: Person, cookie: str | None) -> None:
    """Restore the layout of a new user from the cookie; an invalid cookie is ignored."""
    if person.settings or cookie is None:
        return
    try:
        found = json.loads(unquote(cookie))
    except ValueError:
        return
    if isinstance(found, dict):
        person.settings |= {key: value for key, value in found.items() if isinstance(value, bool | str)}
