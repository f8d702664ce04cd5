"""Snapshots of a run made to be looked at: files for ParaView, frames of an animation."""
