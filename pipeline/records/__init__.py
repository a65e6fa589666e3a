"""The schema of every file under ``processed/``, as frozen models."""
