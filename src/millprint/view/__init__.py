"""Snapshots of a run for viewing: files for ParaView, and frames of an animation."""
