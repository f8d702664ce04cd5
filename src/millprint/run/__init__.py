"""What every step needs: its log, files, records, progress."""
