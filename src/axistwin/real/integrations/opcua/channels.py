"""What a client may do on a secure channel, and before there is one.

The library asyncua leaves several ways around its own security.  Every server accepts requests on a channel without
security, and even before a channel is opened; no permission rule covers them.  A client may name another certificate
than that of its channel.  The token of a session is a small number.  Every client may register other servers, use the
subscriptions of others by their numbers, and guess passwords as fast as it can.
"""

import logging
import secrets
from collections.abc import Iterator, MutableMapping
from typing import Any

from asyncua import Server, ua
from asyncua.common.utils import ServiceError
from asyncua.server.binary_server_asyncio import BinaryServer, OPCUAProtocol
from asyncua.server.internal_server import InternalServer
from asyncua.server.internal_session import InternalSession, SessionState
from asyncua.server.internal_subscription import InternalSubscription
from asyncua.server.subscription_service import SubscriptionService
from asyncua.server.uaprocessor import UaProcessor
from asyncua.ua.ua_binary import struct_from_binary

from axistwin.real.integrations.opcua.security import Guesses, Users

MOST_CLIENTS = 100
MOST_SUBSCRIPTIONS = 10  # Largest number of subscriptions of a session; the library permits 1,000 in all.
LONGEST_ABSENCE_MS = 60_000  # A session with subscriptions outlives its connection by at most this time.
CREATE = ua.NodeId(ua.ObjectIds.CreateSessionRequest_Encoding_DefaultBinary)
ACTIVATE = ua.NodeId(ua.ObjectIds.ActivateSessionRequest_Encoding_DefaultBinary)
DISCOVERY = (
    ua.NodeId(ua.ObjectIds.GetEndpointsRequest_Encoding_DefaultBinary),
    ua.NodeId(ua.ObjectIds.FindServersRequest_Encoding_DefaultBinary),
)
REGISTRATION = (
    ua.NodeId(ua.ObjectIds.RegisterServerRequest_Encoding_DefaultBinary),
    ua.NodeId(ua.ObjectIds.RegisterServer2Request_Encoding_DefaultBinary),
)
LOGGER = "asyncua.server.monitored_item_service"  # Beginning of the names of the library's loggers for subscriptions.


class _Subscriptions(SubscriptionService):
    """Subscriptions; the library makes a logger for each, and the module `logging` would keep it for ever."""

    async def create_subscription(self, *arguments: Any, **named: Any) -> ua.CreateSubscriptionResult:
        made = await super().create_subscription(*arguments, **named)
        logging.Logger.manager.loggerDict.pop(f"{LOGGER}.{made.SubscriptionId}", None)
        return made


class _OwnByNumber(MutableMapping[int, InternalSubscription]):
    """The subscriptions of one session among those of all."""

    def __init__(self, every: dict[int, InternalSubscription], session: ua.NodeId) -> None:
        self._every, self._session = every, session

    def __getitem__(self, number: int) -> InternalSubscription:
        found = self._every[number]
        if found.session_id != self._session:
            raise KeyError(number)
        return found

    def __setitem__(self, number: int, subscription: InternalSubscription) -> None:
        self._every[number] = subscription

    def __delitem__(self, number: int) -> None:
        del self._every[number]

    def __iter__(self) -> Iterator[int]:
        return (number for number, each in self._every.items() if each.session_id == self._session)

    def __len__(self) -> int:
        return sum(1 for _ in self)


class _OwnSubscriptions(SubscriptionService):
    """Subscriptions as a session sees them: those of other sessions do not exist for it."""

    def __init__(self, every: SubscriptionService, session: ua.NodeId) -> None:
        super().__init__(every.aspace, every.iserver)
        self._every = every
        self.subscriptions = _OwnByNumber(every.subscriptions, session)

    async def create_subscription(self, *arguments: Any, **named: Any) -> ua.CreateSubscriptionResult:
        if len(self.subscriptions) >= MOST_SUBSCRIPTIONS:
            raise ServiceError(ua.StatusCodes.BadTooManySubscriptions)
        return await self._every.create_subscription(*arguments, **named)

    def republish(self, params: ua.RepublishParameters) -> ua.NotificationMessage:
        if params.SubscriptionId not in self.subscriptions:
            raise ServiceError(ua.StatusCodes.BadSubscriptionIdInvalid)
        return super().republish(params)


class _Sessions(InternalServer):
    """The sessions of a server; their tokens cannot be guessed, and each has its own subscriptions."""

    def __init__(self, user_manager: Any) -> None:
        super().__init__(user_manager)
        self.subscription_service = _Subscriptions(self.aspace, iserver=self)
        self.guesses = Guesses(user_manager.names if isinstance(user_manager, Users) else ())
        self.allow_remote_admin, self.max_connections = False, MOST_CLIENTS
        self.max_session_timeout_ms = LONGEST_ABSENCE_MS

    def create_session(self, *arguments: Any, **named: Any) -> InternalSession:
        made = super().create_session(*arguments, **named)
        made.subscription_service = _OwnSubscriptions(self.subscription_service, made.session_id)
        return made

    def register_external_session(self, session: InternalSession) -> None:
        session.auth_token = ua.NodeId(secrets.token_bytes(32), 0)
        super().register_external_session(session)


class _Processor(UaProcessor):
    iserver: _Sessions
    session: InternalSession | None

    async def _process_message(self, typeid: ua.NodeId, requesthdr: Any, seqhdr: Any, body: Any) -> Any:
        self._check(typeid, body)
        if typeid != ACTIVATE:
            return await super()._process_message(typeid, requesthdr, seqhdr, body)
        before, user = self.session, _user(body)
        self.iserver.guesses.check(self.name[0], user)
        try:
            answered = await super()._process_message(typeid, requesthdr, seqhdr, body)
        except Exception as error:
            self.session = before  # The library gives a client the session before it checks the password.
            if getattr(error, "code", None) == ua.StatusCodes.BadUserAccessDenied:
                self.iserver.guesses.note_wrong(self.name[0], user)
            raise
        self.iserver.guesses.note_right(self.name[0], user)
        return answered

    def _check(self, typeid: ua.NodeId, body: Any) -> None:
        policy = self._connection.security_policy
        if typeid in REGISTRATION:
            raise ServiceError(ua.StatusCodes.BadServiceUnsupported)
        # A policy without permissions is the one that the library itself adds.
        if typeid not in DISCOVERY and (policy.permissions is None or not self._connection.is_open()):
            raise ServiceError(ua.StatusCodes.BadSecurityPolicyRejected)
        if typeid != CREATE:
            return
        if self.session is not None and self.session.state != SessionState.Closed:
            raise ServiceError(ua.StatusCodes.BadTooManySessions)
        certificate = struct_from_binary(ua.CreateSessionParameters, body.copy()).ClientCertificate or b""
        if not certificate.startswith(policy.peer_certificate or b""):
            raise ServiceError(ua.StatusCodes.BadCertificateInvalid)


def _user(body: Any) -> str | None:
    """Return the name in a request to activate a session; None without a name."""
    token = struct_from_binary(ua.ActivateSessionParameters, body.copy()).UserIdentityToken
    return getattr(token, "UserName", None)


class _Protocol(OPCUAProtocol):
    processor: UaProcessor | None

    def connection_made(self, transport: Any) -> None:
        super().connection_made(transport)
        if self.processor is not None:
            self.processor = _Processor(self.iserver, transport, self.limits)
            self.processor.set_policies(self.policies)


class _Listener(BinaryServer):
    def _make_protocol(self) -> OPCUAProtocol:
        return _Protocol(self.iserver, self._policies, self.clients, self.closing_tasks, self.limits)


class GuardedServer(Server):
    """An OPC UA server on which the permission rules stand for every request but discovery."""

    def __init__(self, user_manager: Any) -> None:
        super().__init__(_Sessions(user_manager))

    async def start(self) -> None:
        """Listen for clients.  Raises OSError if the address is taken."""
        await self._setup_server_nodes()
        await self.iserver.start()
        self.bserver = _Listener(self.iserver, *self._get_bind_socket_info(), self.limits)
        self.bserver.set_policies(self._policies)
        try:
            await self.bserver.start()
        except OSError:
            await self.iserver.stop()
            raise
