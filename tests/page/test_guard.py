"""Only this page, on this machine, with the key of its address: everything else is
turned away, sockets too."""

import asyncio
import html
import re
import subprocess
import sys
import time
import urllib.error
import urllib.parse
import urllib.request
from pathlib import Path

import psutil
import pytest
from starlette.requests import ClientDisconnect

from benchtwin.page import command
from benchtwin.page.guard import LEFT, Entrance, Guard

PORT = 8123
ENTRANCE = Entrance()
HOST = (b"host", b"127.0.0.1:8123")
COOKIE = (b"cookie", f"benchtwin_{PORT}={ENTRANCE.cookie}".encode())


def ask(
    kind="http", headers: tuple = (HOST, COOKIE), query="", method="GET", path="/x"
) -> tuple[bool, dict, str]:
    """Whether the application behind the guard was reached, the first message that came
    back, and the text of the second."""
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
        "query_string": query.encode(),
    }
    asyncio.run(Guard(inner, PORT, ENTRANCE)(scope, receive, send))
    text = sent[1].get("body", b"").decode() if len(sent) > 1 else ""
    return bool(reached), sent[0] if sent else {}, text


@pytest.mark.parametrize("kind", ["http", "websocket"])
def test_the_page_itself_is_let_in(kind):
    assert ask(kind)[0]
    assert ask(kind, (HOST, COOKIE, (b"origin", b"http://127.0.0.1:8123")))[0]
    assert ask(kind, ((b"host", b"localhost:8123"), COOKIE))[0]
    named = f"{ENTRANCE.host}:8123".encode()
    assert ask(kind, ((b"host", named), COOKIE, (b"origin", b"http://" + named)))[0]
    for own in (b"same-origin", b"none"):
        assert ask(kind, (HOST, COOKIE, (b"sec-fetch-site", own)))[0]


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
        (HOST, COOKIE, (b"origin", b"http://localhost:8123")),
        (HOST, COOKIE, (b"sec-fetch-site", b"same-site")),
        ((b"host", b"guess.localhost:8123"), COOKIE),
        (HOST,),
        (HOST, (b"cookie", b"benchtwin_8123=guess")),
        (HOST, (b"cookie", b"benchtwin_9999=" + ENTRANCE.cookie.encode())),
        (HOST, (b"cookie", b"\xff\xfe=;;==")),
    ],
)
def test_all_else_is_turned_away(kind, headers):
    reached, answer, _ = ask(kind, headers)
    assert not reached
    assert answer.get("status") == 403 or answer["type"] == "websocket.close"


@pytest.mark.parametrize("path", ["//evil.example", "/\\evil.example", "/evil.example"])
def test_the_key_in_an_address_is_exchanged_for_the_cookie_and_is_not_it(path):
    key = ENTRANCE.new_key()
    reached, answer, page = ask("http", (HOST,), f"tab=Run&token={key}", path=path)
    headers = dict(answer["headers"])
    assert not reached and answer["status"] == 200 and key not in page
    where = html.unescape(re.search('content="0;url=(.*?)"', page)[1])
    assert where.removeprefix("/%5C") in (
        "/evil.example?tab=Run",
        "evil.example?tab=Run",
    )
    assert all(
        word in headers[b"set-cookie"]
        for word in (ENTRANCE.cookie.encode(), b"HttpOnly", b"SameSite=strict")
    )
    assert key.encode() not in headers[b"set-cookie"]
    assert b"domain" not in headers[b"set-cookie"].lower()  # of this name alone


def test_the_name_of_a_server_cannot_be_guessed():
    names = {Entrance().host for _ in range(100)}
    assert len(names) == 100 and all(
        re.fullmatch(r"[0-9a-f]{32}\.localhost", n) for n in names
    )


def test_a_key_lets_in_once_and_says_so():
    told = []
    key = ENTRANCE.new_key(lambda: told.append("used"))
    other = ENTRANCE.new_key()
    assert not told
    assert ask("http", (HOST,), f"token={key}")[1]["status"] == 200 and told == ["used"]
    assert ask("http", (HOST,), f"token={key}")[1]["status"] == 403
    ENTRANCE.void(other)
    assert ask("http", (HOST,), f"token={other}")[1]["status"] == 403
    assert ask("http", (HOST,), f"token={ENTRANCE.cookie}")[1]["status"] == 403
    assert ask("http", (HOST,), "token=")[1]["status"] == 403


@pytest.mark.parametrize(("kind", "method"), [("http", "POST"), ("websocket", "GET")])
def test_the_key_in_an_address_opens_nothing_else(kind, method):
    key = ENTRANCE.new_key()
    assert not ask(kind, (HOST,), f"token={key}", method)[0]
    assert (
        ask("http", (HOST,), f"token={key}")[1]["status"] == 200
    )  # and is not used up


@pytest.mark.parametrize(
    "header", [(b"host", b"evil.example:8123"), (b"origin", b"http://evil.example")]
)
def test_another_site_cannot_use_up_a_key(header):
    key = ENTRANCE.new_key()
    headers = (header,) if header[0] == b"host" else (HOST, header)
    assert ask("http", headers, f"token={key}")[1]["status"] == 403
    assert ask("http", (HOST,), f"token={key}")[1]["status"] == 200


@pytest.mark.parametrize("why", [ClientDisconnect(), RuntimeError(LEFT)])
def test_a_browser_that_leaves_in_the_middle_is_no_error(why):
    async def inner(scope, receive, send):
        raise why

    scope = {"type": "http", "method": "GET", "path": "/x", "query_string": b""}
    guard = Guard(inner, PORT, ENTRANCE)
    asyncio.run(guard({**scope, "headers": [HOST, COOKIE]}, None, None))
    why.args = ("another",)
    if isinstance(why, RuntimeError):
        with pytest.raises(RuntimeError, match="another"):
            asyncio.run(guard({**scope, "headers": [HOST, COOKIE]}, None, None))


def test_every_answer_forbids_being_framed_or_sniffed():
    headers = dict(ask()[1]["headers"])
    assert (
        headers[b"x-frame-options"] == b"SAMEORIGIN"
        and headers[b"x-content-type-options"] == b"nosniff"
    )


def test_the_browser_is_opened_by_a_file_that_only_the_user_can_read(
    tmp_path, monkeypatch
):
    opened, entrance = [], Entrance()
    monkeypatch.setattr(command.webbrowser, "open", opened.append)
    monkeypatch.setattr(command, "ANSWERS_AFTER_S", 0.0)
    command.open_browser(tmp_path, entrance, "http://127.0.0.1:8123/")
    until(lambda: opened)
    file = Path(urllib.parse.urlparse(opened[0]).path)
    assert file.parent.stat().st_mode & 0o777 == 0o700
    key = re.search(r"token=([\w-]+)", file.read_text())[1]
    assert key not in opened[0]  # which stands in the browser's command line
    assert entrance.admits(key) and not entrance.admits(key)
    assert not file.exists()


def test_a_browser_that_does_not_come_is_not_awaited_for_ever(tmp_path, monkeypatch):
    monkeypatch.setattr(command.webbrowser, "open", lambda _: True)
    monkeypatch.setattr(command, "OPENS_WITHIN_S", 0.2)
    entrance = Entrance()
    command.open_browser(tmp_path, entrance, "http://127.0.0.1:8123/")
    (file,) = tmp_path.glob("open-*.html")
    key = re.search(r"token=([\w-]+)", file.read_text())[1]
    until(lambda: not file.exists())
    assert not entrance.admits(key)


def until(condition, seconds: float = 60.0) -> None:
    end = time.time() + seconds
    while not condition():
        assert time.time() < end, "it took too long"
        time.sleep(0.02)


def test_the_terminal_prints_another_address_for_every_one_that_was_used(tmp_path):
    server = subprocess.Popen(
        [sys.executable, "-m", "benchtwin", "page", str(tmp_path), "--no-browser"],
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        addresses = []
        for _ in range(3):
            while not (found := re.search(r"http://\S+", server.stdout.readline())):
                pass
            # not every system knows such names; browsers do
            addresses.append(re.sub(r"\w+\.localhost", "127.0.0.1", found[0]))
            until(lambda: status(addresses[-1]) == 200, 30)
            assert status(addresses[-1]) == 403
        assert len(set(addresses)) == 3
        for process in psutil.process_iter(["cmdline"]):
            line = " ".join(process.info["cmdline"] or ())
            assert not any(a.partition("token=")[2] in line for a in addresses)
    finally:
        server.terminate()
        server.wait(10)


def status(address: str) -> int:
    try:
        return urllib.request.urlopen(address, timeout=5).status
    except urllib.error.HTTPError as error:
        return error.code
    except OSError:  # not up yet
        return 0
