"""What ``rig2sea check`` shows: what was understood of raw files, and every problem."""
