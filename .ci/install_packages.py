"""Install packages into the environment of this Python: by uv, which takes seconds, else by pip.

    python .ci/install_packages.py --no-deps --require-hashes --requirement requirements.lock

The arguments are those that ``pip install`` and ``uv pip install`` have in common. uv is installed
first, as requirements.lock has it. It does not read pip's settings, so where pip looks for packages
is handed over to it. Where it cannot install them, pip does, and tells what it thinks of it.
"""

import ast
import os
import re
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

LOCK = Path(__file__).resolve().parents[1] / "requirements.lock"
PIP = (sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet")
UV = (sys.executable, "-m", "uv", "--quiet")
#: Setting of pip that says where packages are -> how uv is told.
OPTIONS = {
    "index-url": "--index-url",
    "extra-index-url": "--extra-index-url",
    "find-links": "--find-links",
    "trusted-host": "--allow-insecure-host",
}
VARIABLES = {"cert": "SSL_CERT_FILE", "proxy": "ALL_PROXY"}
_SETTING = re.compile(r"(?P<where>global|install|:env:)[.](?P<name>[a-z-]+)=(?P<value>.*)")


def settings_of_pip() -> dict[str, str]:
    """Return what pip is set to for an installation: files first, the environment last."""
    listed = subprocess.run([*PIP, "config", "list"], capture_output=True, text=True, check=False)
    found = [match for line in listed.stdout.splitlines() if (match := _SETTING.fullmatch(line))]
    found.sort(key=lambda match: ("global", "install", ":env:").index(match["where"]))
    return {match["name"]: str(ast.literal_eval(match["value"])) for match in found}


def by_pip(*arguments: str) -> int:
    """Install by pip; return its exit code."""
    return subprocess.run([*PIP, "install", "--no-compile", *arguments], check=False).returncode


def has_uv() -> bool:
    """Tell whether there is uv; install it as the lock has it where there is none."""
    if find_spec("uv") is None:
        entry = re.search(r"^uv==(?:.*\\\n)*.*\n", LOCK.read_text(encoding="utf-8"), re.MULTILINE)
        with tempfile.NamedTemporaryFile("w", suffix=".txt") as alone:
            alone.write(entry.group() if entry else "")
            alone.flush()
            by_pip("--no-deps", "--require-hashes", "--requirement", alone.name)
    return find_spec("uv") is not None


def by_uv(*arguments: str) -> bool:
    """Install by uv; tell whether that went well."""
    pip = settings_of_pip()
    places = [
        part
        for name, option in OPTIONS.items()
        for place in pip.get(name, "").split()
        for part in (option, place)
    ]
    if pip.get("no-index", "").lower() in {"1", "true", "yes", "on"}:
        places.append("--no-index")
    # every hash is in the lock, so it does not matter which place a package is from
    any_place = ("--index-strategy", "unsafe-best-match")
    variables = {variable: pip[name] for name, variable in VARIABLES.items() if name in pip}
    command = [*UV, "pip", "install", "--python", sys.executable, *any_place, *places, *arguments]
    done = subprocess.run(
        command, capture_output=True, env={**variables, **os.environ}, check=False
    )
    return done.returncode == 0


if __name__ == "__main__":
    asked = sys.argv[1:]
    sys.exit(0 if has_uv() and by_uv(*asked) else by_pip(*asked))
