"""The settings of the set-ups that others measured, a module a kind, as in `millprint.validation`."""
