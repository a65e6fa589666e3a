"""One posterior: every hypothesis at its own most probable point, run by run and together."""
