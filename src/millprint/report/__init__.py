"""Pages of a run of any mill: its gallery, and its tables."""
