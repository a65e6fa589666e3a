"""What the diagnosis is judged by from outside: a simulator that shares nothing with the package.

The package is used for reading the files that are written here, for the diagnosis that is judged,
and for counting; no formula of it takes part.
"""
