"""The blind check: cases made or put into measured runs, diagnosed, scored, and its pages."""
