"""The thesis: one user of the mill's library, which never imports it."""
