"""Access control: only the person at this machine gets in; every request and socket is
checked here first.

The server listens on the loopback address only. That alone does not keep out other web
pages open in the same browser, so each request must also name this host (against DNS
rebinding), come from this page if it says where from (against requests of other sites)
and carry the cookie of this server. A browser gets it for the key in an address, which
is void from then on."""

import hmac
import html
import secrets
from collections.abc import Callable
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, quote, urlencode

HEADERS = (
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
    (b"x-frame-options", b"SAMEORIGIN"),
    (b"cross-origin-resource-policy", b"same-origin"),
    (b"content-security-policy", b"frame-src 'self'"),  # a report stays in its frame
)


class Entrance:
    """The keys of one server: the cookie that every browser holds that is in, and keys
    that let one browser in, once."""

    def __init__(self) -> None:
        self.cookie = secrets.token_urlsafe(24)
        self._keys: dict[str, Callable[[], None]] = {}

    def new_key(self, used: Callable[[], None] = lambda: None) -> str:
        """A key that nobody can guess; `used` is called when it has let somebody in."""
        key = secrets.token_urlsafe(24)
        self._keys[key] = used
        return key

    def void(self, key: str) -> None:
        """Have a key let nobody in any more."""
        self._keys.pop(key, None)

    def admits(self, key: str) -> bool:
        """Whether this key lets somebody in; the next time it does not."""
        used = self._keys.pop(key, None)
        if used:
            used()
        return used is not None


class Guard:
    """ASGI middleware round the whole application, its socket included."""

    def __init__(self, app, port: int, entrance: Entrance):
        self.app, self.entrance = app, entrance
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
        if self._is_in(headers.get(b"cookie", "")):
            return await self.app(scope, receive, _with_headers(send))
        query = parse_qs(scope.get("query_string", b"").decode("latin-1"))
        if (
            scope["type"] == "http"
            and scope["method"] == "GET"
            and self.entrance.admits(query.pop("token", [""])[0])
        ):
            return await self._let_in(scope, send, query)
        await _refuse(
            scope,
            receive,
            send,
            "Open the address that benchtwin page printed last: it holds the key to"
            " this page. An address lets one browser in, once.",
        )

    def _is_in(self, header: str) -> bool:
        try:
            found = SimpleCookie(header).get(self.cookie)
        except CookieError:
            return False
        held = found.value if found else ""
        return hmac.compare_digest(held.encode(), self.entrance.cookie.encode())

    async def _let_in(self, scope, send, query: dict) -> None:
        """Hand out the cookie, and go on to the address without the key. The page does
        that, not a redirect: a strict cookie is not sent along with a redirect of an
        address that was opened from elsewhere, as from a file."""
        rest = urlencode(query, doseq=True)
        where = "/" + quote(scope["path"].lstrip("/")) + (f"?{rest}" if rest else "")
        cookie = f"{self.cookie}={self.entrance.cookie}; Path=/; HttpOnly"
        headers = [
            (b"content-type", b"text/html; charset=utf-8"),
            (b"cache-control", b"no-store"),
            (b"set-cookie", f"{cookie}; SameSite=Strict".encode()),
            *HEADERS,
        ]
        await send({"type": "http.response.start", "status": 200, "headers": headers})
        await send({"type": "http.response.body", "body": forwarding(where).encode()})


def forwarding(address: str) -> str:
    """A page that opens another address at once."""
    return (
        '<!doctype html><html lang="en"><title>benchtwin</title><meta'
        f' http-equiv="refresh" content="0;url={html.escape(address)}">'
    )


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
