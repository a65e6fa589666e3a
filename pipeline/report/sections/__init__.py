"""The chapters of a vehicle's page, one file each; every one is a pure function of the results."""
