"""Raw files of the bundled vehicles, rebuilt from printed tables by a deterministic generator."""
