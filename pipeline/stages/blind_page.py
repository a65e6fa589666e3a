"""The result of a blind check as a page of the documents, with its pictures."""

from pathlib import Path

from pipeline.blind.score import CampaignScore, Figure, Rate
from pipeline.report.figures.blind import confusion_picture, rates_picture
from pipeline.stages.blind_campaign import BlindRequest, BlindResult

_DISTRUST = """\
## When to distrust this
- The truth is another simulator, written apart (`pipeline/blind/truth`): momenta, rotation matrix
  and an adaptive integrator; shafts with their own dynamics; coloured noise; every stated
  parameter drawn within its stated uncertainty. It is still a simulator: what neither knows
  (free surface, thrusters that blow at each other, hoses) is in no case.
- Gaps are measured against the healthy floor over windows of ten seconds, in the worst channel.
  Some effects cannot reach the wanted gap at any possible value: the reached one is used.
- The directions and sizes of the effects are drawn from this program's idea of what is plausible.
"""


def write_page(result: BlindResult, request: BlindRequest, page: Path) -> None:
    """Write the page and its pictures beside it, each whole or not at all.

    Parameters
    ----------
    result : BlindResult
        The campaign.
    request : BlindRequest
        What was asked for, for the command on the page.
    page : Path
        ``*.md``; pictures go to ``images`` beside it.
    """
    images = page.parent / "images"
    images.mkdir(parents=True, exist_ok=True)
    score = result.score
    pictures = {
        "blind-confusion.svg": confusion_picture(
            score.confusion.truths, score.confusion.answers, score.confusion.counts
        ),
        "blind-rates.svg": rates_picture(
            [
                (f"{one.question}, {one.stratum}", one.share, one.low, one.high)
                for one in score.rates
                if one.share is not None and one.low is not None and one.high is not None
                if one.goal
            ]
        ),
    }
    for name, content in pictures.items():
        _write(images / name, content)
    _write(page, _text(result, request))


def _write(path: Path, text: str) -> None:
    temporary = path.with_name(f".{path.name}.part")
    temporary.write_text(text, encoding="utf-8")
    temporary.replace(path)


def _text(result: BlindResult, request: BlindRequest) -> str:
    place = request.place
    vehicles = " ".join(f"--vehicle {name}" for name in place.vehicles)
    command = (
        f"rig2sea blind --cases {request.cases} --seed {place.seed} --run-s {place.run_s:g} "
        f"{vehicles} --to DIR"
    )
    left = result.score.refused
    lines = [
        "# The blind check",
        "",
        "<!-- Written by rig2sea blind --page; do not edit. -->",
        "",
        f"{result.done} cases of {', '.join(place.vehicles)}, seed {place.seed};",
        f"six runs of {place.run_s:g} s in each, two of them held out;",
        f"{result.not_made} could not be flown, {left} were refused as hopeless. Again with",
        "",
        f"    {command}",
        "",
        "Labels were sealed before each diagnosis and opened when its verdict was on disk. Bounds",
        "are those of Clopper and Pearson at 95 %. Gap means gap over healthy floor.",
        "",
        "## Rates",
        "",
        "| question | cases | yes | rate | bounds | goal | met |",
        "|---|---|---|---|---|---|---|",
        *(_rate_row(one) for one in result.score.rates if one.cases),
        "",
        "![Rates with their bounds](images/blind-rates.svg)",
        "",
        "## Figures",
        "",
        "| figure | cases | median | 90th percentile | goal | met |",
        "|---|---|---|---|---|---|",
        *(_figure_row(one) for one in result.score.figures),
        "",
        "## Confusion",
        "",
        "![Truth against answer](images/blind-confusion.svg)",
        "",
        *_baselines(result.score),
        _DISTRUST,
    ]
    return "\n".join(lines)


def _rate_row(one: Rate) -> str:
    share = "" if one.share is None else f"{one.share:.1%}"
    bounds = "" if one.low is None or one.high is None else f"{one.low:.1%} to {one.high:.1%}"
    met = {None: "", True: "yes", False: "**no**"}[one.met]
    return (
        f"| {one.question}; {one.stratum} | {one.cases} | {one.yes} | {share} | {bounds} "
        f"| {one.goal} | {met} |"
    )


def _figure_row(one: Figure) -> str:
    median = "" if one.median is None else f"{one.median:.3g}"
    p90 = "" if one.p90 is None else f"{one.p90:.3g}"
    met = {None: "", True: "yes", False: "**no**"}[one.met]
    return (
        f"| {one.question}; {one.stratum} | {one.cases} | {median} | {p90} | {one.goal} | {met} |"
    )


def _baselines(score: CampaignScore) -> list[str]:
    """Right answers of the baselines, and of this diagnosis on the same cases."""
    if not score.baselines:
        return []
    rows = []
    for name, table in (("this diagnosis", score.compared), *score.baselines.items()):
        right = total = quiet = healthy = 0
        for truth, counts in zip(table.truths, table.counts, strict=True):
            hit = counts[table.answers.index(truth)]
            if truth == "none":
                quiet, healthy = hit, sum(counts)
            elif truth != "unknown":
                right, total = right + hit, total + sum(counts)
        rows.append(f"| {name} | {right} of {total} | {quiet} of {healthy} |")
    answered = sum(sum(counts) for counts in score.compared.counts)
    return [
        "## Beside it: plain methods",
        "",
        f"On the {answered} cases of one effect, of none, and of what is outside the library that",
        "the plain methods answered, too; those outside the library have no right answer here.",
        "",
        "| method | right effect first, single effects of all sizes | none called none |",
        "|---|---|---|",
        *rows,
        "",
    ]
