"""Access control: only the person at this machine gets in; every request and socket is
checked here first.

The server listens on the loopback address only. That alone does not keep out other web
pages open in the same browser, so each request must also name this host (against DNS
rebinding), come from this page if it says where from (against requests of other sites)
and carry the cookie of this server. A browser gets it for the key in an address, which
is void from then on.

Cookies know no ports: that of 127.0.0.1 goes to every other server of this machine. So
the page is opened under a name of its own that nobody else can guess; browsers take
all names that end in .localhost for this machine."""

import hmac
import html
import os
import re
import secrets
from collections.abc import Callable
from urllib.parse import quote, urlencode

from starlette.requests import ClientDisconnect, HTTPConnection
from starlette.responses import HTMLResponse, PlainTextResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from benchtwin.bench.language import (
    ENGLISH,
    LANGUAGES,
    VARIABLE,
    speak,
    spoken,
    tr,
)

HEADERS = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "x-frame-options": "SAMEORIGIN",
    "cross-origin-resource-policy": "same-origin",
    "content-security-policy": "frame-src 'self'",  # a report stays in its frame
}
WRONG_ADDRESS = "This page answers only to its own address on this machine."
NO_KEY = (
    "Open the address that benchtwin page printed last: it holds the key to this page."
    " An address lets one browser in, once."
)
LEFT = "No response returned."  # Starlette's word for a browser that did not wait


class Entrance:
    """The keys of one server: its own name, the cookie that every browser holds that is
    in, and keys that let one browser in, once."""

    def __init__(self) -> None:
        self.cookie = secrets.token_urlsafe(24)
        self.host = f"{secrets.token_hex(16)}.localhost"
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
    """ASGI middleware round the whole application, its socket included. Sentences are
    said in the language of the browser that asked last, unless one was asked for when
    the page was started."""

    def __init__(self, app: ASGIApp, port: int, entrance: Entrance):
        self.app, self.entrance = app, entrance
        names = ("127.0.0.1", "localhost", entrance.host)
        self.hosts = {f"{name}:{port}" for name in names}
        self.cookie = f"benchtwin_{port}"  # cookies know no ports
        self.follows = VARIABLE not in os.environ

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            return await self.app(scope, receive, send)
        asked = HTTPConnection(scope)
        if self.follows and (languages := asked.headers.get("accept-language")):
            speak(first_known(languages))
        origin, host = asked.headers.get("origin"), asked.headers.get("host")
        foreign = origin is not None and origin != f"http://{host}"
        beside = asked.headers.get("sec-fetch-site") == "same-site"  # of another port
        if host not in self.hosts or foreign or beside:
            return await _refuse(tr(WRONG_ADDRESS), scope, receive, send)
        held = asked.cookies.get(self.cookie, "")
        if hmac.compare_digest(held.encode(), self.entrance.cookie.encode()):
            return await self._answered(scope, receive, send)
        opens = scope["type"] == "http" and scope["method"] == "GET"
        if opens and self.entrance.admits(asked.query_params.get("token", "")):
            return await self._let_in(asked)(scope, receive, send)
        await _refuse(tr(NO_KEY), scope, receive, send)

    async def _answered(self, scope: Scope, receive: Receive, send: Send) -> None:
        """The page's answer with our headers; none for a browser that has left."""

        async def sender(message: Message) -> None:
            if message["type"] == "http.response.start":
                ours = [(k.encode(), v.encode()) for k, v in HEADERS.items()]
                message = {**message, "headers": [*message.get("headers", []), *ours]}
            await send(message)

        try:
            await self.app(scope, receive, sender)
        except ClientDisconnect:
            pass
        except RuntimeError as error:
            if str(error) != LEFT:
                raise

    def _let_in(self, asked: HTTPConnection) -> Response:
        """Hand out the cookie, and go on to the address without the key. The page does
        that, not a redirect: a strict cookie is not sent along with a redirect of an
        address that was opened from elsewhere, as from a file."""
        rest = [(k, v) for k, v in asked.query_params.multi_items() if k != "token"]
        where = "/" + quote(asked.scope["path"].lstrip("/"))
        headers = {**HEADERS, "cache-control": "no-store"}
        page = forwarding(f"{where}?{urlencode(rest)}" if rest else where)
        answer = HTMLResponse(page, headers=headers)
        cookie = self.entrance.cookie
        answer.set_cookie(self.cookie, cookie, httponly=True, samesite="strict")
        return answer


def first_known(languages: str) -> str:
    """The first language of a header Accept-Language that sentences can be said in;
    English where there is none."""
    tags = re.findall(r"(?:^|,)\s*([a-z]+)", languages)  # "zh-CN,zh;q=0.9,en;q=0.8"
    return next((tag for tag in tags if tag in LANGUAGES), ENGLISH)


def forwarding(address: str) -> str:
    """A page that opens another address at once."""
    return (
        f'<!doctype html><html lang="{spoken()}"><title>benchtwin</title><meta'
        f' http-equiv="refresh" content="0;url={html.escape(address)}">'
    )


async def _refuse(words: str, scope: Scope, receive: Receive, send: Send) -> None:
    if scope["type"] == "websocket":
        await receive()
        return await send({"type": "websocket.close", "code": 4403})
    await PlainTextResponse(words, 403, HEADERS)(scope, receive, send)
