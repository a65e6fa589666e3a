"""The report: one self-contained page for each vehicle and an index that leads to them."""
