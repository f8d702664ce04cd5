"""Numbers that are read off a run: a record for each, with its definition, its scaling and its errors."""
