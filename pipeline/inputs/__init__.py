"""What stages and commands start from: a vehicle with its bench results, and its runs."""
