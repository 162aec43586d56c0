"""Users and certificates of the OPC UA server."""

import hmac
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from logging import getLogger
from pathlib import Path
from time import monotonic
from typing import Any

from asyncua import Server, ua
from asyncua.common.utils import ServiceError
from asyncua.crypto.cert_gen import setup_self_signed_certificate
from asyncua.crypto.permission_rules import USER_TYPES, SimpleRoleRuleset, User, UserRole
from asyncua.crypto.truststore import TrustStore
from asyncua.crypto.validator import CertificateValidator, CertificateValidatorOptions
from cryptography.x509.oid import ExtendedKeyUsageOID

from axistwin.core.errors import UsageError
from axistwin.core.storage import excerpt, read_file

log = getLogger("axistwin.real.integrations")

MOST_WRONG = 5  # Number of wrong passwords from which on each further attempt must wait.
PAUSE_S, MEMORY_S = 10.0, 600.0  # After a wrong password: attempts are refused, and it counts, in seconds.
MOST_GUESSERS = 1000
APPLICATION = "urn:axistwin:server"
ROLES = {"operator": UserRole.User, "viewer": UserRole.Anonymous}
COMMANDS = (ua.ObjectIds.WriteRequest_Encoding_DefaultBinary, ua.ObjectIds.CallRequest_Encoding_DefaultBinary)
"""Services that a viewer must not use."""


@dataclass(frozen=True)
class Account:
    """The password and the role of a user."""

    password: str
    role: str


def read_users(path: Path) -> dict[str, Account]:
    """Read the names, passwords and roles of users from a file.

    Each user has a line, e.g. `anna k7Rw2p operator`.  The roles are `operator` and `viewer`.  Raises UsageError if the
    file cannot be read or a line is invalid.
    """
    found = {}
    try:
        lines = read_file(path).decode().splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"cannot read the names and passwords of users from {path}: {error}") from None
    for number, line in enumerate(lines, 1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if len(words) != 3 or words[2] not in ROLES:
            raise UsageError(
                f"{path}:{number}: invalid user: expected NAME PASSWORD operator|viewer, e.g. anna k7Rw2p operator"
            )
        found[words[0]] = Account(words[1], words[2])
    if not found:
        raise UsageError(f"{path} has no users: expected at least one line, e.g. 'anna k7Rw2p operator'")
    return found


class Guesses:
    """Counts wrong passwords by client address and user, and refuses attempts that come too fast after them.

    `names`: the names of the users; wrong passwords of all other names of an address count together.
    """

    def __init__(self, names: Collection[str]) -> None:
        self._names = names
        self._wrong: dict[tuple[str, str | None], tuple[int, float]] = {}
        """Number of wrong passwords, and time of the last one in seconds; the latest is last."""

    def check(self, address: str, user: str | None) -> None:
        """Raise ServiceError if the user must wait; an attempt that is refused does not prolong the time."""
        number, last_s = self._wrong.get(self._key(address, user), (0, 0.0))
        if number >= MOST_WRONG and monotonic() < last_s + PAUSE_S:
            raise ServiceError(ua.StatusCodes.BadUserAccessDenied)

    def note_wrong(self, address: str, user: str | None) -> None:
        now_s, key = monotonic(), self._key(address, user)
        self._wrong = {known: each for known, each in self._wrong.items() if now_s < each[1] + MEMORY_S}
        number = self._wrong.pop(key, (0, 0.0))[0] + 1
        self._wrong[key] = number, now_s
        if len(self._wrong) > MOST_GUESSERS:
            del self._wrong[next(iter(self._wrong))]
        if number >= MOST_WRONG:
            log.warning(
                "%d wrong passwords of %s from %s: further attempts are refused for %d s",
                number, key[1] or "unknown users", address, PAUSE_S,
            )  # fmt: skip

    def note_right(self, address: str, user: str | None) -> None:
        self._wrong.pop(self._key(address, user), None)

    def _key(self, address: str, user: str | None) -> tuple[str, str | None]:
        return address, user if user in self._names else None


class Users:
    """Checks the names and passwords of users for the OPC UA server."""

    def __init__(self, accounts: Mapping[str, Account]) -> None:
        self._accounts = accounts

    @property
    def names(self) -> Collection[str]:
        return self._accounts.keys()

    def get_user(
        self,
        _: object,
        username: str | None = None,
        password: str | None = None,
        certificate: Any = None,  # noqa: ARG002
    ) -> User | None:
        """Return the user with this name and password; None if the name or the password is wrong."""
        account = self._accounts.get(username or "")
        if account is None or not hmac.compare_digest(account.password.encode(), (password or "").encode()):
            return None
        return User(role=ROLES[account.role], name=username)


class Rules(SimpleRoleRuleset):
    """Access rules: an operator may write values and call methods, but a viewer may only read."""

    def __init__(self) -> None:
        super().__init__()
        allowed = {ua.NodeId(kind) for kind in USER_TYPES if kind not in COMMANDS}
        self._permission_dict[UserRole.Anonymous] = allowed


async def secure(server: Server, users: bool, folder: Path | None, host: str) -> None:
    """Set up the login and the encryption of an OPC UA server.

    With `users`, a client must log in with a name and a password.  With a folder, messages are signed and encrypted
    with `key.pem` and `certificate.der` in the folder; missing files are made.  If the folder has a subfolder
    `trusted`, only clients with certificates in it can connect.
    """
    if users:
        server.set_identity_tokens([ua.UserNameIdentityToken])
    if folder is None:
        server.set_security_policy([ua.SecurityPolicyType.NoSecurity], permission_ruleset=Rules())
        return
    try:
        await _load(server, folder, host)
    except (OSError, ValueError, TypeError) as error:
        raise UsageError(
            f"cannot use the certificates in {folder} ({excerpt(error)}): delete key.pem and certificate.der, which "
            "are then made again, and whatever is no certificate in the folder `trusted`"
        ) from None
    server.set_security_policy([ua.SecurityPolicyType.Basic256Sha256_SignAndEncrypt], permission_ruleset=Rules())


async def _load(server: Server, folder: Path, host: str) -> None:
    """Load the files of a folder of certificates.  Raises UsageError, or OSError, ValueError or TypeError."""
    folder.mkdir(parents=True, exist_ok=True)
    key, certificate, trusted = folder / "key.pem", folder / "certificate.der", folder / "trusted"
    await setup_self_signed_certificate(
        key, certificate, APPLICATION, host, [ExtendedKeyUsageOID.SERVER_AUTH], {"commonName": "axistwin"}
    )
    key.chmod(0o600)
    await server.load_certificate(certificate)
    await server.load_private_key(key)
    if trusted.is_dir():
        if not any(path.suffix.lower() in (".der", ".pem") for path in trusted.iterdir()):
            raise UsageError(
                f"{trusted} contains no certificate, and no client could connect: expected files that end in .der or "
                ".pem; delete the folder to accept every client"
            )
        store = TrustStore([trusted], [])
        await store.load()
        options = CertificateValidatorOptions.TRUSTED_VALIDATION | CertificateValidatorOptions.PEER_CLIENT
        server.set_certificate_validator(CertificateValidator(options, store))
