"""The gap: predictions ahead of each window, the healthy floor, and where both differ."""
