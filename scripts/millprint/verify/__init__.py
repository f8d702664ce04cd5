"""Repairs what earlier runs left behind: locks of killed runs, and files that were damaged later."""
