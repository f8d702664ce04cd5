"""What people read of a run: the summary of the claims, tables that sort, runtimes and versions."""
