"""The vehicle as it was: what its sound runs show that its file does not say."""
