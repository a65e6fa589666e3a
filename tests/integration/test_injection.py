"""Text from outside stays text: in pages, in C, in CSV, in the shell, in paths."""

import csv
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest
from click.testing import CliRunner
from hostile_files import mooring_rows, workbook
from mcap.writer import Writer
from shared_runs import once, rig2sea
from synthetic_bench import VEHICLE, make_vehicle

from pipeline.bundled.design import design_example, design_examples
from pipeline.cli import cli

#: Ends what it may stand in (attribute, script, comment, string, template), then shows itself.
EVIL = (
    "\"'><probe-tag onload=x></script></style></title><probe-tag>{{7*7}}{%x%}<!--"
    "]]> */ int probe_code; /* ??/ \\ javascript:probe() =probe() $(touch probe_file)"
)
SHEET = "\"><probe-tag a='"
HEADER = 'Notes "><probe-tag onload=x>'
CSV_NAME = "$(touch probe_file);'`touch probe_file`\" & touch probe_file #.csv"
REFUSED_NAME = "<probe-tag>{x}.csv"
LOG_NAME = "-rf \"' $(touch probe_file) & x.mcap"


class Tags(HTMLParser):
    """Start tags and attributes of a page, and what stands inside of scripts and styles."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: set[str] = set()
        self.attributes: list[tuple[str, str]] = []
        self.feed(page)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.attributes += [(name, value or "") for name, value in attrs]


def assert_harmless(page: str) -> None:
    found = Tags(page)
    assert "probe-tag" not in found.tags
    assert not [name for name, _ in found.attributes if name.startswith("on") or "probe" in name]
    addresses = [value for name, value in found.attributes if name in {"href", "src", "action"}]
    odd = [one for one in addresses if re.match(r"\s*(javascript|data|vbscript):", one)]
    assert set(odd) <= {"data:,"}, "but for the icon that is none"
    assert not [one for one in addresses if one.startswith(("//", "http:"))]
    assert "49" not in re.findall(r"probe-tag&gt;(\d+)", page), "a template was run"


def hostile_log(path: Path) -> None:
    """A log of which every text is hostile: library, topics, types, definitions, metadata."""
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile=EVIL, library=EVIL)
        writer.add_metadata(EVIL, {EVIL: EVIL})
        schema = writer.register_schema(EVIL, "ros2msg", f"float64 {EVIL}".encode())
        channels = [
            writer.register_channel("/imu/data", EVIL, 0),
            writer.register_channel(f"/{EVIL}", "cdr", schema),
            writer.register_channel("/depth", "json", 0),
        ]
        for k in range(40):
            for channel in channels:
                body = json.dumps({"depth": 0.1 * k, EVIL: EVIL}).encode()
                writer.add_message(channel, 1_700_000_000_000_000_000 + k * 10**8, body, 0)
        writer.finish()


def vehicle_text() -> str:
    quoted = json.dumps(EVIL)
    text = VEHICLE.replace(
        "title: a boat that exists on paper only", f"title: {quoted}\ndata_note: {quoted}"
    )
    text = text.replace("diameter_m: 0.14", f"diameter_m: 0.14, source: {quoted}")
    text = text.replace("code_max: 127", f"code_max: 127, source: {quoted}")
    printed = "{positive: [0, 1, 0, 0], negative: [0, 1, 0, 0]}"
    return text + f"published: {{source: {quoted}, table3: {printed}}}\n"


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A mooring test and a log of a vehicle, all texts hostile, run once."""

    def build(root: Path) -> None:
        folder = root / "raw/boat"
        make_vehicle(folder)
        for part in ("load_test", "open_water"):
            for file in (folder / part).iterdir():
                file.unlink()
        (folder / "vehicle.yaml").write_text(vehicle_text(), encoding="utf-8")
        rows = [[*row, EVIL] for row in mooring_rows()]
        workbook(folder / "mooring/a.xlsx", {SHEET: [["Code", "Thrust, N", HEADER], *rows]})
        bad = [["Code", f"Thrust, {EVIL[:60]}"], *mooring_rows()]
        workbook(folder / "mooring/b.xlsx", {"b": bad})
        (folder / "mooring" / CSV_NAME).write_text("code,thrust (N)\n10,<probe-tag>\n30,1\n")
        (folder / "mooring" / REFUSED_NAME).write_text("code,thrust (N)\n10,1\n")
        (folder / "pool").mkdir()
        hostile_log(folder / "pool" / LOG_NAME)
        notes = LOG_NAME.replace(".mcap", ".yaml")
        quoted = json.dumps(EVIL)
        (folder / "pool" / notes).write_text(f"what: {quoted}\nwho: [{quoted}]\ntext: {quoted}\n")
        done = rig2sea(root, "run", "--cores", "1")
        (root / "printed.txt").write_text(done.stdout + done.stderr, encoding="utf-8")

    return once(tmp_path_factory, "injection", build)


def pages(site: Path) -> list[Path]:
    return sorted((site / "reports").rglob("*.html"))


def test_no_page_holds_markup_from_outside(site: Path) -> None:
    names = {path.relative_to(site / "reports").parts[0:2] for path in pages(site)}
    assert {("index.html",), ("boat", "index.html"), ("boat", "runs")} <= names
    for path in pages(site):
        assert_harmless(path.read_text(encoding="utf-8"))


def test_the_texts_are_shown_all_the_same(site: Path) -> None:
    page = (site / "reports/boat/index.html").read_text(encoding="utf-8")
    for shown in ("&lt;probe-tag", "b.xlsx", "{x}.csv"):
        assert shown in page
    (run,) = (path for path in pages(site) if path.parent.name == "runs")
    assert "&lt;probe-tag" in run.read_text(encoding="utf-8")


def test_nothing_was_run_and_nothing_left_its_folder(site: Path) -> None:
    assert not list(site.rglob("probe_file*"))
    assert "Traceback" not in (site / "printed.txt").read_text(encoding="utf-8")
    assert "fault of rig2sea" not in (site / "printed.txt").read_text(encoding="utf-8")
    tops = {path.name for path in site.iterdir()}
    assert tops <= {"raw", "processed", "reports", "printed.txt", ".snakemake"}
    results = [path for top in ("processed", "reports") for path in (site / top).rglob("*")]
    plain = re.compile(r"[A-Za-z0-9._-]+")
    assert [path.name for path in results if not plain.fullmatch(path.name)] == []


def test_c_holds_no_text_from_outside_as_code(site: Path) -> None:
    sources = sorted((site / "processed/boat/firmware").glob("*.[ch]"))
    assert sources
    for path in sources:
        text = path.read_text(encoding="ascii")
        code = re.sub(r'"(?:[^"\\\n]|\\.)*"|/\*.*?\*/', " ", text, flags=re.DOTALL)
        assert "probe" not in code
        assert "??" not in text


def test_csv_holds_no_formula(site: Path) -> None:
    files = sorted((site / "processed/boat").rglob("*.csv"))
    assert files
    for path in files:
        with path.open(encoding="utf-8", newline="") as stream:
            for row in csv.reader(stream):
                for cell in row:
                    numeric = re.fullmatch(r"[-+]?[0-9.]+(e[-+]?\d+)?", cell)
                    assert numeric or not cell.startswith(("=", "+", "-", "@", "\t", "\r"))


@pytest.mark.parametrize("calculator", ["balance", "propeller"])
def test_design_pages(tmp_path: Path, calculator: str) -> None:
    example = design_example(calculator, design_examples(calculator)[0]).read_text("utf-8")
    text = re.sub(r"(?m)^(title): .*$", lambda m: f"{m[1]}: {json.dumps(EVIL)}", example)
    assert text != example
    file = tmp_path / "a.yaml"
    file.write_text(text, encoding="utf-8")
    done = CliRunner().invoke(
        cli, ["design", calculator, str(file), "--to", str(tmp_path / "to"), "--out", str(tmp_path)]
    )
    assert done.exit_code == 0, done.output
    (page,) = (tmp_path / "to").glob("*.html")
    shown = page.read_text(encoding="utf-8")
    assert_harmless(shown)
    assert "&lt;probe-tag" in shown


@pytest.mark.parametrize("name", ["../../evil", "/etc/evil", "a\\0b", "\\u0430bc", "a b", ""])
def test_a_design_cannot_be_named_out_of_its_folder(tmp_path: Path, name: str) -> None:
    example = design_example("balance", design_examples("balance")[0]).read_text("utf-8")
    file = tmp_path / "a.yaml"
    file.write_text(
        re.sub(r"(?m)^name: .*$", lambda _: f'name: "{name}"', example), encoding="utf-8"
    )
    done = CliRunner().invoke(cli, ["design", "balance", str(file), "--to", str(tmp_path / "to")])
    assert done.exit_code == 1
    assert "a name: a letter, then letters" in done.output + (done.stderr or "")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.yaml"]
