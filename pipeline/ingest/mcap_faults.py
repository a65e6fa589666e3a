"""What is wrong with a log, said once, however many passes over the file meet it."""

from pipeline.errors import Place, Problem


class LogFaults:
    """Collects the problems of one log; `cut_at` is the byte behind which nothing is whole."""

    def __init__(self, place: Place) -> None:
        """Begin with none; `place` names the log in messages."""
        self.place = place
        self.problems: list[Problem] = []
        self.cut_at: int | None = None
        self._said: set[str] = set()

    def add(self, what: str) -> None:
        """Say a fault."""
        if what not in self._said:
            self._said.add(what)
            self.problems.append(Problem("warning", self.place, what))

    def cut(self, at: int, size: int, how: str = "") -> None:
        """Say that the log has no end: records are whole up to byte `at` of `size`.

        `how` is what is there instead of an end, with a blank behind it.
        """
        if self.cut_at is not None:
            return  # said by an earlier pass
        self.cut_at = at
        share = 100.0 * at / size if size else 0.0
        self.problems.append(
            Problem(
                "warning",
                self.place,
                f"the log ends {how}at byte {size} without its closing record: the recorder "
                f"was stopped hard, or the copy is not complete. Whole records were read up to "
                f"byte {at} ({share:.0f} %).",
                "a file that ends with 89 4D 43 41 50 30 0D 0A.",
                "Copy it again; if it is no longer elsewhere, mcap recover FILE makes an index.",
            )
        )
