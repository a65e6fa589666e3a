"""The stages: read files, call pure functions, write one file; `stage_table` says which is where.

A stage's code is what its module imports, so that a changed line redoes what depends on it.
"""
