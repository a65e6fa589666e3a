"""Where the jobs of a run are executed: a Snakemake profile, shipped or of the user."""

from importlib.util import find_spec
from pathlib import Path

import pipeline
from pipeline.errors import InputError, Place

FILE = "config.yaml"
_LARGEST_BYTES = 1_000_000


def find_profile(text: str) -> Path:
    """Return the folder of a profile, absolute.

    `text` is the name of a shipped one (``"slurm"``), or a path to a folder with ``config.yaml``.
    """
    folder = next((path for path in (Path(text), *_shipped(text)) if (path / FILE).is_file()), None)
    if folder is None:
        raise InputError.at(
            Place(text),
            "is no profile.",
            expected=f"a folder with a {FILE}, or one of the shipped profiles: {_shipped_names()}.",
            remedy="docs/cluster.md shows how to make one of your own.",
        )
    _check(folder / FILE)
    return folder.resolve()


def _rooms() -> tuple[Path, Path]:
    """Return where shipped profiles lie: in the source tree, in the installed package."""
    package = Path(pipeline.__file__).resolve().parent
    return package.parent / "profiles", package / "profiles"


def _shipped(name: str) -> list[Path]:
    plain = Path(name).name == name and name not in {"", ".", ".."}
    return [room / name for room in _rooms()] if plain else []


def _shipped_names() -> str:
    names = {path.parent.name for room in _rooms() for path in room.glob(f"*/{FILE}")}
    return ", ".join(sorted(names)) or "none"


def _check(path: Path) -> None:
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    body: object = None
    try:
        if path.stat().st_size <= _LARGEST_BYTES:
            body = YAML(typ="safe", pure=True).load(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, YAMLError, RecursionError):
        body = None
    if not isinstance(body, dict):
        raise InputError.at(
            Place(str(path)),
            "is not a profile.",
            expected="options of the workflow engine in YAML: key: value.",
            remedy="profiles/slurm/config.yaml is one to copy.",
        )
    executor = body.get("executor")
    if not isinstance(executor, str) or executor in {"local", "dryrun", "touch"}:
        return
    if find_spec(f"snakemake_executor_plugin_{executor.replace('-', '_')}") is None:
        extra = '"rig2sea[cluster]"' if executor == "slurm" else None
        package = extra or f"snakemake-executor-plugin-{executor}"
        raise InputError.at(
            Place(str(path)),
            f'the executor "{executor}" is not installed.',
            expected="its plugin in the environment of rig2sea.",
            remedy=f"pip install {package}",
        )
