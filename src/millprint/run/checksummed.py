"""Restart files that begin with a digest of their content, so that a damaged file is not used."""

import hashlib
from pathlib import Path

# HDF5 allows a user block of this size at the start of a file, so that a sealed HDF5 file can be opened directly.
BLOCK = 512
MARK = b"millprint sealed sha256 "


def checksum_header(payload: bytes) -> bytes:
    """The block of BLOCK bytes in front of a payload, which contains its digest."""
    return (MARK + hashlib.sha256(payload).hexdigest().encode() + b"\n").ljust(BLOCK, b"\0")


def read_checksummed(path: str | Path) -> bytes:
    """The payload of a sealed file. Raises ValueError if it has changed since it was sealed."""
    content = Path(path).read_bytes()
    payload = content[BLOCK:]
    if not content.startswith(MARK):
        raise ValueError("not a sealed file")
    if content[:BLOCK] != checksum_header(payload):
        raise ValueError("truncated or damaged: its digest does not match")
    return payload
