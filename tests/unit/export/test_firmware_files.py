"""The five files: their names, that they repeat to the byte, and what stands in them."""

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
from firmware_cases import CASES, table2

from pipeline.errors import CannotComputeError
from pipeline.export import firmware
from pipeline.export.c_source import Identity
from pipeline.export.firmware import write_firmware
from pipeline.export.table_files import neutral_cell, render_csv, render_json
from pipeline.records.fits import FirmwareCharacteristic

IDENTITY = Identity("mmt300", "3f" * 32, "0.1.0")


def write(folder: Path, name: str = "mmt300", **changes: object) -> tuple[Path, ...]:
    values: dict[str, object] = {
        "characteristic": table2(),
        "tables_digest": "3f" * 32,
        "tool_version": "0.1.0",
        "tables": {"table1": {"KT": [0.139, -0.155, -0.061]}},
    }
    return write_firmware(name, folder=folder, **(values | changes))  # type: ignore[arg-type]


@pytest.mark.parametrize("case", CASES)
def test_same_input_same_bytes(case: str, tmp_path: Path) -> None:
    first = write(tmp_path / "a", characteristic=CASES[case]())
    second = write(tmp_path / "b", characteristic=CASES[case]())
    assert [path.name for path in first] == [
        "mmt300_thruster.h",
        "mmt300_thruster.c",
        "mmt300_thruster_self_test.c",
        "mmt300_thruster.json",
        "mmt300_thruster.csv",
        "mmt300_tables.csv",
    ]
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]
    assert sorted((tmp_path / "a").iterdir()) == sorted(first)


def test_sources_are_ascii_lines_that_fit(tmp_path: Path) -> None:
    for path in write(tmp_path)[:3]:
        text = path.read_bytes().decode("ascii")
        assert "\r" not in text
        assert "\t" not in text
        assert text.endswith(("}\n", "_H */\n"))
        # A digest cannot be broken.
        assert not [x for x in text.splitlines() if len(x) > 100 and not x.startswith("#define")]
        assert all(line == line.rstrip() for line in text.splitlines())


def test_digest_and_version_are_inside(tmp_path: Path) -> None:
    for path in write(tmp_path, tables_digest="0a1b2c", tool_version="7.8.9")[:4]:
        text = path.read_text()
        assert "0a1b2c" in text
        assert "7.8.9" in text


@pytest.mark.parametrize("case", ["bench_only", "forward_only"])
def test_a_range_that_ends_at_zero_has_no_minus_there(case: str, tmp_path: Path) -> None:
    """Known at rest only, or without reverse."""
    header = write(tmp_path, characteristic=CASES[case]())[0].read_text()
    assert re.search(r"^ \*   (speed|thrust) +0\.000 to ", header, flags=re.MULTILINE)
    assert "-0.000" not in header


def test_the_header_tells_what_the_tables_did_not_pass(tmp_path: Path) -> None:
    found = "size of the thrust calculated less measured: " + "negative codes +1.85 N, " * 6
    quality = {
        "table1": {"KT": {"points": 50}, "checks": [{"name": "a", "passed": True, "text": "fine"}]},
        "table2": None,
        "table3": {"positive": None},
        "round_trip": [],
        "checks": [
            {"name": "mooring test agrees", "passed": False, "text": f"{found}*/ int x;"},
            {"name": "round trip", "passed": True, "text": "0.2 N"},
        ],
    }
    header = write(tmp_path, tables={"quality": quality})[0].read_text()
    comment = " ".join(line.strip(" *") for line in header.partition("*/")[0].splitlines())
    assert "Checks that failed when the tables were made" in comment
    assert "mooring test agrees: size of the thrust" in comment
    assert comment.count("negative codes +1.85 N,") == 6
    assert "/ int x;" in comment
    assert "round trip" not in comment
    assert all(len(line) <= 100 for line in header.splitlines() if not line.startswith("#define"))
    assert "Checks that failed" not in write(tmp_path, tables=None)[0].read_text()


def test_the_header_tells_of_codes_that_were_only_mirrored(tmp_path: Path) -> None:
    told = "Negative codes mirror positive ones"
    assert told not in write(tmp_path, characteristic=CASES["bench_only"]())[0].read_text()
    forward = CASES["bench_only"]()
    mirrored = forward.positive.model_copy(update={"sign": -1, "against_motion": "else"})
    both = forward.model_copy(update={"negative": mirrored})
    assert told in write(tmp_path, characteristic=both)[0].read_text()
    one_way = write(tmp_path, characteristic=both.model_copy(update={"code_min": 0}))[0].read_text()
    assert told not in one_way
    assert "The drive takes no negative code" in one_way


def test_the_interface_is_declared_and_defined(tmp_path: Path) -> None:
    header, source = (path.read_text() for path in write(tmp_path, name="T200-16V")[:2])
    for signature in (
        "int16_t T200_16V_code_from_thrust_f32(float thrust_n, float speed_mps)",
        "float T200_16V_thrust_from_code_f32(int16_t code, float speed_mps)",
        "int16_t T200_16V_code_from_thrust_q(int32_t thrust_n_q16, int32_t speed_mps_q16)",
        "int32_t T200_16V_thrust_from_code_q(int16_t code, int32_t speed_mps_q16)",
        "float T200_16V_thrust_max_f32(float speed_mps)",
        "float T200_16V_thrust_min_f32(float speed_mps)",
        "int32_t T200_16V_thrust_max_q(int32_t speed_mps_q16)",
        "int32_t T200_16V_thrust_min_q(int32_t speed_mps_q16)",
    ):
        assert f"{signature};\n" in header
        assert f"{signature}\n{{" in source
    assert "#ifndef T200_16V_THRUSTER_H\n#define T200_16V_THRUSTER_H\n" in header
    assert '#include "T200-16V_thruster.h"' in source


def test_library_uses_no_other_library(tmp_path: Path) -> None:
    included = re.findall(r"#include (.*)", "".join(p.read_text() for p in write(tmp_path)[:2]))
    assert sorted(included) == ['"mmt300_thruster.h"', "<stdbool.h>", "<stdint.h>"]


def test_equal_branches_share_their_tables(tmp_path: Path) -> None:
    """A characteristic that mirrors costs the flash of one sign."""
    sound = table2()
    mirrored = sound.model_copy(update={"negative": sound.positive.model_copy(update={"sign": -1})})
    assert "negative_code_q16[" in write(tmp_path)[1].read_text()
    text = write(tmp_path, characteristic=mirrored)[1].read_text()
    assert "negative_code" not in text
    assert text.count("    positive_code_q16,\n") == 2


def test_hostile_texts_stay_inside_their_strings(tmp_path: Path) -> None:
    digest = '*/ int x; /* "; system("x"); \\\n??/'
    for path in write(tmp_path, tables_digest=digest)[:3]:
        without_strings = re.sub(r'"(?:[^"\\\n]|\\.)*"', "", path.read_text())
        code = re.sub(r"/\*.*?\*/", "", without_strings, flags=re.DOTALL)
        assert "system" not in code
        assert "int x" not in code
    with pytest.raises(CannotComputeError, match="cannot be named"):
        write(tmp_path, name="a; int x")


def test_nothing_is_written_when_the_grid_is_refused(tmp_path: Path) -> None:
    broken = table2().model_copy(update={"code_max": 100})
    with pytest.raises(CannotComputeError, match="0 to 100 is expected"):
        write(tmp_path / "out", characteristic=broken)
    assert not (tmp_path / "out").exists()


def test_unwritable_folder_is_said_plainly(tmp_path: Path) -> None:
    occupied = tmp_path / "file"
    occupied.write_text("")
    with pytest.raises(CannotComputeError, match=r"firmware of mmt300 cannot be written"):
        write(occupied)


def test_a_failure_half_way_leaves_the_old_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = {path: path.read_bytes() for path in write(tmp_path)}
    synced = []

    def full(descriptor: int) -> None:
        synced.append(descriptor)
        if len(synced) == 3:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(firmware.os, "fsync", full)
    with pytest.raises(CannotComputeError, match="No space left on device"):
        write(tmp_path, tables_digest="new")
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_json_holds_the_characteristic_at_full_precision() -> None:
    text = render_json(IDENTITY, table2(), {"vehicle": "mmt300"})
    content = json.loads(text)
    assert FirmwareCharacteristic.model_validate(content["firmware"]) == table2()
    assert content["tables"] == {"vehicle": "mmt300"}
    assert content["fixed_point"]["positive"]["code"][0][-1] == 127 * 65536
    assert list(content) == sorted(content)


def test_json_refuses_what_is_not_finite() -> None:
    with pytest.raises(CannotComputeError, match="mmt300 cannot be written as JSON"):
        render_json(IDENTITY, table2(), {"table1": [float("nan")]})


def test_csv_holds_the_grid_with_signs() -> None:
    characteristic = table2()
    rows = list(csv.DictReader(render_csv(IDENTITY, characteristic).splitlines()))
    assert len(rows) == 2 * 9 * 33
    assert rows[0] == {
        "vehicle": "mmt300",
        "tables_digest": "3f" * 32,
        "speed_mps": "0.0",
        "fraction": "0.0",
        "thrust_n": "0.0",
        "code": repr(-characteristic.negative.code[0][0]),
    }
    positive = [row for row in rows if float(row["code"]) > 0]
    codes = np.array([float(row["code"]) for row in positive]).reshape(9, 33)
    assert (codes == np.array(characteristic.positive.code)).all()
    assert float(positive[-1]["thrust_n"]) == characteristic.positive.thrust_max_n[-1]
    negative = [row for row in rows if float(row["code"]) < 0]
    assert all(float(row["speed_mps"]) <= 0 and float(row["thrust_n"]) <= 0 for row in negative)
    assert not any(row["speed_mps"] == "-0.0" for row in rows)


@pytest.mark.parametrize("text", ["=1+1", "+1", "-1", "@x", "\t=1", "\r=1"])
def test_csv_text_is_no_formula(text: str) -> None:
    assert neutral_cell(text) == f"'{text}"
    digest = Identity("mmt300", text, "0.1.0")
    rows = list(csv.DictReader(render_csv(digest, table2()).splitlines(keepends=True)))
    assert not rows[0]["tables_digest"].startswith(text)
