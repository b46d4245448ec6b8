"""Every address of the page answers in words, whatever lies in the folder."""

import http.cookiejar
import shutil
import urllib.error
import urllib.request
from urllib.parse import quote

import pytest
from benchtwin.vision.find_recordings import find_recordings

from .spoilt import spoilt_bench

RECORDINGS = 200
OF_ONE = (
    "/recording?r={}",
    "/thumb?r={}",
    "/photo?r={}",
    "/frame?r={}&i=0",
    "/frame?r={}&i=1003",
    "/wave?r={}&a=0&b=1&n=500",
    "/sound?r={}",
    "/overlay?r={}&name=pile",
)
OF_BENCH = ("/bench?b={}", "/bench?b={}&tab=Results", "/bench?b={}&tab=Run")
OF_BENCH += ("/bench?b={}&tab=What%20holds%20for%20all", "/next?bench={}")
OF_BENCH += ("/zip?bench={}", "/cards?bench={}&engine=lammps")


class Visitor:
    """A browser without scripts."""

    def __init__(self, address: str):
        jar = urllib.request.HTTPCookieProcessor(http.cookiejar.CookieJar())
        self.opener = urllib.request.build_opener(jar)
        self.root = address.split("/?")[0]
        self.opener.open(address, timeout=60).read()

    def get(self, path: str) -> tuple[int, bytes]:
        try:
            with self.opener.open(self.root + path, timeout=60) as answer:
                return answer.status, answer.read()
        except urllib.error.HTTPError as error:
            return error.code, error.read()


@pytest.fixture(scope="module")
def spoilt(tmp_path_factory):
    place = tmp_path_factory.mktemp("spoilt")
    spoilt_bench(place / "bench", place / "made", RECORDINGS, seed=0)
    yield place / "bench"
    shutil.rmtree(place)


@pytest.mark.xfail(reason="known: seen to fail, not yet found out why")
def test_no_address_fails_whatever_lies_in_the_folder(spoilt, serve):
    names = [p.name for p in sorted(spoilt.iterdir())]
    assert len(names) > RECORDINGS
    with serve(spoilt) as address:
        visitor = Visitor(address)
        failed = []
        for path in [p.format(".") for p in OF_BENCH] + [
            p.format(quote(name)) for name in names for p in OF_ONE
        ]:
            status, text = visitor.get(path)
            if status >= 500 or b"Traceback" in text or (not text and status != 404):
                failed.append((status, path, text[-300:]))
        assert not failed, f"{len(failed)}: {failed[:5]}"


@pytest.mark.xfail(reason="known: seen to fail, not yet found out why")
def test_no_recording_is_passed_over_in_silence(spoilt):
    found = find_recordings(spoilt)
    told = {
        getattr(e, "path", spoilt / getattr(e, "recording", "")).name for e in found
    }
    made = {p.name for p in spoilt.iterdir() if p.name.startswith("r")}
    assert made <= told
