"""Pages of the report: summary of the claims, sortable tables, runtimes and versions."""
