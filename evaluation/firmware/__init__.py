"""Generated firmware on a Cortex-M4: built, emulated, its size and instructions counted."""
