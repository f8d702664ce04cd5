"""What every job needs: log, files, records, progress."""
