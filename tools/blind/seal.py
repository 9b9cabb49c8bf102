"""Labels under seal: encrypted at once, so that nobody reads them by accident; the key lies elsewhere."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from cryptography.fernet import Fernet, InvalidToken

LENGTH_STEP = 1 << 16  # the sealed text is padded to a multiple, so that its length tells little


class SealError(ValueError):
    """The seal does not fit the key, or was broken."""


def seal(labels: dict[str, Any], path: Path, key_path: Path) -> str:
    """Write the labels to ``path`` and the key to ``key_path`` (not readable by others). Returns the SHA-256."""
    text = json.dumps(labels, sort_keys=True).encode()
    text += b" " * (-len(text) % LENGTH_STEP)
    key = Fernet.generate_key()
    sealed = Fernet(key).encrypt(text)
    path.write_bytes(sealed)
    handle = os.open(key_path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(handle, "wb") as file:
        file.write(key)
    return hashlib.sha256(sealed).hexdigest()


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def unseal(path: Path, key_path: Path) -> dict[str, Any]:
    """
    Raises:
        SealError: the key is not the one, or the file was changed.
    """
    try:
        text = Fernet(key_path.read_bytes()).decrypt(path.read_bytes())
    except (InvalidToken, ValueError):
        raise SealError(f"{path}: the key {key_path} does not open it, or it was changed") from None
    labels: dict[str, Any] = json.loads(text)
    return labels
