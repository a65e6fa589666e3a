"""Campaigns that draw inputs with a known truth and judge what the program makes of them.

`second_generator` is a simulator that shares no formula with the package; `bench_files` writes
bench files as rigs write them; `identification` counts intervals; `bundled` writes the raw files of
the bundled vehicle. No part of the wheel imports this package.
"""
