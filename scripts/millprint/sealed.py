"""Files that a job goes on from, with a digest in front: one bit that is wrong, and the file is no longer used."""

import hashlib
from pathlib import Path

# As large as the block that HDF5 leaves to its users in front of a file, so that a sealed HDF5 file opens as it is.
BLOCK = 512
MARK = b"millprint sealed sha256 "


def _block(payload: bytes) -> bytes:
    return (MARK + hashlib.sha256(payload).hexdigest().encode() + b"\n").ljust(BLOCK, b"\0")


def seal(path: str | Path) -> None:
    """Fill the first BLOCK bytes of a file, which its writer left free, with the digest of all that follows."""
    with open(path, "r+b") as file:
        file.seek(BLOCK)
        block = _block(file.read())
        file.seek(0)
        file.write(block)


def unsealed(path: str | Path) -> bytes:
    """What follows the first BLOCK bytes of a sealed file. Raises ValueError where it is not what was sealed."""
    content = Path(path).read_bytes()
    payload = content[BLOCK:]
    if not content.startswith(MARK):
        raise ValueError("not a sealed file")
    if content[:BLOCK] != _block(payload):
        raise ValueError("truncated or damaged: its digest is another")
    return payload
