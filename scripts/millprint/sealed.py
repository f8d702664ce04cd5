"""Files that a job goes on from, with a digest in front: one bit that is wrong, and the file is no longer used."""

import hashlib
from pathlib import Path

# As large as the block that HDF5 leaves to its users in front of a file, so that a sealed HDF5 file opens as it is.
BLOCK = 512
MARK = b"millprint sealed sha256 "


def seal(payload: bytes) -> bytes:
    """The block of BLOCK bytes that stands in front of a payload, with its digest."""
    return (MARK + hashlib.sha256(payload).hexdigest().encode() + b"\n").ljust(BLOCK, b"\0")


def unsealed(path: str | Path) -> bytes:
    """What follows the first BLOCK bytes of a sealed file. Raises ValueError where it is not what was sealed."""
    content = Path(path).read_bytes()
    payload = content[BLOCK:]
    if not content.startswith(MARK):
        raise ValueError("not a sealed file")
    if content[:BLOCK] != seal(payload):
        raise ValueError("truncated or damaged: its digest is another")
    return payload
