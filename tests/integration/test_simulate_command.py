"""``rig2sea simulate`` and ``rig2sea effects`` as a user types them."""

import contextlib
import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from bundled_models import NAMES
from click.testing import CliRunner
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from shared_runs import rig2sea

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.cli import cli
from pipeline.effects.library import effects
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.types import FloatArray

Done = subprocess.CompletedProcess[str]


def command(folder: Path, *arguments: str) -> Done:
    """Run a command in this process, which has the compiled kernel already."""
    with contextlib.chdir(folder):
        result = CliRunner().invoke(cli, arguments, prog_name="rig2sea")
    return Done(arguments, result.exit_code, result.stdout, result.stderr)


def simulate(folder: Path, *arguments: str) -> Done:
    return command(folder, "simulate", *arguments)


def succeeded(done: Done) -> Done:
    assert done.returncode == 0, done.stdout + done.stderr
    return done


def read(path: Path) -> tuple[dict[str, list[object]], dict[str, str]]:
    """Messages by topic, by a decoder that is not ours, and what the log says of the run."""
    messages: dict[str, list[object]] = {}
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for decoded in reader.iter_decoded_messages():
            messages.setdefault(decoded.channel.topic, []).append(decoded.decoded_message)
        told = {record.name: record.metadata for record in reader.iter_metadata()}
    return messages, told["rig2sea.run"]


def motion(messages: dict[str, list[object]]) -> FloatArray:
    rows = []
    for message in messages["/sim/odometry"]:
        place, twist = message.pose.pose.position, message.twist.twist  # type: ignore[attr-defined]
        rows.append([place.x, place.y, place.z, twist.linear.x, twist.linear.y, twist.angular.z])
    return np.array(rows)


def message_of(done: Done) -> str:
    """The one message of a command that failed, without a traceback and without an output."""
    assert "Traceback" not in done.stdout + done.stderr
    assert done.stdout == ""
    return done.stderr


def test_a_run_of_the_auv_from_its_bench_to_the_log(bench_folder: Path, tmp_path: Path) -> None:
    log = tmp_path / "run.mcap"
    common = ("mmt300", "--manoeuvre", "zig_zag", "--duration", "30", "--to", str(log))
    done = succeeded(rig2sea(bench_folder, "simulate", *common))
    assert done.stderr == ""
    assert "zig_zag, 30 s, effects: none" in done.stdout
    assert done.stdout.splitlines()[-1] == str(log)
    messages, told = read(log)
    assert {"/thrusters/command", "/imu/data", "/dvl/velocity", "/depth"} <= set(messages)
    assert len(messages["/imu/data"]) == 3001
    assert told["flown"] == "zig_zag"
    assert told["seed"] == "0"
    track = motion(messages)
    assert track[-1, 3] == pytest.approx(1.65, abs=0.1)
    measured = [m.twist.linear.x for m in messages["/dvl/velocity"]]  # type: ignore[attr-defined]
    assert measured[-1] == pytest.approx(track[-1, 3], abs=0.03)
    first = messages["/thrusters/command"][0]
    assert first.name == ["upper", "lower", "left", "right", "bow"]  # type: ignore[attr-defined]


def test_same_command_same_bytes_other_seed_other_noise(tmp_path: Path) -> None:
    def one(run: Callable[..., Done], name: str, seed: int) -> Path:
        target = tmp_path / name
        common = ("simulate", "rov8", "--manoeuvre", "heave_steps", "--duration", "4")
        succeeded(run(tmp_path, *common, "--to", str(target), "--seed", str(seed)))
        return target

    # in this process, and in one of its own
    first, again = one(command, "first.mcap", 7), one(rig2sea, "again.mcap", 7)
    assert first.read_bytes() == again.read_bytes()
    other = one(command, "other.mcap", 8)
    assert motion(read(first)[0]).tobytes() == motion(read(other)[0]).tobytes()
    noise = [
        [m.angular_velocity.x for m in read(path)[0]["/imu/data"]]  # type: ignore[attr-defined]
        for path in (first, other)
    ]
    assert noise[0] != noise[1]


def test_an_effect_changes_the_vehicle_and_stands_in_the_log(tmp_path: Path) -> None:
    tracks = []
    for name, more in (("without", ()), ("with", ("--effect", "current:east_mps=0.2"))):
        target = tmp_path / f"{name}.mcap"
        common = ("cargo_carrier", "--manoeuvre", "hover", "--duration", "20", "--to", str(target))
        succeeded(simulate(tmp_path, *common, *more))
        messages, told = read(target)
        tracks.append(motion(messages))
    assert told["effects"] == "current:east_mps=0.2"
    assert tracks[1][-1, 1] - tracks[0][-1, 1] > 1.0


def test_commands_of_a_log_give_the_same_run_again(bench_folder: Path, tmp_path: Path) -> None:
    flown, again = tmp_path / "flown.mcap", tmp_path / "again.mcap"
    common = ("mmt300", "--manoeuvre", "spiral", "--duration", "20", "--to", str(flown))
    succeeded(simulate(bench_folder, *common))
    done = succeeded(simulate(bench_folder, "mmt300", "--run", str(flown), "--to", str(again)))
    assert "commands of flown.mcap" in done.stdout
    one, other = read(flown)[0], read(again)[0]
    assert motion(one).tobytes() == motion(other).tobytes()
    assert {"/thrusters/command", "/sim/imu/data", "/sim/depth"} <= set(other)


def test_what_the_notes_of_a_log_say_happens_again(tmp_path: Path) -> None:
    """A module let go and a winch, declared: the run is the same, bit for bit, on its tether."""
    flown, again = tmp_path / "flown.mcap", tmp_path / "again.mcap"
    common = ("cargo_carrier", "--manoeuvre", "hover", "--duration", "6", "--to", str(flown))
    succeeded(simulate(tmp_path, *common, "--release", "module_1@2", "--winch", "0.3@3"))
    (tmp_path / "flown.yaml").write_text(
        "events:\n  - {at_s: 2.0, release: module_1}\n  - {at_s: 3.0, winch_mps: 0.3}\n",
        encoding="utf-8",
    )
    done = succeeded(simulate(tmp_path, "cargo_carrier", "--run", str(flown), "--to", str(again)))
    assert "release module_1 at 2 s" in done.stdout
    assert motion(read(flown)[0]).tobytes() == motion(read(again)[0]).tobytes()


def raw_messages(path: Path, *, under: str = "/") -> dict[str, list[tuple[int, int, bytes]]]:
    """Messages as bytes by topic, read with the mcap library."""
    found: dict[str, list[tuple[int, int, bytes]]] = {}
    with path.open("rb") as stream:
        for _, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
            if channel.topic.startswith(under):
                entry = (message.log_time, message.publish_time, message.data)
                found.setdefault(channel.topic, []).append(entry)
    return found


def test_a_replay_holds_the_measured_log_and_the_simulation_beside_it(tmp_path: Path) -> None:
    """Every recorded byte is there; what an earlier simulation left under /sim is not."""
    flown, again = tmp_path / "flown.mcap", tmp_path / "again.mcap"
    common = ("rov8", "--manoeuvre", "heave_steps", "--duration", "6", "--to", str(flown))
    succeeded(simulate(tmp_path, *common, "--effect", "residual_buoyancy:force_n=3"))
    succeeded(simulate(tmp_path, "rov8", "--run", str(flown), "--to", str(again)))
    recorded, both = raw_messages(flown), raw_messages(again)
    for topic, messages in recorded.items():
        if not topic.startswith("/sim/"):
            assert both[topic] == messages
            assert len(both["/sim" + topic]) == len(messages)
    measured, simulated = read(again)[0]["/depth"], read(again)[0]["/sim/depth"]
    rise = [m.fluid_pressure - s.fluid_pressure for m, s in zip(measured, simulated, strict=True)]  # type: ignore[attr-defined]
    assert rise[-1] < -200.0  # the floating one lies higher, by 2 cm at least
    with again.open("rb") as stream:
        told = {record.name: record.metadata for record in make_reader(stream).iter_metadata()}
    assert told["rig2sea.recorded_run"]["effects"].startswith("residual_buoyancy")
    assert told["rig2sea.run"]["flown"] == "commands of flown.mcap"
    third = tmp_path / "third.mcap"
    succeeded(simulate(tmp_path, "rov8", "--run", str(again), "--to", str(third)))
    assert raw_messages(third) == both  # and a replay of a replay is the same again


def test_eq_6_of_the_paper_flies_the_auv(bench_folder: Path, tmp_path: Path) -> None:
    target = tmp_path / "paper.mcap"
    common = ("mmt300", "--manoeuvre", "straight", "--duration", "40", "--to", str(target))
    succeeded(simulate(bench_folder, *common, "--allocator", "paper"))
    messages, told = read(target)
    assert told["allocator"] == "paper"
    track = motion(messages)
    assert track[-1, 2] == pytest.approx(10.0, abs=0.1)
    assert track[-1, 3] == pytest.approx(1.6, abs=0.1)
    succeeded(simulate(bench_folder, *common, "--allocator", "paper-mooring"))
    messages, told = read(target)
    assert told["allocator"] == "paper-mooring"
    # without compensation the thrusters give less under way: slower while the integral catches up
    assert np.all(motion(messages)[600:1200, 3] < track[600:1200, 3])


def test_a_module_is_released_and_taken_again(tmp_path: Path) -> None:
    target = tmp_path / "drop.mcap"
    done = succeeded(
        simulate(
            tmp_path,
            *("cargo_carrier", "--manoeuvre", "hover", "--duration", "20", "--to", str(target)),
            *("--release", "module_1@5", "--attach", "module_1@15"),
        )
    )
    assert "release module_1 at 5 s" in done.stdout
    assert done.stderr == ""
    assert "tether: tension at the vehicle" in done.stdout
    assert "latch of module_1: at most" in done.stdout
    messages, told = read(target)
    assert told["events"] == "release module_1 at 5 s; attach module_1 at 15 s"
    assert motion(messages)[:, 2].min() < 9.8
    # the latch holds the wet weight of 73 N while the module is on board, and is silent between
    loads = messages["/sim/latch/module_1"]
    assert loads[0].wrench.force.z == pytest.approx(73.1, abs=1.0)  # type: ignore[attr-defined]
    assert len(loads) == len(messages["/sim/odometry"]) - 500


def test_an_event_that_finds_no_command_any_more_did_not_happen(tmp_path: Path) -> None:
    """1.95 s is within the run, but the last of its commands begins at 1.9 s."""
    target = tmp_path / "late.mcap"
    done = succeeded(
        simulate(
            tmp_path,
            *("cargo_carrier", "--manoeuvre", "hover", "--duration", "2", "--to", str(target)),
            *("--release", "module_1@1.21", "--attach", "module_1@1.95"),
            *("--release", "module_2@2"),
        )
    )
    said = " ".join(done.stderr.split())
    assert "attach module_1 at 1.95 s did not happen: it waits for the next command" in said
    assert "release module_2 at 2 s lies beyond the run" in said
    assert said.count("beyond the run") == 1


def test_a_carrier_on_its_tether(tmp_path: Path) -> None:
    """Towed through the water the cable holds the carrier back; the log says how much."""
    target, again = tmp_path / "tow.mcap", tmp_path / "again.mcap"
    common = ("cargo_carrier", "--manoeuvre", "straight", "--duration", "25", "--to", str(target))
    done = succeeded(simulate(tmp_path, *common, "--json"))
    tether = json.loads(done.stdout)["tether"]
    messages, _ = read(target)
    tension = np.array([m.effort for m in messages["/sim/tether/tension"]])  # type: ignore[attr-defined]
    assert list(messages["/sim/tether/tension"][0].name) == ["top", "vehicle"]  # type: ignore[attr-defined]
    assert tether["tension_at_vehicle_n"] == [tension[:, 1].min(), tension[:, 1].max()]
    wrench = messages["/sim/tether/wrench"]
    # at first the cable hangs straight down between ship and carrier: its weight pulls down
    assert wrench[0].wrench.force.z == pytest.approx(18.7, abs=1.5)  # type: ignore[attr-defined]
    assert min(m.wrench.force.x for m in wrench) < -5.0  # type: ignore[attr-defined]
    paid_out = [m.position[0] for m in messages["/sim/winch"]]  # type: ignore[attr-defined]
    assert set(paid_out) == {100.0}
    succeeded(simulate(tmp_path, "cargo_carrier", "--run", str(target), "--to", str(again)))
    assert motion(read(again)[0]).tobytes() == motion(messages).tobytes()


def test_the_winch_pays_out_and_is_braked(tmp_path: Path) -> None:
    target = tmp_path / "out.mcap"
    common = ("cargo_carrier", "--manoeuvre", "hover", "--duration", "8", "--to", str(target))
    done = succeeded(simulate(tmp_path, *common, "--winch", "0.5@2", "--winch", "0@6"))
    assert "winch at 0.5 m/s from 2 s on" in done.stdout
    assert "winch braked from 6 s on" in done.stdout
    drum = read(target)[0]["/sim/winch"]
    paid_out = np.array([m.position[0] for m in drum])  # type: ignore[attr-defined]
    speed = np.array([m.velocity[0] for m in drum])  # type: ignore[attr-defined]
    assert paid_out[99] == 100.0
    # the pull of 21 N drives the drum a little faster than the 0.5 m/s that it makes without load
    assert 0.5 < speed[250] < 0.6
    assert paid_out[-1] - 100.0 == pytest.approx(2.1, abs=0.25)
    assert speed[-1] == 0.0


def test_json_of_a_run(tmp_path: Path) -> None:
    target = tmp_path / "run.mcap"
    common = ("rov8", "--manoeuvre", "hover", "--duration", "3", "--to", str(target), "--json")
    body = json.loads(succeeded(simulate(tmp_path, *common)).stdout)
    assert body["schema"] == "rig2sea/simulate/1"
    assert body["duration_s"] == pytest.approx(3.0)
    assert body["channels"]["imu"] == 301
    assert body["depth_m"][0] == pytest.approx(1.5, abs=0.05)
    assert body["warnings"] == []


def test_a_run_that_left_the_pool_says_so(tmp_path: Path) -> None:
    target = tmp_path / "wild.mcap"
    common = ("rov8", "--manoeuvre", "prbs", "--amplitude", "5", "--to", str(target))
    done = succeeded(simulate(tmp_path, *common))
    assert "warning: the vehicle" in done.stderr
    assert "--amplitude" in done.stderr


def test_list_of_manoeuvres(tmp_path: Path) -> None:
    lines = succeeded(simulate(tmp_path, "--list")).stdout.splitlines()
    assert [line.split()[0] for line in lines] == list(MANOEUVRES)


CARRIER = ("cargo_carrier", "--manoeuvre", "hover", "--to", "run.mcap")
ROV = ("rov8", "--manoeuvre", "hover", "--to", "run.mcap")


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("rov8", "--manoeuvre", "zigzag", "--to", "x.mcap"), 2, 'Did you mean "zig_zag"?'),
        (("rov9", "--manoeuvre", "hover", "--to", "x.mcap"), 2, 'Did you mean "rov8"?'),
        (("rov8", "--to", "x.mcap"), 2, "either --manoeuvre NAME or --run LOG"),
        (("rov8", "--manoeuvre", "hover"), 2, "--to"),
        (("rov8", "--run", "none.mcap", "--to", "x.mcap"), 2, "no file none.mcap"),
        ((*ROV, "--amplitude", "nan"), 2, "--amplitude nan"),
        ((*ROV, "--amplitude", "-1"), 2, "above 0"),
        ((*ROV, "--duration", "1e9"), 2, "--duration"),
        ((*ROV, "--step", "0.5"), 2, "--step 0.5"),
        ((*ROV, "--step", "nan"), 2, "--step nan"),
        ((*ROV, "--seed", "-1"), 2, "--seed -1"),
        ((*ROV, "--release", "module_1"), 2, "MODULE@SECONDS"),
        ((*ROV, "--release", "module_1@1"), 1, "rov8 has no such module"),
        ((*ROV, "--effect", "curent:north_mps=1"), 1, 'Did you mean "current"?'),
        ((*ROV, "--effect", "current:nort_mps=1"), 1, 'Did you mean "north_mps"?'),
        ((*ROV, "--effect", "current:north_mps=nan"), 1, "is not possible"),
        ((*ROV, "--effect", "thruster_degraded:thrust_fraction=0.5"), 1, "which thruster"),
        ((*ROV, "--effect", "coriolis_omitted:fraction=0.5"), 1, "coriolis_omitted"),
        ((*ROV, "--allocator", "paper"), 1, "no allocator: section"),
        ((*ROV, "--allocator", "paper-mooring"), 1, "--allocator paper-mooring takes"),
        ((*ROV, "--winch", "0.2"), 2, "SPEED@SECONDS"),
        ((*ROV, "--winch", "0.2@5"), 1, "nominal model has no tether"),
        ((*CARRIER, "--winch", "9@5"), 1, "0.8 m/s at most"),
        ((*CARRIER, "--winch", "nan@5"), 1, "at most"),
        ((*CARRIER, "--winch", "0.1@-5"), 1, "a time from 0 on"),
    ],
)
def test_what_cannot_be_done_gets_one_message(
    tmp_path: Path, arguments: tuple[str, ...], code: int, message: str
) -> None:
    done = simulate(tmp_path, *arguments)
    assert done.returncode == code, done.stdout + done.stderr
    assert message in message_of(done)
    assert not list(tmp_path.glob("*.mcap"))


def test_an_output_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("a file", encoding="utf-8")
    common = ("rov8", "--manoeuvre", "hover", "--duration", "1", "--to", "taken/run.mcap")
    done = simulate(tmp_path, *common)
    assert done.returncode == 1
    assert "cannot be written" in message_of(done)


@pytest.mark.parametrize("content", [b"", b"no log at all", b"\x89MCAP0\r\n" + b"\0" * 40])
def test_a_log_that_is_none(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "bad.mcap").write_bytes(content)
    done = simulate(tmp_path, "rov8", "--run", "bad.mcap", "--to", "run.mcap")
    assert done.returncode == 1
    assert "bad.mcap: " in message_of(done)


def test_a_log_cut_short(tmp_path: Path) -> None:
    common = ("rov8", "--manoeuvre", "hover", "--duration", "3", "--to", "run.mcap")
    succeeded(simulate(tmp_path, *common))
    whole = (tmp_path / "run.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: len(whole) // 2])
    done = succeeded(simulate(tmp_path, "rov8", "--run", "cut.mcap", "--to", "again.mcap"))
    assert "without its closing record" in done.stderr
    assert read(tmp_path / "again.mcap")[0]["/thrusters/command"]


def test_commands_of_another_vehicle(tmp_path: Path) -> None:
    common = ("rov8", "--manoeuvre", "hover", "--duration", "1", "--to", "run.mcap")
    succeeded(simulate(tmp_path, *common))
    done = simulate(tmp_path, "cargo_carrier", "--run", "run.mcap", "--to", "again.mcap")
    assert done.returncode == 1
    assert "no commands for vertical_right" in message_of(done)


def changed_vehicle(folder: Path, source: Path, *changes: tuple[str, str]) -> None:
    """Copy a vehicle file as ``boat`` with a few texts replaced."""
    text = source.read_text(encoding="utf-8")
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    (folder / "boat").mkdir()
    (folder / "boat/vehicle.yaml").write_text(text, encoding="utf-8")


def test_bench_results_are_missing(repository: Path, tmp_path: Path) -> None:
    changed_vehicle(tmp_path, repository / "raw/mmt300/vehicle.yaml")
    done = simulate(tmp_path, "boat", "--manoeuvre", "hover", "--to", "run.mcap")
    assert done.returncode == 1
    assert "Run `rig2sea run boat` first" in message_of(done)


def test_a_thruster_inside_out_is_refused(repository: Path, tmp_path: Path) -> None:
    bow = "direction: [0.0, 0.0, -1.0]"
    source = repository / "raw/mmt300/vehicle.yaml"
    changed_vehicle(tmp_path, source, (bow, "direction: [0.0, 0.0, 1.0]"))
    done = simulate(tmp_path, "boat", "--manoeuvre", "hover", "--to", "run.mcap")
    assert done.returncode == 1
    assert "thruster bow pushes the other way" in message_of(done)


def test_a_vehicle_without_a_model(tmp_path: Path) -> None:
    source = bundled_vehicle("rov8") / "vehicle.yaml"
    text = source.read_text(encoding="utf-8")
    (tmp_path / "boat").mkdir()
    (tmp_path / "boat/vehicle.yaml").write_text(text[: text.index("\nmodel:")], encoding="utf-8")
    done = simulate(tmp_path, "boat", "--manoeuvre", "hover", "--to", "run.mcap")
    assert done.returncode == 1
    assert "has no model: section" in message_of(done)


def test_a_vehicle_without_sensors_still_flies(tmp_path: Path) -> None:
    source = bundled_vehicle("rov8") / "vehicle.yaml"
    text = source.read_text(encoding="utf-8")
    (tmp_path / "boat").mkdir()
    (tmp_path / "boat/vehicle.yaml").write_text(text[: text.index("\nsensors:")], encoding="utf-8")
    common = ("boat", "--manoeuvre", "hover", "--duration", "1", "--to", "run.mcap")
    done = succeeded(simulate(tmp_path, *common))
    assert "has no sensors: section" in done.stderr
    messages, _ = read(tmp_path / "run.mcap")
    assert set(messages) == {"/thrusters/command", "/sim/odometry", "/sim/thrusters/thrust"}


def test_effects_are_listed(tmp_path: Path) -> None:
    text = succeeded(command(tmp_path, "effects")).stdout
    for id_, effect in effects().items():
        assert f"{id_}" in text
        for parameter in effect.parameters:
            assert f"  {parameter.name}" in text


@pytest.mark.parametrize("name", NAMES[1:])
def test_effects_of_a_vehicle_say_why_not(tmp_path: Path, name: str) -> None:
    body = json.loads(succeeded(command(tmp_path, "effects", name, "--json")).stdout)
    assert body["schema"] == "rig2sea/effects/1"
    assert set(body["verdicts"]) == {"none", "unknown"}
    assert [one["id"] for one in body["effects"]] == list(effects())
    for one in body["effects"]:
        assert one["candidate"] == (one["why_not"] is None)
    by_id = {one["id"]: one for one in body["effects"]}
    assert not by_id["coriolis_omitted"]["candidate"]
    assert by_id["advance_speed_loss"]["candidate"]
    # neutral is what the vehicle file states: no inflow in the nominal model of rov8
    (inflow,) = by_id["advance_speed_loss"]["parameters"]
    assert inflow["neutral"] == (0.0 if name == "rov8" else 1.0)
    assert by_id["current"]["parameters"][0]["unit"] == "m/s"
    text = succeeded(command(tmp_path, "effects", name)).stdout
    assert "no candidate: " in text
