"""Share links: web addresses whose fragment contains a scene, its files and a virtual time in compressed form."""

import json
import zlib
from base64 import urlsafe_b64decode, urlsafe_b64encode
from binascii import Error
from dataclasses import asdict, dataclass

from axistwin.core.errors import UsageError
from axistwin.core.version import VERSION

LONGEST_LINK = 200_000  # Largest number of characters of a link.
LONGEST_CONTENTS = 4_000_000  # Largest number of bytes of the decompressed contents.


@dataclass(frozen=True)
class Shared:
    """Contents of a share link: a scene's files by name, a virtual time and a version."""

    files: dict[str, str]
    at_ns: int
    version: str = VERSION


def encode(shared: Shared) -> str:
    """Compress a scene and a virtual time to the text after the `#` of a link.  Raises UsageError if too large."""
    data = json.dumps(asdict(shared), ensure_ascii=False, separators=(",", ":"), sort_keys=True).encode()
    fragment = urlsafe_b64encode(zlib.compress(data, 9)).decode().rstrip("=")
    if len(data) > LONGEST_CONTENTS or len(fragment) > LONGEST_LINK:
        raise UsageError(
            f"the scene is too large for a web link (at most {LONGEST_LINK} characters): download the scene files"
        )
    return fragment


def decode(fragment: str) -> Shared:
    """Return what the text after the `#` of a share link contains.  Raises UsageError for a damaged link."""
    if len(fragment) > LONGEST_LINK:
        raise UsageError(f"the URL of the shared scene has {len(fragment)} characters: expected at most {LONGEST_LINK}")
    inflater = zlib.decompressobj()
    try:
        packed = urlsafe_b64decode(fragment + "=" * (-len(fragment) % 4))
        data = inflater.decompress(packed, LONGEST_CONTENTS)
        if not inflater.eof:
            raise UsageError(
                "the URL of the shared scene is incomplete or too long: "
                "copy the whole URL again, or open the scene files instead"
            )
        return _shared(json.loads(data))
    except (Error, zlib.error, ValueError, RecursionError):
        raise UsageError(
            "the URL of the shared scene is damaged: copy the whole URL again, or open the scene files instead"
        ) from None


def _shared(found: object) -> Shared:
    match found:
        case {"files": dict(files), "at_ns": int(at_ns), "version": str(version)} if at_ns >= 0 and files:
            if all(isinstance(part, str) for item in files.items() for part in item):
                return Shared(files, at_ns, version)
    raise ValueError("invalid share link: expected the keys 'files', 'at_ns' and 'version'")
