"""Design calculations before a vehicle is built: balance, propeller, tether, added mass."""
