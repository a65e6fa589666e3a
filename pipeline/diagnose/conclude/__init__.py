"""What each answer leaves of the gap, and what is said because of it."""
