"""Open-water record -> Table 1."""

from pipeline.identify.propeller import fit_propeller
from pipeline.records.fits import PropellerFit
from pipeline.records.measurements import OpenWaterRecord
from pipeline.stages.job import Job, leaves_record


@leaves_record
def run(job: Job) -> PropellerFit:
    """Fit K_T(J) and K_M(J)."""
    return fit_propeller(job.needed("open_water", OpenWaterRecord), job.vehicle())
