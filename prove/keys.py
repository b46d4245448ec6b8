"""Salted hashes of the answer keys, published before any case is solved.

The keys stay in memory until all solutions are in. A proof that was stopped makes them
again from its seed, and they must match the published hashes."""

import hashlib
import json


class KeyMismatch(Exception):
    """The keys are not those whose hashes were published."""


def canonical(content: dict) -> bytes:
    """One spelling of a dict, so that equal content has equal hashes."""
    return json.dumps(
        content, sort_keys=True, separators=(",", ":"), ensure_ascii=False
    ).encode()


def salt_of(seed: int, case: str) -> str:
    """The case's salt, 32 hex digits: drawn from the proof's seed, so that the same
    proof publishes the same hashes."""
    return hashlib.sha256(f"salt of {case}, {seed}".encode()).hexdigest()[:32]


def hashed(key: dict, salt: str) -> str:
    """SHA-256 of salt and key, in hex."""
    return hashlib.sha256(bytes.fromhex(salt) + canonical(key)).hexdigest()


def verify(
    keys: dict[str, dict], salts: dict[str, str], published: dict[str, str]
) -> None:
    """Raises KeyMismatch unless every key matches its published hash."""
    if set(keys) != set(published):
        raise KeyMismatch(
            f"{len(published)} hashes were published, for other cases than the"
            f" {len(keys)} keys"
        )
    wrong = [
        case for case in keys if hashed(keys[case], salts[case]) != published[case]
    ]
    if wrong:
        raise KeyMismatch(
            f"{len(wrong)} keys are not those whose hashes were published, {wrong[0]}"
            " first"
        )
