"""One file a stage: read files, call pure functions, write one file. A workflow rule calls it.

A stage's code is what its module imports, so that a changed line redoes exactly what depends on it.
"""
