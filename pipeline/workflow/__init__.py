"""Runs the workflow: what is stale, the engine underneath, and what the user is told."""
