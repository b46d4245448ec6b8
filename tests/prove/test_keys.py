"""Sealed keys open only with their password, and only unchanged; hashes tell salt and key."""

import pytest

from prove.keys import Seal, SealError, hashed, salt_of, verify

KEYS = {"case-0001": {"effects": [{"name": "drag", "value": 0.0123}], "rig": "drop"}, "case-0002": {"effects": [], "rig": "roll"}}
SALTS = {case: salt_of(7, case) for case in KEYS}


def test_the_seal_gives_back_what_was_closed():
    seal = Seal()
    assert seal.open(seal.close(KEYS, SALTS)) == (KEYS, SALTS)


def test_without_the_password_nothing_is_read():
    closed = Seal().close(KEYS, SALTS)
    assert b"drag" not in closed
    with pytest.raises(SealError, match="do not open"):
        Seal().open(closed)


def test_changed_keys_do_not_open():
    seal = Seal()
    closed = bytearray(seal.close(KEYS, SALTS))
    closed[-5] ^= 1
    with pytest.raises(SealError):
        seal.open(bytes(closed))


def test_the_password_is_not_shown():
    seal = Seal(b"open sesame")
    assert "sesame" not in repr(seal)


def test_a_hash_needs_its_salt_and_its_key():
    published = {case: hashed(key, SALTS[case]) for case, key in KEYS.items()}
    verify(KEYS, SALTS, published)
    assert hashed(KEYS["case-0002"], SALTS["case-0001"]) != published["case-0002"]
    with pytest.raises(SealError, match="case-0002"):
        verify({**KEYS, "case-0002": {"effects": [], "rig": "pile"}}, SALTS, published)
    with pytest.raises(SealError, match="other cases"):
        verify({"case-0001": KEYS["case-0001"]}, SALTS, published)


def test_salts_differ_by_case_and_by_proof():
    assert len({salt_of(7, "case-0001"), salt_of(7, "case-0002"), salt_of(8, "case-0001")}) == 3
