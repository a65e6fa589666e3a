"""Part four of the answer: the manoeuvre that would tell two answers apart best."""

from functools import partial

import numpy as np

from pipeline.diagnose.case import Case, channels_of, setting_of
from pipeline.diagnose.inference.answer import Answers
from pipeline.diagnose.judging.hypotheses import Finding, with_ordinary
from pipeline.diagnose.judging.search import Search, force_prior
from pipeline.diagnose.linear.elimination import grams, marginal
from pipeline.diagnose.linear.evidence import Prior
from pipeline.diagnose.linear.scales import Level
from pipeline.diagnose.linear.tangent import linear_model
from pipeline.diagnose.rules.weighing import UNKNOWN
from pipeline.errors import CannotComputeError
from pipeline.records.diagnosis import NextRun
from pipeline.records.run_table import RunTable
from pipeline.simulate.fly import fly
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.manoeuvres import MANOEUVRES, Manoeuvre
from pipeline.simulate.sensors import measure
from pipeline.types import FloatArray

_SECONDS = 30.0


def next_run(
    case: Case, found: Search, answered: Answers, ambiguous: tuple[str, ...]
) -> NextRun | None:
    """Best of the manoeuvres that the vehicle can fly, by the expected separation.

    The separation is that of the two predictions against the noise, in standard deviations, after
    the second answer has taken all of the first that it can (which is nothing if it is `none`). Of
    a pair it takes one effect's place, beside the other one.

    Parameters
    ----------
    case : Case
        Vehicle and runs.
    found : Search
        What the runs said.
    answered : Answers
        Most probable first.
    ambiguous : tuple of str
        What these runs cannot tell from the first.

    Returns
    -------
    NextRun or None
        None where nothing is left to be told apart.
    """
    sensors = case.vehicle.sensors
    # an effect that hardly shows, and none: then what would show it
    told = [name for name in (answered.ranking[0].name, *ambiguous) if name != UNKNOWN]
    first = next((one for one in map(answered.of, told) if one and one.finding), None)
    if first is None or first.finding is None or sensors is None:
        return None
    own = {first.name, *first.finding.effects}
    rival = next((name for name in told if name not in own), None)
    if rival is None:
        return None
    members = [k for (effect, _), which in found.groups.items() if effect == rival for k in which]
    rivals = [[*members, *beside] for beside in _beside(found, first.finding)] if members else [[]]
    direction = np.zeros(len(found.setting.coordinates))
    direction[list(first.finding.which)] = first.finding.mean

    def separation(manoeuvre: Manoeuvre) -> float | None:
        try:
            flown = fly(case.packed, manoeuvre.plan(case.packed, 1.0, _SECONDS))
            log = measure(flown, case.packed, sensors)
            table = table_of_log(log, sensors, name=manoeuvre.name)
            return _separation(case, found, table, direction, rivals)
        except CannotComputeError:
            return None

    values = found.setting.bench.workers.each(
        [partial(separation, one) for one in MANOEUVRES.values()]
    )
    flyable = [
        (value, name) for name, value in zip(MANOEUVRES, values, strict=True) if value is not None
    ]
    if not flyable:
        return None
    value, name = max(flyable, key=lambda row: row[0])
    return NextRun(manoeuvre=name, separates=(first.name, rival), expected_separation_sigma=value)


def _beside(found: Search, finding: Finding) -> list[list[int]]:
    """Departures that stay when one effect of a finding gives way; none of a single effect."""
    every = found.setting.coordinates
    return [[k for k in finding.which if every[k].effect.id != one] for one in finding.effects]


def _separation(
    case: Case, found: Search, table: RunTable, direction: FloatArray, rivals: list[list[int]]
) -> float:
    """Norm of what is left of a signature once the closest rival's signatures are taken off."""
    channels = channels_of(case.vehicle, [table])
    setting = setting_of(case, [table], channels, force_unit=found.setting.force_unit, threads=1)
    normal = grams(linear_model(setting, setting.origin()))
    level = Level(np.ones(6), 1.0, True)
    prior = Prior(np.zeros(direction.size), found.prior.covariance)
    ground = with_ordinary(marginal(normal, force_prior(setting, level)), prior)
    whole, left = ground.information, []
    for members in rivals:
        taken = whole[np.ix_(members, members)] + 1e-9 * np.eye(len(members))
        shared = whole[members] @ direction
        left.append(float(direction @ whole @ direction - shared @ np.linalg.solve(taken, shared)))
    return float(np.sqrt(max(min(left), 0.0)))
