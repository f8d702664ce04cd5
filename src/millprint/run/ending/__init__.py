"""Messages at the end of a run: what was made, where to look first, what to do next; or what failed, what to try."""
