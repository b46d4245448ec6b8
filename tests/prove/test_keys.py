"""Published hashes hold the keys to what they were."""

import pytest

from benchtwin.prove.run import KeyMismatch, hashed, salt_of, verify

KEYS = {
    "case-0001": {"effects": [{"name": "drag", "value": 0.0123}], "rig": "drop"},
    "case-0002": {"effects": [], "rig": "roll"},
}
SALTS = {case: salt_of(7, case) for case in KEYS}


def test_a_hash_needs_its_salt_and_its_key():
    published = {case: hashed(key, SALTS[case]) for case, key in KEYS.items()}
    verify(KEYS, SALTS, published)
    assert hashed(KEYS["case-0002"], SALTS["case-0001"]) != published["case-0002"]
    with pytest.raises(KeyMismatch, match="case-0002"):
        verify({**KEYS, "case-0002": {"effects": [], "rig": "pile"}}, SALTS, published)
    with pytest.raises(KeyMismatch, match="other cases"):
        verify({"case-0001": KEYS["case-0001"]}, SALTS, published)


def test_salts_differ_by_case_and_by_proof():
    assert (
        len({salt_of(7, "case-0001"), salt_of(7, "case-0002"), salt_of(8, "case-0001")})
        == 3
    )
