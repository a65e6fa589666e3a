"""The way from runs to weighed answers: where to look from, and each answer at its own point."""
