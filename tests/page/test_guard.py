"""Only this page, on this machine, with the key of its address: everything else is
turned away, sockets too."""

import asyncio

import pytest
from benchtwin.page.guard import Guard

PORT, TOKEN = 8123, "a-long-random-token"
HOST = (b"host", b"127.0.0.1:8123")
COOKIE = (b"cookie", f"benchtwin_{PORT}={TOKEN}".encode())


def ask(
    kind="http", headers: tuple = (HOST, COOKIE), query=b"", method="GET", path="/x"
) -> tuple[bool, dict]:
    """Whether the application behind the guard was reached, and the first message that
    came back."""
    reached, sent = [], []

    async def inner(scope, receive, send):
        reached.append(scope)
        if scope["type"] == "http":
            await send({"type": "http.response.start", "status": 200, "headers": []})

    async def receive():
        return {"type": "websocket.connect"}

    async def send(message):
        sent.append(message)

    scope = {
        "type": kind,
        "method": method,
        "path": path,
        "headers": list(headers),
        "query_string": query,
    }
    asyncio.run(Guard(inner, PORT, TOKEN)(scope, receive, send))
    return bool(reached), sent[0] if sent else {}


@pytest.mark.parametrize("kind", ["http", "websocket"])
def test_the_page_itself_is_let_in(kind):
    assert ask(kind)[0]
    assert ask(kind, (HOST, COOKIE, (b"origin", b"http://127.0.0.1:8123")))[0]
    assert ask(kind, ((b"host", b"localhost:8123"), COOKIE))[0]


@pytest.mark.parametrize("kind", ["http", "websocket"])
@pytest.mark.parametrize(
    "headers",
    [
        (COOKIE,),
        ((b"host", b"evil.example:8123"), COOKIE),
        ((b"host", b"127.0.0.1:8123.evil.example"), COOKIE),
        ((b"host", b"127.0.0.1:9999"), COOKIE),
        (HOST, COOKIE, (b"origin", b"http://evil.example")),
        (HOST, COOKIE, (b"origin", b"null")),
        (HOST, COOKIE, (b"origin", b"http://127.0.0.1:9999")),
        (HOST,),
        (HOST, (b"cookie", b"benchtwin_8123=guess")),
        (HOST, (b"cookie", b"benchtwin_9999=" + TOKEN.encode())),
        (HOST, (b"cookie", b"\xff\xfe=;;==")),
    ],
)
def test_all_else_is_turned_away(kind, headers):
    reached, answer = ask(kind, headers)
    assert not reached
    assert answer.get("status") == 403 or answer["type"] == "websocket.close"


def test_the_address_with_the_token_sets_the_cookie_and_hides_the_token():
    reached, answer = ask(
        "http", (HOST,), f"tab=Run&token={TOKEN}".encode(), path="//evil.example"
    )
    headers = dict(answer["headers"])
    assert not reached and answer["status"] == 303
    assert headers[b"location"] == b"/evil.example?tab=Run"  # never another host
    assert all(
        word in headers[b"set-cookie"]
        for word in (TOKEN.encode(), b"HttpOnly", b"SameSite=Strict")
    )


@pytest.mark.parametrize(("kind", "method"), [("http", "POST"), ("websocket", "GET")])
def test_the_token_in_an_address_opens_nothing_else(kind, method):
    assert not ask(kind, (HOST,), f"token={TOKEN}".encode(), method)[0]


def test_every_answer_forbids_being_framed_or_sniffed():
    headers = dict(ask()[1]["headers"])
    assert (
        headers[b"x-frame-options"] == b"SAMEORIGIN"
        and headers[b"x-content-type-options"] == b"nosniff"
    )
