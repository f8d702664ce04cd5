"""Pydantic models of every YAML file: the one place that defines a key, its unit and its bounds."""
