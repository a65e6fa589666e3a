"""What a command does once its options are read, one file an action; no terminal."""
