"""Diagnose against the vehicle as it was, where its sound runs show more than its file says."""

from collections.abc import Sequence

from pipeline.diagnose.asking.ask import Asked, ask
from pipeline.diagnose.asking.decide import decide, posterior_of
from pipeline.diagnose.asking.search_of import answers_of, search_of
from pipeline.diagnose.case import Case, channels_of, setting_of, usual_force, with_rest
from pipeline.diagnose.conclude.conclusion import Conclusion
from pipeline.diagnose.conclude.consequences import consequence
from pipeline.diagnose.conclude.gap_seen import GapSeen
from pipeline.diagnose.inference.answer import Answers
from pipeline.diagnose.inference.infer import held_in
from pipeline.diagnose.judging.search import Search
from pipeline.diagnose.linear.rest import rest_terms
from pipeline.diagnose.reference.learn import Learned, learn
from pipeline.diagnose.rules.decision import Decided
from pipeline.diagnose.rules.shares import Share
from pipeline.identify.channel_noise import ChannelNoise
from pipeline.records.run_table import RunTable

#: What the probabilities rest on.
CALIBRATED = (
    "one posterior: log evidence of all windows to a power that was chosen on measured runs of one "
    "vehicle with effects put into them; see docs/methods/diagnosis.md, section 6"
)
#: Log evidence, for each window of the sound runs, by which what was learned must beat the file.
BETTER = 3.0


def reference_of(case: Case, threads: int) -> Learned:
    """Learn from the sound runs of a case what its vehicle file lacks."""
    channels = channels_of(case.vehicle, case.healthy)
    setting = setting_of(case, case.healthy, channels, threads=threads)
    terms = rest_terms(case.packed, usual_force(case.packed))
    return learn(with_rest(setting, terms))


def asked_with(
    case: Case,
    runs: Sequence[RunTable],
    channels: Sequence[ChannelNoise],
    reference: Learned,
    threads: int,
) -> tuple[Asked, Search, Answers, Decided]:
    """Ask the runs against a reference; what was asked, and what is said."""
    asked = ask(
        case,
        runs,
        channels,
        reference.beliefs,
        lambda setting: held_in(case, setting.bench.stack.windows),
        threads,
    )
    posterior = posterior_of(asked.answers, len({effect for effect, _ in asked.groups}))
    said = decide(posterior)
    answered = answers_of(asked, posterior)
    shares = tuple(Share(name, value) for name, value in posterior.ranking)
    return asked, search_of(asked), answered, Decided(shares, said.names, said.ambiguous)


def concluded(found: Search, answered: Answers, said: Decided, seen: GapSeen) -> Conclusion:
    """See what the first answer leads to."""
    top = answered.ranking[0]
    led_to = consequence(found, seen.ahead, top, answered.force_scale, seen.every)
    return Conclusion(said, answered, top, led_to)
