"""Tables 1-4 as the file that firmware builds and people read."""
