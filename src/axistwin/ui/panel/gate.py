"""Access control of the panel's web server.

Requests from other web sites are refused.  Without a token, the requested host name must be a loopback name, so that a
web site whose name resolves to a loopback address has no access.  With a token, a browser sends the token once, in the
URL; the answer is a cookie with the token, which scripts cannot read.
"""

import secrets
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qsl, urlencode

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from axistwin.links.web_gate import is_loopback, refusal

PERSON = "axistwin-person"  # Name of the cookie that identifies a user.
HEADERS = {
    "X-Frame-Options": "DENY", "X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer",
    "Content-Security-Policy": "frame-ancestors 'none'",
}  # fmt: skip
"""Headers of every answer; with them, other web sites cannot embed the page or receive its URL as a referrer."""
COOKIE_MAX_AGE_S = 30 * 24 * 3600


class Gate:
    """ASGI middleware that refuses requests without access.  `token`: required from browsers; None: not required."""

    def __init__(self, app: ASGIApp, token: str | None) -> None:
        self.app = app
        self._token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
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
        known = is_loopback if self._token is None else lambda name: True
        return refusal(headers.get, known, "a loopback name, e.g. localhost")

    # Functions that check the access token of an HTTP request

    def _unknown(self, scope: Scope, cookies: dict[str, str]) -> str:
        if self._token is None:
            return ""
        known = (cookies.get(_cookie(scope)), self._shown(scope))
        if any(given is not None and secrets.compare_digest(given.encode(), self._token.encode()) for given in known):
            return ""
        return "the panel requires a token: open the address that axistwin serve has printed"

    def _shown(self, scope: Scope) -> str | None:
        if self._token is None or scope["type"] != "http":
            return None
        return dict(parse_qsl(scope["query_string"].decode("latin-1"))).get("token")

    async def _welcome(self, token: str, scope: Scope, receive: Receive, send: Send) -> None:
        others = [(key, value) for key, value in parse_qsl(scope["query_string"].decode("latin-1")) if key != "token"]
        address = scope["path"] + (f"?{urlencode(others)}" if others else "")
        response = RedirectResponse(address, 303, HEADERS | {"Set-Cookie": _set_cookie(_cookie(scope), token)})
        await response(scope, receive, send)


def _cookie(scope: Scope) -> str:
    """Return the name of the token's cookie: with the port, because all ports of a host share cookies."""
    server = scope.get("server") or ("", 0)
    return f"axistwin-token-{server[1]}"


def _set_cookie(name: str, value: str) -> str:
    return f"{name}={value}; Max-Age={COOKIE_MAX_AGE_S}; Path=/; HttpOnly; SameSite=Lax"


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
