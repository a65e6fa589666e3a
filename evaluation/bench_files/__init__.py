"""Bench files by seed with the truth beside them, read without a mapping and judged."""
