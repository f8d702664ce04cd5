"""A static page to explore a fingerprint and a yield model without server or network."""
