"""A measured vehicle against the vehicle as it was: regression on its sound runs."""
