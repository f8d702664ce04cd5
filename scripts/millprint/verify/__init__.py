"""What earlier runs left behind: the locks of a run that was killed, and files that were damaged since."""
