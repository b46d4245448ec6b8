"""Every address of the page answers in words, whatever lies in the folder."""

import shutil
from urllib.parse import quote

import pytest

from benchtwin.vision.find_recordings import find_recordings
from benchtwin.vision.recording import Recording

from .spoilt import spoilt_bench
from .visitor import Visitor

EVERY_KIND = 54  # recordings: each of the wrong keys stands in one of them
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


@pytest.fixture(
    scope="module", params=[EVERY_KIND, pytest.param(200, marks=pytest.mark.slow)]
)
def spoilt(request, tmp_path_factory):
    place = tmp_path_factory.mktemp("spoilt")
    spoilt_bench(place / "bench", place / "made", request.param, seed=0)
    yield place / "bench"
    shutil.rmtree(place)


def test_no_recording_is_passed_over_in_silence(spoilt):
    found = find_recordings(spoilt)
    told = {e.path.name if isinstance(e, Recording) else e.recording for e in found}
    made = {p.name for p in spoilt.iterdir() if (p / "recording.toml").exists()}
    assert len(made) >= EVERY_KIND and made <= told


def test_no_address_fails_whatever_lies_in_the_folder(spoilt, serve):
    names = [p.name for p in sorted(spoilt.iterdir())]
    addresses = [p.format(".") for p in OF_BENCH]
    addresses += [p.format(quote(name)) for name in names for p in OF_ONE]
    failed = []
    with serve(spoilt) as address:
        visitor = Visitor(address)
        for path in addresses:
            status, text = visitor.get(path)
            if status >= 500 or b"Traceback" in text or (not text and status != 404):
                failed.append((status, path, text[-300:]))
    assert not failed, f"{len(failed)}: {failed[:5]}"
