"""The claims of the thesis against what was computed."""
