"""What every blind campaign does: run the cases that are not done yet, seal, diagnose, open, count.

In its folder ``campaign.json`` says what makes its cases what they are, so that only that campaign
goes on; ``cases.jsonl`` grows by a line of JSON for each case that is done. The sealed labels and
the verdicts lie beside them.
"""

import json
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from pipeline.blind.label import CaseLabel, open_label
from pipeline.blind.score import Score
from pipeline.errors import CannotComputeError, InputError, Place
from pipeline.provenance import unwritable, write_atomically
from pipeline.stopping import stopped_by_sigterm

if TYPE_CHECKING:
    from pipeline.diagnose.case import Case


HEADER_FILE, CASES_FILE = "campaign.json", "cases.jsonl"
#: Told of every case: how many are done, how many there are, one line.
Said = Callable[[int, int, str], None]
Asked = TypeVar("Asked")
Result = TypeVar("Result")
S_co = TypeVar("S_co", bound=Score, covariant=True)


@dataclass(frozen=True, kw_only=True)
class CampaignRequest:
    """What is asked for; `to` is the folder of the campaign.

    `only` names some cases by number, which need not be among the first `cases`.
    """

    to: Path
    cases: int = 60
    seed: int = 0
    resume: bool = False
    processes: int = 2
    only: tuple[int, ...] = ()

    @property
    def numbers(self) -> Sequence[int]:
        """Numbers of the cases that are asked for."""
        return sorted(set(self.only)) or range(self.cases)


@dataclass(frozen=True)
class CampaignResult(Generic[S_co]):
    """A campaign, finished or stopped.

    `lines` are those of ``cases.jsonl`` that have a score, by number; `code` is the digest of the
    program that made them.
    """

    schema: str
    score: S_co
    lines: tuple[Mapping[str, Any], ...]
    wanted: int
    not_made: int
    to: Path
    code: str

    @property
    def done(self) -> int:
        """Cases that are over, those that could not be made included."""
        return len(self.lines) + self.not_made

    def to_json(self) -> dict[str, Any]:
        """Return what ``rig2sea blind --json`` prints."""
        return {
            "schema": self.schema,
            "cases": self.done,
            "wanted": self.wanted,
            "not_made": self.not_made,
            "to": str(self.to),
            "code": self.code,
            "score": self.score.model_dump(mode="json"),
        }


def run_cases(
    request: CampaignRequest,
    header: Mapping[str, Any],
    run: Callable[[int], dict[str, Any]],
    score: Callable[[Sequence[Mapping[str, Any]]], S_co],
    said: Said,
) -> CampaignResult[S_co]:
    """Run the cases of a campaign that have no line yet, and score all that are done.

    `header` is what makes its cases what they are: ``schema``, ``code`` (of the program) and more.
    `run` makes a line of a number (another process must be able to import it), `score` the score of
    the lines of cases that could be made; `said` is told of every case.
    """
    file, numbers = request.to / CASES_FILE, request.numbers
    claim_folder(file, {**header, "seed": request.seed}, resume=request.resume)
    done = {line["number"]: line for line in read_lines(file) if line["number"] in numbers}
    wanted = [number for number in numbers if number not in done]
    with appending(file) as append, stopped_by_sigterm():
        try:
            for line in as_they_come(run, wanted, request.processes):
                append(line)
                done[line["number"]] = line
                said(len(done), len(numbers), _line_text(line))
        except KeyboardInterrupt:
            said(len(done), len(numbers), "stopped; --resume goes on from here")
    lines = tuple(done[number] for number in sorted(done) if "score" in done[number])
    not_made = len(done) - len(lines)
    return CampaignResult(
        header["schema"], score(lines), lines, len(numbers), not_made, request.to, header["code"]
    )


def diagnosed(case: "Case") -> Mapping[str, Any]:
    """Return the content of ``diagnosis.json``, or ``{"refused": reason}`` where there is none."""
    from pipeline.diagnose.engine import diagnose

    try:
        record = diagnose(case)
    except CannotComputeError as error:
        return {"refused": str(error)}
    content: dict[str, Any] = record.model_dump(mode="json", exclude={"series"})
    return content


def judged(
    sealed: Path, diagnose: Callable[[], Mapping[str, Any]]
) -> tuple[CaseLabel, Mapping[str, Any], float]:
    """Diagnose a case whose label is sealed, and open it when the verdict is on disk.

    A fault of the program is no right answer, and told. Returns the label, the content of the
    verdict, and the time that it took [s].
    """
    began = time.perf_counter()
    try:
        content = diagnose()
    except Exception as error:  # noqa: BLE001 - whatever went wrong is the verdict
        content = {"refused": f"fault of the program: {type(error).__name__}: {error}"[:500]}
    elapsed_s = time.perf_counter() - began
    verdict = sealed.parents[1] / "verdicts" / sealed.stem / "diagnosis.json"
    write_atomically(verdict, json.dumps(content))
    return open_label(sealed, verdict), content, elapsed_s


def _line_text(line: Mapping[str, Any]) -> str:
    """One line for a person; the truth is told, since the case is over."""
    if "not_made" in line:
        return f"case {line['number']}: not made: {line['not_made']}"
    score = line["score"]
    truth, told = "+".join(score["truth"]), "+".join(score["verdict"])
    truth += f" {line['thruster']}" if line.get("thruster") else ""
    told += f" {line['told_thruster']}" if line.get("told_thruster") else ""
    if score["ambiguous_with"]:
        told += f" (or {', '.join(score['ambiguous_with'])})"
    return (
        f"case {line['number']}: {score['vehicle']}, {truth} at {score['gap_ratio']:.1f} floors: "
        f"{told}, {score['probability']:.2f}, {score['elapsed_s']:.0f} s"
    )


def as_they_come(
    run: Callable[[Asked], Result], cases: Sequence[Asked], processes: int
) -> Iterator[Result]:
    """Run cases, and yield what comes of them: in their order with one process, in any with more.

    Another process must be able to import `run`.
    """
    if processes == 1 or len(cases) < 2:
        yield from map(run, cases)
        return
    # each process has one core: linear algebra is not to start threads on top
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        waiting = [pool.submit(run, case) for case in cases]
        try:
            for future in as_completed(waiting):
                yield future.result()
        except BaseException:
            # only the cases that are at work are waited for, not all that were asked for
            for future in waiting:
                future.cancel()
            raise


def claim_folder(lines_file: Path, header: Mapping[str, Any], *, resume: bool) -> None:
    """Write what a campaign is, or check that the folder holds this one.

    Raises `InputError` when the folder holds a campaign and `resume` is not set, or another
    campaign.
    """
    file = lines_file.with_name(HEADER_FILE)
    if lines_file.is_file() and not resume:
        raise InputError.at(
            Place(str(lines_file)),
            "there is a campaign in this folder already.",
            remedy="Give --resume to go on with it, or another folder with --to.",
        )
    if lines_file.is_file() and file.is_file():
        before = _read_header(file, header["schema"])
        differ = [key for key in header if before.get(key) != header[key]]
        if differ:
            raise InputError.at(
                Place(str(file)),
                f"the campaign in this folder has another {', '.join(differ)}.",
                expected="the same seed, vehicles and program: its cases would not be alike.",
                remedy="Begin a new campaign in another folder with --to.",
            )
    try:
        write_atomically(file, json.dumps(header, indent=1))
    except InputError as error:
        # the folder of a campaign has an option of its own
        remedy = error.problem.remedy.replace("--out", "--to")
        raise InputError(replace(error.problem, remedy=remedy)) from None


def _read_header(file: Path, schema: str) -> dict[str, Any]:
    """Read what a campaign is."""
    fault = "is not the header of a campaign."
    try:
        header = json.loads(file.read_text(encoding="utf-8"))
        if isinstance(header, dict):
            return header
    except OSError as error:
        fault = f"cannot be read: {error.strerror}."
    except (ValueError, RecursionError):
        pass
    raise InputError.at(
        Place(str(file)),
        fault,
        expected=f'a JSON object with "schema": "{schema}".',
        remedy="Put the file back that was there, or begin in another folder with --to.",
    )


def read_lines(file: Path) -> list[dict[str, Any]]:
    """Lines that a campaign has written; one that was cut off is left out.

    >>> read_lines(Path("no such file"))
    []
    """
    if not file.is_file():
        return []
    found = []
    for text in file.read_text(encoding="utf-8").splitlines():
        try:
            line = json.loads(text)
        except json.JSONDecodeError:
            continue
        if isinstance(line, dict):
            found.append(line)
    return found


@contextmanager
def appending(file: Path) -> Iterator[Callable[[dict[str, Any]], None]]:
    """Give a function that appends a line, each written to the end before it returns.

    A last line that was cut off is ended first: the next one would be lost with it.
    """
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        there = file.read_bytes() if file.is_file() else b""
        stream = file.open("a", encoding="utf-8")
    except OSError as error:
        raise unwritable(file, error) from error
    with stream:

        def append(line: dict[str, Any]) -> None:
            stream.write(json.dumps(line) + "\n")
            stream.flush()

        if there and not there.endswith(b"\n"):
            stream.write("\n")
        yield append
