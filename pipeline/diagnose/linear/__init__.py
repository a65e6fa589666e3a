"""The linear model of all windows: unknowns, derivatives by them, what is integrated out."""
