"""The report: one self-contained page for each vehicle and an index that leads to them."""

from pipeline.report.results import VehicleResults
from pipeline.report.site import IndexEntry, index_entry, write_index
from pipeline.report.vehicle_page import write_vehicle_page

__all__ = ["IndexEntry", "VehicleResults", "index_entry", "write_index", "write_vehicle_page"]
