"""Access control: only the person at this machine gets in; every request and socket is
checked here first.

The server listens on the loopback address only. That alone does not keep out other web
pages open in the same browser, so each request must also name this host (against DNS
rebinding), come from this page if it says where from (against requests of other sites)
and carry the token that the address printed at the start holds; a cookie keeps it
afterwards."""

import hmac
import secrets
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, urlencode

HEADERS = (
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
    (b"x-frame-options", b"SAMEORIGIN"),
    (b"cross-origin-resource-policy", b"same-origin"),
)


def new_token() -> str:
    """A random token that no other page can guess."""
    return secrets.token_urlsafe(24)


class Guard:
    """ASGI middleware round the whole application, its socket included."""

    def __init__(self, app, port: int, token: str):
        self.app, self.token = app, token
        self.hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}
        self.origins = {f"http://{host}" for host in self.hosts}
        self.cookie = f"benchtwin_{port}"  # cookies know no ports

    async def __call__(self, scope, receive, send):
        if scope["type"] == "lifespan":
            return await self.app(scope, receive, send)
        headers = {name: value.decode("latin-1") for name, value in scope["headers"]}
        if (
            headers.get(b"host") not in self.hosts
            or headers.get(b"origin", next(iter(self.origins))) not in self.origins
        ):
            return await _refuse(
                scope,
                receive,
                send,
                "This page answers only to its own address on this machine.",
            )
        if self._same(self._from_cookie(headers.get(b"cookie", ""))):
            return await self.app(scope, receive, _with_headers(send))
        query = parse_qs(scope.get("query_string", b"").decode("latin-1"))
        if (
            scope["type"] == "http"
            and scope["method"] == "GET"
            and self._same(query.pop("token", [""])[0])
        ):
            return await self._let_in(scope, send, query)
        await _refuse(
            scope,
            receive,
            send,
            "Open the address that benchtwin page printed: it holds the key to this"
            " page.",
        )

    def _same(self, token: str) -> bool:
        return hmac.compare_digest(token.encode(), self.token.encode())

    def _from_cookie(self, header: str) -> str:
        try:
            found = SimpleCookie(header).get(self.cookie)
        except CookieError:
            return ""
        return found.value if found else ""

    async def _let_in(self, scope, send, query: dict) -> None:
        """Keep the token in a cookie and out of the address from now on."""
        rest = urlencode(query, doseq=True)
        cookie = f"{self.cookie}={self.token}; Path=/; HttpOnly; SameSite=Strict"
        where = (scope["path"] + (f"?{rest}" if rest else "")).lstrip("/")
        headers = [
            (b"location", b"/" + where.encode()),
            (b"set-cookie", cookie.encode()),
            *HEADERS,
        ]
        await send({"type": "http.response.start", "status": 303, "headers": headers})
        await send({"type": "http.response.body", "body": b""})


async def _refuse(scope, receive, send, words: str) -> None:
    if scope["type"] == "websocket":
        await receive()
        return await send({"type": "websocket.close", "code": 4403})
    headers = [(b"content-type", b"text/plain; charset=utf-8"), *HEADERS]
    await send({"type": "http.response.start", "status": 403, "headers": headers})
    await send({"type": "http.response.body", "body": words.encode()})


def _with_headers(send):
    async def sender(message):
        if message["type"] == "http.response.start":
            message = {**message, "headers": [*message.get("headers", []), *HEADERS]}
        await send(message)

    return sender
