"""From runs and a vehicle file to a verdict: where the simulation fails, and because of what."""
