"""What the instruments show of each other, without any force: errors of the DVL."""
