"""Language support for editors: meaning of a word, completions at a place, structure of a text.

There is one module per kind of text.  Only `axistwin.editor.server` depends on the Language Server Protocol.
"""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.editor.background import Background
    from axistwin.editor.checks import diagnose
    from axistwin.editor.compumotor import Commands
    from axistwin.editor.digiplan import CommandLines
    from axistwin.editor.documents import Text
    from axistwin.editor.scene import Scenes
    from axistwin.editor.server import make
    from axistwin.editor.smartmotor import SourceEditing, outline, parsed
    from axistwin.editor.talk import Conversations
else:
    __getattr__ = lazy(
        __name__,
        background="Background",
        checks="diagnose",
        compumotor="Commands",
        digiplan="CommandLines",
        documents="Text",
        scene="Scenes",
        server="make",
        smartmotor="SourceEditing outline parsed",
        talk="Conversations",
    )

__all__ = [
    "Background", "CommandLines", "Commands", "Conversations", "Scenes", "SourceEditing", "Text", "diagnose",
    "make", "outline", "parsed",
]  # fmt: skip
