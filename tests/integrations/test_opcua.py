"""The OPC UA server and asyncua's client."""

import asyncio
import shutil

import pytest

from .conftest import SLOW_COMPUTER, client, free_port, running

asyncua = pytest.importorskip("asyncua", reason="asyncua is not installed")

SESSION = """
import asyncio, json
from asyncua import Client, ua

async def code(call):
    try:
        await call
    except ua.UaStatusCodeError as error:
        return ua.StatusCode(error.code).name

async def at_rest(axis):
    busy = await axis.get_child("2:Busy")
    while await busy.read_value():
        await asyncio.sleep(0.02)

class Changes:
    def __init__(self):
        self.values = []
    def datachange_notification(self, node, value, data):
        self.values.append(value)

async def session(client):
BODY

async def main():
    client = Client(URL, timeout=300)
    SETUP
    async with client:
        print(json.dumps(await session(client)))

asyncio.run(main())
"""


def converse(url, body, setup="pass"):
    lines = "\n".join("    " + line for line in body.strip("\n").splitlines())
    return client(0, SESSION.replace("BODY", lines).replace("URL", repr(url)).replace("SETUP", setup))


@pytest.fixture(scope="module")
def url(scene_file):
    words = ["--port", str(free_port()), "--speed", "20", "--rate", "50", "--registers", "motor.a"]
    with running("opcua", str(scene_file), *words, *SLOW_COMPUTER) as made:
        yield made["url"]


@pytest.mark.slow
def test_methods_move_axes_and_subscriptions_report(url):
    found = converse(
        url,
        """
index = await client.get_namespace_index("urn:axistwin:axes")
assert index == 2
machinery = await client.get_namespace_index("http://opcfoundation.org/UA/Machinery/")
machines = await client.nodes.objects.get_child(f"{machinery}:Machines")
found = {"machines": [(await node.read_browse_name()).Name for node in await machines.get_children()]}
changes, busy = Changes(), Changes()
for name, target in (("if1.X", 12.5), ("board.motor", 3.2), ("motor.shaft", 1234)):
    axis = client.get_node(f"ns=2;s={name}")
    position = await axis.get_child("2:Position")
    if name == "if1.X":
        unit = await position.get_child("0:EngineeringUnits")
        found["unit"] = (await unit.read_value()).DisplayName.Text
        reporting = await client.create_subscription(20, changes)
        await reporting.subscribe_data_change(position)
        watching = await client.create_subscription(20, busy)
        await watching.subscribe_data_change(await axis.get_child("2:Busy"))
    await axis.call_method("2:MoveTo", ua.Variant(float(target), ua.VariantType.Double))
    await at_rest(axis)
    found[name] = await position.read_value()
while changes.values[-1:] != [12.5] or busy.values[-1:] != [False]:
    await asyncio.sleep(0.02)
found["reported"] = changes.values == sorted(changes.values) and changes.values[0] < 1 and True in busy.values
axis = client.get_node("ns=2;s=if1.X")
await axis.call_method("2:MoveBy", ua.Variant(-0.5, ua.VariantType.Double))
await at_rest(axis)
await axis.call_method("2:SetPosition", ua.Variant(0.0, ua.VariantType.Double))
found["set"] = await (await axis.get_child("2:Position")).read_value()
return found
""",
    )
    assert found == {
        "machines": ["if1", "board", "motor"], "unit": "mm", "if1.X": 12.5, "board.motor": 3.2, "motor.shaft": 1234,
        "reported": True, "set": 0,
    }  # fmt: skip


@pytest.mark.slow
def test_what_the_controller_refuses_has_a_status_code(url):
    found = converse(
        url,
        """
found = []
x, motor = client.get_node("ns=2;s=if1.X"), client.get_node("ns=2;s=board.motor")
double = lambda value: ua.Variant(value, ua.VariantType.Double)
found.append(await code(x.call_method("2:Home", double(1.0))))
found.append(await (await x.get_child("2:LastError")).read_value())
found.append(await code(x.call_method("2:Home", double(0.5))))
found.append(await code(motor.call_method("2:MoveTo", double(1e12))))
found.append(await code((await motor.get_child("2:Speed")).write_value(1e9)))
found.append(await code((await motor.get_child("2:Position")).write_value(1.0)))
await (await motor.get_child("2:Speed")).write_value(5.0)
await motor.call_method("2:MoveAt", double(-5.0))
velocity = await motor.get_child("2:Velocity")
while await velocity.read_value() != -5.0:
    await asyncio.sleep(0.02)
await motor.call_method("2:Stop")
await at_rest(motor)
await x.call_method("2:ClearFaults")
pin, register = client.get_node("ns=2;s=motor.Pins.A"), client.get_node("ns=2;s=motor.Registers.a")
await pin.write_value(False)
await register.write_value(42, ua.VariantType.Int64)
found += [await pin.read_value(), await register.read_value()]
found.append(await code(client.get_node("ns=2;s=if1.Pins.input1").write_value(True)))
return found
""",
    )
    assert found == [
        "BadInvalidState", "no home switch is configured: expected the option home_input, e.g. home_input=1",
        "BadOutOfRange", "BadOutOfRange", "BadOutOfRange", "BadUserAccessDenied", False, 42, "BadUserAccessDenied",
    ]  # fmt: skip


SIGN = """
    from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256
    client.application_uri = "urn:test:client"
    await client.set_security(SecurityPolicyBasic256Sha256, "FOLDER/NAME.der", "FOLDER/NAME.pem",
                              server_certificate="FOLDER/keys/certificate.der")
"""


def make_certificate(folder, name):
    from asyncua.crypto.cert_gen import setup_self_signed_certificate
    from cryptography.x509.oid import ExtendedKeyUsageOID

    usage, key, certificate = ExtendedKeyUsageOID.CLIENT_AUTH, folder / f"{name}.pem", folder / f"{name}.der"
    asyncio.run(
        setup_self_signed_certificate(key, certificate, "urn:test:client", "localhost", [usage], {"commonName": name})
    )


def signing(folder, name):
    return SIGN.strip().replace("FOLDER", str(folder)).replace("NAME", name)


@pytest.mark.slow
def test_users_and_certificates(scene_file, tmp_path):
    users, folder = tmp_path / "users.txt", tmp_path / "keys"
    users.write_text("# the laboratory\nanna k7Rw2p operator\nbert x9Qv4t viewer\n")
    words = ["--port", str(free_port()), "--users", str(users), "--certificates", str(folder), "--speed", "20"]
    body = """
axis = client.get_node("ns=2;s=board.motor")
moved = await code(axis.call_method("2:MoveTo", ua.Variant(1.0, ua.VariantType.Double)))
return [moved, (await (await axis.get_child("2:Busy")).read_value()) in (True, False)]
"""
    make_certificate(tmp_path, "client")
    with running("opcua", str(scene_file), *words, *SLOW_COMPUTER) as made:
        assert (folder / "key.pem").stat().st_mode & 0o777 == 0o600

        def as_user(name, password):
            signed_in = f"client.set_user({name!r}); client.set_password({password!r})"
            return converse(made["url"], body, f"{signing(tmp_path, 'client')}\n    {signed_in}")

        assert as_user("anna", "k7Rw2p") == [None, True] and as_user("bert", "x9Qv4t") == ["BadUserAccessDenied", True]
        with pytest.raises(AssertionError, match=r"BadUserAccessDenied|BadIdentityTokenRejected"):
            as_user("anna", "wrong")
        with pytest.raises(AssertionError):
            converse(made["url"], body)


@pytest.mark.slow
def test_only_clients_with_a_trusted_certificate_connect(scene_file, tmp_path):
    for name in ("friend", "stranger"):
        make_certificate(tmp_path, name)
    trusted = tmp_path / "keys" / "trusted"
    trusted.mkdir(parents=True)
    shutil.copy(tmp_path / "friend.der", trusted)
    words = ["--port", str(free_port()), "--certificates", str(trusted.parent), "--speed", "20"]
    body = 'return await client.get_node("ns=2;s=if1.Axes.X.Busy").read_value()'
    with running("opcua", str(scene_file), *words, *SLOW_COMPUTER) as made:
        assert converse(made["url"], body, signing(tmp_path, "friend")) is False
        with pytest.raises(AssertionError, match="BadCertificateUntrusted"):
            converse(made["url"], body, signing(tmp_path, "stranger"))


def test_errors_of_the_command_line(tmp_path, capsys):
    from axistwin.cli.program import main

    users = tmp_path / "users.txt"
    users.write_text("anna operator\n")
    at = ["COM3", "--model", "if1"]
    for words, message in (
        (
            [*at, "--listen", "0.0.0.0"],
            "--listen 0.0.0.0 permits access from the network: add --users FILE and --certificates DIR",
        ),
        ([*at, "--users", str(users)], "users.txt:1: invalid user: expected NAME PASSWORD operator|viewer"),
        ([*at, "--users", str(tmp_path / "none")], "cannot read the names and passwords of users from"),
        (["COM3"], "the model of the controller at the port is missing"),
    ):
        with pytest.raises(SystemExit) as ended:
            main(["opcua", *words])
        assert ended.value.code == 2 and message in capsys.readouterr().err
