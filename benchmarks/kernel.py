"""Speed of the simulation kernel beside its peers, all in one run.

python benchmarks/kernel.py            measure (about five minutes), print the figures
python benchmarks/kernel.py --quick    the same in a few seconds, for a look
python benchmarks/kernel.py --write    measure, and put figures and plots into docs/
"""

import argparse
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[0] = str(ROOT)  # run as a script, the folder above is not on the path

from benchmarks import page, sections  # noqa: E402 (see the line above)
from benchmarks.measure import conditions, load_average  # noqa: E402
from benchmarks.peer_c_library import PeerC, build, compiler, version  # noqa: E402


def main() -> None:
    """Measure as asked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="few rounds: a look, not a figure")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures there")
    parser.add_argument("--write", action="store_true", help="renew docs/benchmarks.md")
    options = parser.parse_args()
    if options.quick and options.write:
        parser.error("--quick gives no figures to be quoted: --write goes without it")
    with tempfile.TemporaryDirectory() as folder:
        figures = measure(Path(folder), quick=options.quick)
    print(page.text(figures))
    if options.json:
        sections.save(options.json, figures)
    if options.write:
        target = ROOT / "docs" / "benchmarks.md"
        page.update(target, page.BEGIN, page.END, page.text(figures))
        for path in page.plots(figures, ROOT / "docs" / "images"):
            print(f"wrote {path.relative_to(ROOT)}")


def measure(folder: Path, *, quick: bool) -> sections.Figures:
    """Take every figure; the C peer is compiled in a folder, where there is gcc."""
    peers: dict[str, PeerC] = {}
    taken_on = conditions()
    if compiler() is None:
        print("note: gcc is not installed; there is no comparison with C", file=sys.stderr)
    else:
        peers = {
            "C -O3": build(folder),
            "C -O3 -march=native": build(folder, native=True),
        }
        taken_on["gcc"] = version()
    found: sections.Figures = {"quick": quick, "conditions": taken_on}
    parts: dict[str, Callable[[], object]] = {
        "single": lambda: sections.single_trajectory(peers, quick=quick),
        "two_cores": lambda: sections.two_cores(quick=quick),
        "first_call": lambda: sections.first_call(quick=quick),
        "thrusters": lambda: sections.growth_with_thrusters(peers, quick=quick),
        "trajectories": lambda: sections.growth_with_trajectories(quick=quick),
        "segments": lambda: sections.growth_with_segments(quick=quick),
        "sensitivity": lambda: sections.sensitivity(quick=quick),
    }
    for name, part in parts.items():
        print(f"{name} ...", file=sys.stderr, flush=True)
        found[name] = part()
    taken_on["load average after"] = load_average()
    return found


if __name__ == "__main__":
    main()
