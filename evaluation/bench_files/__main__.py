"""``python -m evaluation.bench_files --files N --seed S``: draw, read, judge.

Exit code 1 where a file was read wrongly in silence, or fewer than nine tenths of the files without
a corruption were read right.
"""

import argparse
import sys
from pathlib import Path
from tempfile import mkdtemp

from evaluation.bench_files.judge import judge_file, summary

#: Of the files without a corruption.
LEAST_RIGHT = 0.9


def main() -> int:
    """Run the campaign and print what came of it."""
    parser = argparse.ArgumentParser(prog="python -m evaluation.bench_files")
    parser.add_argument("--files", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--from", dest="first", type=int, default=0, help="number of the first file"
    )
    parser.add_argument("--to", type=Path, help="folder that keeps files read wrongly in silence")
    given = parser.parse_args()
    folder = given.to or Path(mkdtemp(prefix="bench_files."))
    folder.mkdir(parents=True, exist_ok=True)
    numbers = range(given.first, given.first + given.files)
    files = [judge_file(given.seed, number, folder) for number in numbers]
    print(summary(files))
    clean = [one for one in files if not one.corruptions]
    right = sum(one.outcome == "right" for one in clean) >= LEAST_RIGHT * len(clean)
    silent = any(one.outcome == "silently wrong" for one in files)
    return 1 if silent or not right else 0


if __name__ == "__main__":
    sys.exit(main())
