"""The same inputs give the same bytes, whatever the machine around them is set to."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from synthetic_bench import Bench, digest, make_vehicle, write_mooring, write_open_water

from pipeline.provenance import code_digest
from pipeline.stage_process import run_stage
from pipeline.stage_table import module_of

#: Another place, other libraries' threads, another order of sets and dictionaries' keys.
ELSEWHERE = {
    "TZ": "Asia/Vladivostok",
    "OMP_NUM_THREADS": "4",
    "OPENBLAS_NUM_THREADS": "4",
    "MKL_NUM_THREADS": "4",
    "NUMBA_NUM_THREADS": "2",
    "PYTHONHASHSEED": "4711",
    "PYTHONUTF8": "0",
    "COLUMNS": "40",
}


def russian(folder: Path) -> dict[str, str]:
    """Return the variables of a Russian locale of one byte a letter; make it if need be.

    Without the tools the variables name a locale that is not there, which is the C locale.
    """
    name = "ru_RU.KOI8-R"
    maker = shutil.which("localedef")
    if maker is not None:
        subprocess.run(
            [maker, "-i", "ru_RU", "-f", "KOI8-R", str(folder / name)],
            capture_output=True,
            check=False,
            timeout=60,
        )
    return {"LANG": name, "LC_ALL": name, "LOCPATH": str(folder)}


def test_force_redoes_everything_and_all_is_the_same_elsewhere(
    finished: Bench, tmp_path: Path
) -> None:
    """Locale, time zone, threads, cores, order of sets, umask, and another folder."""
    expected = finished.contents()
    done = subprocess.run(
        [sys.executable, "-m", "pipeline", "run", "--cores", "1", "--force"],
        cwd=finished.root,
        env={**os.environ, **ELSEWHERE, **russian(tmp_path)},
        umask=0o077,
        capture_output=True,
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    stages = [stage for _, stage in finished.stages_run()]
    assert {"load_test", "static", "inverse", "tables", "firmware", "index_page"} <= {*stages}
    assert len(stages) == 13
    assert len(expected) > 15
    assert finished.contents() == expected
    table = finished.root / "processed/boat/tables.json"
    assert table.stat().st_mode & 0o777 == 0o600  # the umask itself is obeyed


def stage_digest(root: Path, stage: str) -> str:
    """Run a reader in a folder and return the digest of its result."""
    before = Path.cwd()
    os.chdir(root)
    try:
        folder = Path("raw/boat")
        out = Path(f"processed/boat/{stage}.json")
        # as the rule does it: by name
        files = tuple(sorted((folder / stage).iterdir()))
        code = code_digest(module_of(stage))
        assert run_stage(stage, "boat", code, (folder / "vehicle.yaml", *files), (out,)) == 0
        return digest(root / out)
    finally:
        os.chdir(before)


@pytest.mark.parametrize(
    ("stage", "write"), [("open_water", write_open_water), ("mooring", write_mooring)]
)
def test_order_in_which_files_were_made_does_not_matter(
    tmp_path: Path, stage: str, write: Callable[[Path], None]
) -> None:
    digests = set()
    for name, order in (("one", "abc"), ("other", "cba")):
        root = tmp_path / name
        make_vehicle(root / "raw/boat")
        for letter in order:
            write(root / f"raw/boat/{stage}/{letter}.csv")
        digests.add(stage_digest(root, stage))
    assert len(digests) == 1


def test_locale_without_the_letters_does_not_stop_a_message(tmp_path: Path) -> None:
    make_vehicle(tmp_path / "raw/boat")
    sheet = tmp_path / "raw/boat/mooring/швартовы.csv"
    shutil.copy(tmp_path / "raw/boat/mooring/bollard.csv", sheet)
    done = subprocess.run(
        [sys.executable, "-m", "pipeline", "check", str(sheet)],
        env={**os.environ, "PYTHONIOENCODING": "iso8859-1"},
        capture_output=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    assert rb"\u0448" in done.stdout


def test_engine_alone_starts_the_same_workflow(fresh: Bench) -> None:
    """The Snakefile of the source tree is an include, and still makes everything by default."""
    done = subprocess.run(
        [
            *(sys.executable, "-m", "snakemake", "--dry-run", "--cores", "1"),
            *("--snakefile", str(Path(__file__).parents[2] / "Snakefile")),
        ],
        cwd=fresh.root,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    assert "wildcards: job=boat/stages" in done.stdout + done.stderr
