"""Sealed keys: salted hashes published before any solving, the keys themselves ciphered until all solutions are in.

The password is drawn anew and stays in this process's memory. Who stops the proof and goes on loses it; the keys are then made
again from the seed, and must match the hashes that were published.
"""

import hashlib
import hmac
import json
import secrets
from dataclasses import dataclass, field


class SealError(Exception):
    """The seal is broken: keys that do not match what was published, or a wrong password."""


def canonical(content: dict) -> bytes:
    """One spelling of a dict, so that equal content has equal hashes."""
    return json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False).encode()


def salt_of(seed: int, case: str) -> str:
    """The case's salt, 32 hex digits: drawn from the proof's seed, so that the same proof publishes the same hashes."""
    return hashlib.sha256(f"salt of {case}, {seed}".encode()).hexdigest()[:32]


def hashed(key: dict, salt: str) -> str:
    """SHA-256 of salt and key, in hex."""
    return hashlib.sha256(bytes.fromhex(salt) + canonical(key)).hexdigest()


@dataclass(frozen=True)
class Seal:
    """What opens the sealed keys. `password` is in memory only; it is not shown when this is printed."""

    password: bytes = field(default_factory=lambda: secrets.token_bytes(32), repr=False)

    def close(self, keys: dict[str, dict], salts: dict[str, str]) -> bytes:
        """Keys and salts, ciphered: nonce (16), check (32), text."""
        plain, nonce = canonical({"keys": keys, "salts": salts}), secrets.token_bytes(16)
        text = self._stream(plain, nonce)
        return nonce + hmac.digest(self.password, nonce + text, "sha256") + text

    def open(self, sealed: bytes) -> tuple[dict[str, dict], dict[str, str]]:
        """Keys and salts; SealError when the password is not the one, or the text was changed."""
        nonce, check, text = sealed[:16], sealed[16:48], sealed[48:]
        if not hmac.compare_digest(check, hmac.digest(self.password, nonce + text, "sha256")):
            raise SealError("the sealed keys do not open: another password, or they were changed")
        content = json.loads(self._stream(text, nonce))
        return content["keys"], content["salts"]

    def _stream(self, text: bytes, nonce: bytes) -> bytes:
        mask = hashlib.shake_256(self.password + nonce).digest(len(text))
        return (int.from_bytes(text) ^ int.from_bytes(mask)).to_bytes(len(text))


def verify(keys: dict[str, dict], salts: dict[str, str], published: dict[str, str]) -> None:
    """SealError unless every key matches its published hash."""
    if set(keys) != set(published):
        raise SealError(f"{len(published)} hashes were published, for other cases than the {len(keys)} keys")
    wrong = [case for case in keys if hashed(keys[case], salts[case]) != published[case]]
    if wrong:
        raise SealError(f"{len(wrong)} keys are not those whose hashes were published, {wrong[0]} first")
