"""The blind check: cases of a separate truth simulator with sealed labels, and their scoring."""
