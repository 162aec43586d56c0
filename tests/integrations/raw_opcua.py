"""An OPC UA client that does step by step what it likes: it reads no list of endpoints and checks nothing."""

from contextlib import asynccontextmanager

from asyncua import ua
from asyncua.client.ua_client import UaClient
from asyncua.common.utils import create_nonce
from asyncua.crypto import uacrypto
from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256
from asyncua.ua.ua_binary import struct_from_binary


async def signing(folder, name):
    server = await uacrypto.load_certificate(folder / "keys" / "certificate.der")
    own = await uacrypto.load_certificate(folder / f"{name}.der")
    key = await uacrypto.load_private_key(folder / f"{name}.pem")
    return SecurityPolicyBasic256Sha256(server, own, key, ua.MessageSecurityMode.SignAndEncrypt)


async def code(answer):
    """Return the name of the status code with which the server refuses; "Good" if it does not."""
    try:
        await answer
    except ua.UaStatusCodeError as error:
        return ua.StatusCode(error.code).name
    return "Good"


class Raw:
    def __init__(self, client, url):
        self.client, self.url, self.nonce = client, url, b""

    async def open_channel(self):
        given = ua.OpenSecureChannelParameters()
        given.RequestType = ua.SecurityTokenRequestType.Issue
        given.SecurityMode = self.client.security_policy.Mode
        given.RequestedLifetime = 600_000
        given.ClientNonce = create_nonce(self.client.security_policy.secure_channel_nonce_length)
        await self.client.open_secure_channel(given)

    async def endpoints(self):
        given = ua.GetEndpointsParameters()
        given.EndpointUrl = self.url
        return await self.client.get_endpoints(given)

    async def create_session(self, certificate=None):
        given = ua.CreateSessionParameters()
        given.ClientNonce, given.EndpointUrl, given.RequestedSessionTimeout = create_nonce(32), self.url, 5000
        given.ClientDescription.ApplicationUri = "urn:test:client"
        given.ClientDescription.ApplicationType = ua.ApplicationType.Client
        given.ClientCertificate = certificate
        made = await self.client.create_session(given)
        self.nonce = made.ServerNonce
        return made

    async def activate_session(self, name=None, password=""):
        given = ua.ActivateSessionParameters()
        given.UserIdentityToken = ua.AnonymousIdentityToken(PolicyId="anonymous")
        if name is not None:
            given.UserIdentityToken = ua.UserNameIdentityToken(
                PolicyId="username", UserName=name, Password=password.encode()
            )
        policy = self.client.security_policy
        if policy.peer_certificate is not None:
            given.ClientSignature.Algorithm = policy.AsymmetricSignatureURI
            given.ClientSignature.Signature = policy.asymmetric_cryptography.signature(
                policy.peer_certificate + self.nonce
            )
        return await self.client.activate_session(given)

    async def log_in(self, name=None, password=""):
        await self.create_session(self.client.security_policy.host_certificate)
        await self.activate_session(name, password)

    async def read(self, node):
        given = ua.ReadParameters()
        given.NodesToRead = [ua.ReadValueId(ua.NodeId(node, 2), ua.AttributeIds.Value)]
        return (await self.client.read(given))[0]

    async def move(self, target):
        """Move the axis board.motor; return the name of the status code."""
        given = ua.CallMethodRequest()
        given.ObjectId, given.MethodId = ua.NodeId("board.motor", 2), ua.NodeId("board.Axes.motor.MoveTo", 2)
        given.InputArguments = [ua.Variant(target, ua.VariantType.Double)]
        request = ua.CallRequest()
        request.Parameters.MethodsToCall = [given]
        return await self.send(request, ua.CallResponse)

    async def register_a_server(self):
        request = ua.RegisterServerRequest()
        request.Server.ServerUri, request.Server.ServerNames = "urn:test:other", [ua.LocalizedText("other")]
        return await self.send(request, ua.RegisterServerResponse)

    async def add_a_node(self):
        request = ua.AddNodesRequest()
        request.Parameters.NodesToAdd = []
        return await self.send(request, ua.AddNodesResponse)

    async def subscribe(self, node, every_ms=10):
        """Make a subscription to a node; return its number and that of its monitored item."""
        request = ua.CreateSubscriptionRequest()
        request.Parameters.RequestedPublishingInterval = every_ms
        request.Parameters.RequestedLifetimeCount, request.Parameters.RequestedMaxKeepAliveCount = 10_000, 3000
        request.Parameters.PublishingEnabled = True
        number = (await self.ask(request, ua.CreateSubscriptionResponse)).Parameters.SubscriptionId
        item = ua.CreateMonitoredItemsRequest()
        item.Parameters.SubscriptionId, item.Parameters.ItemsToCreate = number, [self.item(node)]
        return number, (await self.ask(item, ua.CreateMonitoredItemsResponse)).Results[0].MonitoredItemId

    @staticmethod
    def item(node):
        wanted = ua.MonitoringParameters(ClientHandle=1, SamplingInterval=0, QueueSize=10)
        read = ua.ReadValueId(ua.NodeId(node, 2), ua.AttributeIds.Value)
        return ua.MonitoredItemCreateRequest(read, ua.MonitoringMode.Reporting, wanted)

    async def publish(self, *acknowledged):
        """Return what a subscription reports; `acknowledged` are numbers of subscriptions and of their messages."""
        request = ua.PublishRequest()
        request.Parameters.SubscriptionAcknowledgements = [
            ua.SubscriptionAcknowledgement(*each) for each in acknowledged
        ]
        return (await self.ask(request, ua.PublishResponse)).Parameters

    async def republish(self, number, message):
        request = ua.RepublishRequest()
        request.Parameters.SubscriptionId, request.Parameters.RetransmitSequenceNumber = number, message
        return (await self.ask(request, ua.RepublishResponse)).NotificationMessage

    async def ask(self, request, response):
        return struct_from_binary(response, await self.client.protocol.send_request(request))

    async def send(self, request, response):
        """Send a request; return the name of the status code of the answer."""

        async def exchange():
            answer = await self.ask(request, response)
            found = answer if hasattr(answer, "Results") else getattr(answer, "Parameters", None)
            for result in getattr(found, "Results", None) or []:
                getattr(result, "StatusCode", result).check()

        return await code(exchange())


@asynccontextmanager
async def raw(url, policy=None, *, channel=True):
    """Connect; with `channel` also open a secure channel: without a policy, the channel has no security."""
    client = UaClient(timeout=300)
    if policy is not None:
        client.set_security(policy)
    host, port = url.removeprefix("opc.tcp://").partition("/")[0].split(":")
    await client.connect_socket(host, int(port))
    try:
        await client.send_hello(url)
        made = Raw(client, url)
        if channel:
            await made.open_channel()
        yield made
    finally:
        client.disconnect_socket()
