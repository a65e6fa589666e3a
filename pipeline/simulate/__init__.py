"""The whole vehicle in simulation: one compiled kernel, its inputs and its runs."""
