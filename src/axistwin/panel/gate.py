"""Access control: requests of the panel's own page only, and with the token only from other computers.

On loopback, the request must be for a loopback name, so that no web page whose name resolves to loopback has access.
A browser sends the token once, in the address; then a cookie identifies the browser, and scripts cannot read it.
"""

import secrets
from http.cookies import CookieError, SimpleCookie
from ipaddress import ip_address
from urllib.parse import parse_qsl, urlencode

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

PERSON = "axistwin-person"
"""Cookie that identifies a browser after a reload."""
HEADERS = {
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Content-Security-Policy": "frame-ancestors 'none'",
}
"""No other page may frame this page or receive its address."""
LASTS_S = 30 * 24 * 3600


def is_loopback(host: str) -> bool:
    """Return True if a name or number, as in a URL, is a loopback address."""
    if host == "localhost" or host.endswith(".localhost"):
        return True
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return False


class Gate:
    """Access control of an ASGI application.  `token`: required from browsers; None: all local requests pass."""

    def __init__(self, app: ASGIApp, token: str | None) -> None:
        self.app = app
        self._token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request to the application, or refuse the request."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        headers, cookies = Headers(scope=scope), _cookies(scope)
        if reason := self._foreign(headers) or self._unknown(scope, cookies):
            await _refuse(reason, scope, receive, send)
        elif given := self._shown(scope):
            await self._welcome(given, scope, receive, send)
        else:
            await self._pass(cookies.get(PERSON), scope, receive, send)

    async def _pass(self, person: str | None, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request with the user's key; a new user receives a key."""
        scope["person"] = person or secrets.token_urlsafe(12)

        async def answer(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                headers.update(HEADERS)
                if person is None:
                    headers.append("set-cookie", _set_cookie(PERSON, scope["person"]))
            await send(message)

        await self.app(scope, receive, answer)

    def _foreign(self, headers: Headers) -> str:
        """Return the reason why a request is from another page; "" if the request is from this page."""
        host, origin = headers.get("host", ""), headers.get("origin")
        if self._token is None and not is_loopback(_name(host)):
            return f"this panel accepts requests from this machine only, not for {host!r}"
        if origin is not None and origin.partition("://")[2] != host:
            return f"no requests from {origin}"
        elsewhere = headers.get("sec-fetch-site") in ("cross-site", "same-site")
        if elsewhere and headers.get("sec-fetch-mode") != "navigate":
            return "no requests from other pages"
        return ""

    # With a token

    def _unknown(self, scope: Scope, cookies: dict[str, str]) -> str:
        if self._token is None:
            return ""
        known = (cookies.get(_cookie(scope)), self._shown(scope))
        if any(given is not None and secrets.compare_digest(given.encode(), self._token.encode()) for given in known):
            return ""
        return "the panel requires a token: open the address that axistwin serve has printed"

    def _shown(self, scope: Scope) -> str | None:
        """Return the token in the address."""
        if self._token is None or scope["type"] != "http":
            return None
        return dict(parse_qsl(scope["query_string"].decode("latin-1"))).get("token")

    async def _welcome(self, token: str, scope: Scope, receive: Receive, send: Send) -> None:
        """Store the token in a cookie, and redirect to the address without the token."""
        others = [(key, value) for key, value in parse_qsl(scope["query_string"].decode("latin-1")) if key != "token"]
        address = scope["path"] + (f"?{urlencode(others)}" if others else "")
        response = RedirectResponse(address, 303, HEADERS | {"Set-Cookie": _set_cookie(_cookie(scope), token)})
        await response(scope, receive, send)


def _name(host: str) -> str:
    """Return a host without its port: `localhost:8080`, `[::1]:8080`."""
    return host[1:].partition("]")[0] if host.startswith("[") else host.partition(":")[0]


def _cookie(scope: Scope) -> str:
    """Return the cookie's name with the port, because all ports of a machine share cookies."""
    server = scope.get("server") or ("", 0)
    return f"axistwin-token-{server[1]}"


def _set_cookie(name: str, value: str) -> str:
    return f"{name}={value}; Max-Age={LASTS_S}; Path=/; HttpOnly; SameSite=Lax"


def _cookies(scope: Scope) -> dict[str, str]:
    jar = SimpleCookie()
    try:
        jar.load(Headers(scope=scope).get("cookie", ""))
    except CookieError:
        return {}
    return {name: morsel.value for name, morsel in jar.items()}


async def _refuse(reason: str, scope: Scope, receive: Receive, send: Send) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008, "reason": reason[:120]})
        return
    response = PlainTextResponse(f"axistwin: {reason}\n", 403, HEADERS)
    await response(scope, receive, send)
