"""What a client that ignores the list of endpoints can do at the OPC UA server."""

import asyncio
import shutil

import pytest

from axistwin import Bench

pytestmark = pytest.mark.slow

asyncua = pytest.importorskip("asyncua", reason="asyncua is not installed")

from asyncua import ua  # noqa: E402
from asyncua.crypto import uacrypto  # noqa: E402

from axistwin.real.integrations import of_scene  # noqa: E402
from axistwin.real.integrations.opcua import security, server  # noqa: E402

from .conftest import PATIENCE, free_port  # noqa: E402
from .raw_opcua import Raw, code, raw, signing  # noqa: E402
from .test_opcua import make_certificate  # noqa: E402

USERS = {"anna": security.Account("k7Rw2p", "operator"), "bert": security.Account("x9Qv4t", "viewer")}
REJECTED = "BadSecurityPolicyRejected"


def served(visit, **options):
    """Serve a board; return what `visit(url)` returns, and whether the board has received a move."""

    async def run():
        bench = Bench()
        bench.add("1811", name="board")
        async with await of_scene(bench, {"board": PATIENCE}, speed=None) as machine:
            async with server.serving(machine, port=free_port(), **options) as url:
                found = await visit(url)
            return found, machine.stations[0].axes["motor"].core.setpoint != 0

    return asyncio.run(run())


async def attempts(client, name, password):
    return [
        await code(client.create_session()), await code(client.activate_session(name, password)),
        await client.move(10.0), await code(client.read("board.Axes.motor.Position")),
    ]  # fmt: skip


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
                await attempts(viewer, "bert", "x9Qv4t"), await attempts(operator, None, ""),
                await attempts(nobody, "anna", "k7Rw2p"), await viewer.add_a_node(), await viewer.register_a_server(),
            )  # fmt: skip

    found, moved = served(visit, users=USERS)
    assert found == (
        ["Good", "Good", "BadUserAccessDenied", "Good"],
        ["Good", "BadIdentityTokenRejected", "BadUserAccessDenied", "BadSessionNotActivated"], [REJECTED] * 4,
        "BadUserAccessDenied", "BadServiceUnsupported",
    )  # fmt: skip
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
    assert still == "Good" and not moved


def on_subscription(number, item):
    """Return each request that names a subscription, and the type of its answer."""
    found = []
    for name, parameters in (
        ("ModifySubscription", {"SubscriptionId": number}),
        ("CreateMonitoredItems", {"SubscriptionId": number, "ItemsToCreate": [Raw.item("board.Axes.motor.Position")]}),
        ("ModifyMonitoredItems", {"SubscriptionId": number, "ItemsToModify": [ua.MonitoredItemModifyRequest(item)]}),
        (
            "SetMonitoringMode",
            {"SubscriptionId": number, "MonitoringMode": ua.MonitoringMode.Disabled, "MonitoredItemIds": [item]},
        ),
        ("DeleteMonitoredItems", {"SubscriptionId": number, "MonitoredItemIds": [item]}),
        ("SetPublishingMode", {"PublishingEnabled": False, "SubscriptionIds": [number]}),
        ("Republish", {"SubscriptionId": number, "RetransmitSequenceNumber": 1}),
        ("TransferSubscriptions", {"SubscriptionIds": [number], "SendInitialValues": True}),
        ("DeleteSubscriptions", {"SubscriptionIds": [number]}),
    ):
        request = getattr(ua, f"{name}Request")()
        for key, value in parameters.items():
            setattr(request.Parameters, key, value)
        found.append((request, getattr(ua, f"{name}Response")))
    return found


def test_the_subscriptions_of_another_session_do_not_exist():
    """The same user does not own them either: a client that comes back activates its session."""

    async def visit(url):
        async with raw(url) as owner, raw(url) as thief:
            await owner.log_in("anna", "k7Rw2p")
            await thief.log_in("anna", "k7Rw2p")
            own = await owner.subscribe("board.Axes.motor.Position")
            first = (await owner.publish()).NotificationMessage
            without = await code(thief.publish((own[0], 1)))
            answers = [await thief.send(*each) for each in on_subscription(*own)]
            its = await thief.subscribe("board.Axes.motor.Position", every_ms=10)
            assert its != own
            acknowledged = (await thief.publish((own[0], 1))).Results[0].name
            kept = await owner.republish(own[0], 1)
            await owner.move(10.0)
            message = (await owner.publish()).NotificationMessage
            others = await thief.send(*on_subscription(*its)[-1])
            return without, answers, acknowledged, kept == first, len(message.NotificationData), others

    found, moved = served(visit, users=USERS)
    invalid = "BadSubscriptionIdInvalid"
    assert found == ("BadNoSubscription", [invalid] * 9, invalid, True, 1, "Good") and moved


def test_a_session_may_do_all_this_with_its_own_subscription():
    async def visit(url):
        async with raw(url) as client:
            await client.log_in()
            own = await client.subscribe("board.Axes.motor.Position")
            await client.publish()
            return [await client.send(*each) for each in on_subscription(*own)]

    assert served(visit)[0] == ["Good"] * 9


def test_a_session_has_ten_subscriptions_at_most():
    async def visit(url):
        async with raw(url) as client:
            await client.log_in()
            return [await code(client.subscribe("board.Axes.motor.Position")) for _ in range(11)]

    assert served(visit)[0] == ["Good"] * 10 + ["BadTooManySubscriptions"]


@pytest.fixture
def clock(monkeypatch):
    """Return a list with the time in seconds at which passwords are given."""
    now = [5000.0]
    monkeypatch.setattr(security, "monotonic", lambda: now[0])
    return now


def test_after_five_wrong_passwords_a_user_waits(clock, caplog):
    async def visit(url):
        async with raw(url) as client, raw(url) as other:
            await client.create_session()
            await other.create_session()
            wrong = [await code(client.activate_session("anna", f"guess{n}")) for n in range(5)]
            early = [await code(other.activate_session("anna", "k7Rw2p"))]
            clock[0] += 9.9
            early += [await code(client.activate_session("anna", "guess")) for _ in range(20)]
            another = await code(other.activate_session("bert", "x9Qv4t"))
            clock[0] += 0.1
            late = await code(client.activate_session("anna", "k7Rw2p"))
            anew = [await code(client.activate_session("anna", password)) for password in ("guess", "k7Rw2p")]
            return wrong, early, another, late, anew

    denied = "BadUserAccessDenied"
    found, _ = served(visit, users=USERS)
    assert found == ([denied] * 5, [denied] * 21, "Good", "Good", [denied, "Good"])
    assert caplog.messages == ["5 wrong passwords of anna from 127.0.0.1: further attempts are refused for 10 s"]


def test_wrong_passwords_count_by_address_and_are_forgotten(clock):
    guesses = security.Guesses(USERS)

    def waits(address, user):
        try:
            guesses.check(address, user)
        except ua.UaError:
            return True
        return False

    for n in range(4):
        guesses.note_wrong("10.0.0.1", "anna")
        guesses.note_wrong("10.0.0.1", f"nobody{n}")
    assert not waits("10.0.0.1", "anna")
    guesses.note_wrong("10.0.0.1", "anna")
    guesses.note_wrong("10.0.0.1", None)
    asked = [("10.0.0.1", "anna"), ("10.0.0.1", "x"), ("10.0.0.1", "bert"), ("10.0.0.2", "anna")]
    assert [waits(*each) for each in asked] == [True, True, False, False]
    clock[0] += 600
    guesses.note_wrong("10.0.0.1", "anna")  # the first of new ones
    assert not waits("10.0.0.1", "anna")
    for n in range(2000):
        guesses.note_wrong(f"10.1.{n // 200}.{n % 200}", "anna")
    assert len(guesses._wrong) == 1000
