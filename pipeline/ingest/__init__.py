"""Raw files of the rig become checked records: the only place where their quirks are known."""
