"""A static page on which a fingerprint and a yield model are explored: no server, no network."""
