"""millprint: the mechanical fingerprint of a ball mill, from its geometry and motion to chemistry."""
