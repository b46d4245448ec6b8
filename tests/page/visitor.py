"""A browser without scripts."""

import http.cookiejar
import urllib.error
import urllib.request


class Visitor:
    """Somebody who has opened the page's address and holds its cookie."""

    def __init__(self, address: str):
        self.cookies = http.cookiejar.CookieJar()
        jar = urllib.request.HTTPCookieProcessor(self.cookies)
        self.opener = urllib.request.build_opener(jar)
        self.root = address.split("/?")[0]
        self.opener.open(address, timeout=60).read()

    def get(self, path: str) -> tuple[int, bytes]:
        """Status and content of an address."""
        try:
            with self.opener.open(self.root + path, timeout=60) as answer:
                return answer.status, answer.read()
        except urllib.error.HTTPError as error:
            return error.code, error.read()

    def send(self, method: str, path: str, data: bytes) -> int:
        """The status that sending this has."""
        request = urllib.request.Request(self.root + path, data=data, method=method)
        with self.opener.open(request, timeout=60) as answer:
            return answer.status
