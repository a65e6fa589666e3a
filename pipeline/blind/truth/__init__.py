"""The truth: a simulator that shares no model code with the rest of the package."""
