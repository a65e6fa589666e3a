"""What happened during a run: a force that sets in at a time, and what let it."""
