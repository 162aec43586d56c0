"""What a client that ignores the list of endpoints can do at the OPC UA server."""

import asyncio
import shutil

import pytest

from axistwin import Bench

asyncua = pytest.importorskip("asyncua", reason="asyncua is not installed")

from asyncua.crypto import uacrypto  # noqa: E402

from axistwin.integrations import of_scene  # noqa: E402
from axistwin.integrations.opcua import security, server  # noqa: E402

from .conftest import free_port  # noqa: E402
from .raw_opcua import code, raw, signing  # noqa: E402
from .test_opcua import make_certificate  # noqa: E402

USERS = {"anna": security.Account("k7Rw2p", "operator"), "bert": security.Account("x9Qv4t", "viewer")}
REJECTED = "BadSecurityPolicyRejected"


def served(visit, **options):
    """Serve a board; return what `visit(url)` returns, and whether the board has received a move."""

    async def run():
        bench = Bench()
        bench.add("1811", name="board")
        async with await of_scene(bench, {}, speed=None) as machine:
            async with server.serving(machine, port=free_port(), **options) as url:
                found = await visit(url)
            return found, machine.stations[0].axes["motor"].core.setpoint != 0

    return asyncio.run(run())


async def attempts(client, name, password):
    """Return the answers to a session, its activation and a move."""
    return [
        await code(client.create_session()),
        await code(client.activate_session(name, password)),
        await client.move(10.0),
        await code(client.read("board.Axes.motor.Position")),
    ]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with the certificates of a friend, who is trusted, and of a stranger."""
    made = tmp_path_factory.mktemp("opcua")
    for name in ("friend", "stranger"):
        make_certificate(made, name)
    (made / "keys" / "trusted").mkdir(parents=True)
    shutil.copy(made / "friend.der", made / "keys" / "trusted")
    return made


def test_only_discovery_is_possible_without_security(folder):
    async def visit(url):
        found = []
        for channel in (True, False):
            async with raw(url, channel=channel) as client:
                found.append([each.SecurityPolicyUri.rpartition("#")[2] for each in await client.endpoints()])
                users = (("bert", "x9Qv4t"), ("anna", "k7Rw2p"), (None, ""))
                found += [await attempts(client, *user) for user in users]
                found.append([await client.register_a_server(), await client.add_a_node()])
        return found

    found, moved = served(visit, users=USERS, certificates=folder / "keys")
    assert found == [["Basic256Sha256"], *[[REJECTED] * 4] * 3, ["BadServiceUnsupported", REJECTED]] * 2
    assert not moved


def test_the_rules_stand_on_a_server_without_certificates():
    async def visit(url):
        async with raw(url) as viewer, raw(url) as operator, raw(url, channel=False) as nobody:
            return (
                await attempts(viewer, "bert", "x9Qv4t"),
                await attempts(operator, None, ""),
                await attempts(nobody, "anna", "k7Rw2p"),
                await viewer.add_a_node(),
                await viewer.register_a_server(),
            )

    found, moved = served(visit, users=USERS)
    assert found == (
        ["Good", "Good", "BadUserAccessDenied", "Good"],
        ["Good", "BadIdentityTokenRejected", "BadUserAccessDenied", "BadSessionNotActivated"],
        [REJECTED] * 4,
        "BadUserAccessDenied",
        "BadServiceUnsupported",
    )
    assert not moved


def test_nobody_is_an_administrator_or_opens_two_sessions():
    async def visit(url):
        async with raw(url) as client:
            await client.log_in("admin")
            return await client.add_a_node(), await client.move(10.0), await code(client.create_session())

    assert served(visit) == (("BadUserAccessDenied", "Good", "BadTooManySessions"), True)


def test_certificates_and_sessions_cannot_be_borrowed(folder):
    async def borrow_a_certificate(url):
        async with raw(url, await signing(folder, "stranger")) as stranger:
            friends = uacrypto.der_from_x509(await uacrypto.load_certificate(folder / "friend.der"))
            own = stranger.client.security_policy.host_certificate
            return [await code(stranger.create_session(given)) for given in (None, friends, own)]

    async def visit(url):
        found = [await borrow_a_certificate(url)]
        async with raw(url, await signing(folder, "friend")) as friend:
            await friend.log_in("anna", "k7Rw2p")
            token = friend.client.protocol.authentication_token
            found.append(type(token.Identifier))
            for policy in (None, await signing(folder, "stranger")):
                async with raw(url, policy) as thief:
                    thief.client.protocol.authentication_token = token
                    found.append((await code(thief.activate_session("anna", "guessed")), await thief.move(10.0)))
            return found, await code(friend.read("board.Axes.motor.Busy"))

    (found, still), moved = served(visit, users=USERS, certificates=folder / "keys")
    assert found == [
        ["BadCertificateInvalid", "BadCertificateInvalid", "BadCertificateUntrusted"],
        bytes,  # a number can be guessed
        (REJECTED, REJECTED),
        ("BadInternalError", "BadUserAccessDenied"),
    ]
    assert still == "Good"
    assert not moved
