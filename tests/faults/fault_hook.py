"""Kill a run at the moment when it puts a file in its place; a module of the tests.

Nothing in the program knows of this: a ``sitecustomize`` of Python, on the path of the processes
that a test starts, listens to the interpreter's own audit events.
"""

import os
import subprocess
import sys
from pathlib import Path

_HOOK = """\
import os, re, signal, sys, time

os.environ.setdefault("FAULT_RUN", str(os.getpid()))
_log, _at, _root = os.environ["FAULT_LOG"], os.environ["FAULT_AT"], os.environ["FAULT_ROOT"]

def _listen(event, arguments):
    if event != "os.rename":
        return
    target = os.path.abspath(os.fsdecode(arguments[1]))
    if not target.startswith(_root + os.sep):
        return
    name = re.sub(r"(/\\.firmware\\.)[^/]+", r"\\1", os.path.relpath(target, _root))
    with open(_log, "a", encoding="utf-8") as file:
        file.write(name + "\\n")
    if name == _at:
        os.kill(int(os.environ["FAULT_RUN"]), signal.SIGKILL)
        # the rest ends with the run; a stage that ended by itself before would be cleared away
        time.sleep(20)
        os.kill(os.getpid(), signal.SIGKILL)

sys.addaudithook(_listen)
"""


def run_with_hook(root: Path, work: Path, *, kill_at: str = "") -> int:
    """Run ``rig2sea run`` in a folder, killed just before a file gets its name.

    Parameters
    ----------
    root : Path
        The working folder.
    work : Path
        A folder for the hook and its list.
    kill_at : str
        The file, from the working folder, as `renamed` gives it; empty to let the run go on to
        its end.

    Returns
    -------
    int
        Exit code, negative for a signal.
    """
    work.mkdir(parents=True, exist_ok=True)
    (work / "sitecustomize.py").write_text(_HOOK, encoding="utf-8")
    listed = work / "renamed.txt"
    listed.unlink(missing_ok=True)
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(filter(None, (str(work), os.environ.get("PYTHONPATH", "")))),
        "FAULT_LOG": str(listed),
        "FAULT_AT": kill_at,
        "FAULT_ROOT": str(root.resolve()),
    }
    done = subprocess.run(
        [sys.executable, "-m", "pipeline", "run", "--cores", "1"],
        cwd=root,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        check=False,
        timeout=300,
    )
    return done.returncode


def renamed(work: Path) -> list[str]:
    """Files that the last run put in their place, each once, in that order."""
    lines = (work / "renamed.txt").read_text(encoding="utf-8").splitlines()
    return list(dict.fromkeys(lines))
