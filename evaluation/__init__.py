"""Campaigns that draw inputs with a known truth and judge what the program makes of them.

A simulator that shares nothing with the package, and bench files as rigs write them. The package is
used for reading what is written here, for what is judged, and for counting; no formula of it takes
part.
"""
