"""Pydantic models of every YAML file. They define all keys with units and bounds."""
