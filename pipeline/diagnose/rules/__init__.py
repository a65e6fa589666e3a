"""Rules and thresholds by which weighed answers become what is said; numbers only."""
