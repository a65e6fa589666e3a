"""Raw files of `mmt300`, rebuilt from printed tables by a deterministic generator."""
