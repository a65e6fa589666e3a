from pipeline.library import diagnose_runs as diagnose_runs
from pipeline.library import identify_runs as identify_runs
from pipeline.library import load_vehicle as load_vehicle
from pipeline.library import read_bench as read_bench
from pipeline.library import read_run as read_run
from pipeline.library import simulate_manoeuvre as simulate_manoeuvre
from pipeline.library import thruster_tables as thruster_tables

__version__: str
