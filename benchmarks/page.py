"""The figures as text, and as plots of growth."""

from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes

mpl.use("Agg")
import matplotlib.pyplot as plt

Figures = dict[str, Any]
_METHOD = {"semi_implicit": "semi-implicit", "rk4": "RK4"}
BEGIN, END = "<!-- figures: begin -->", "<!-- figures: end -->"
COLOURS = {"kernel": "#1f5a96", "C -O3": "#b5541c", "C -O3 -march=native": "#8a8a8a"}


def table(head: list[str], rows: list[list[str]]) -> str:
    """Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _or_dash(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)


def text(figures: Figures) -> str:
    """Everything that was measured, as Markdown."""
    parts = [_conditions(figures), _single(figures), _methods(figures), _threads(figures)]
    parts += [_first(figures), _sensitivity(figures)]
    if figures["segments"]:
        parts.append(_segments(figures))
    return "\n\n".join(parts)


def _conditions(figures: Figures) -> str:
    said = "; ".join(f"{name} {value}" for name, value in figures["conditions"].items())
    kind = " (--quick: few rounds, do not quote)" if figures["quick"] else ""
    return f"Measured with {said}{kind}."


def _single(figures: Figures) -> str:
    """Render one trajectory, beside its peers."""
    native = "C -O3 -march=native"
    rows = []
    for row in figures["single"]:
        us, of_c = row["us_per_step"], row["of_c"]
        rows.append(
            [
                row["case"],
                _METHOD[row["method"]],
                f"{us['numpy']:.0f}",
                f"{us['kernel']:.3f} ({row['best_us_per_step']['kernel']:.3f})",
                _or_dash(us.get("C -O3"), ".3f"),
                _or_dash(us.get(native), ".3f"),
                f"{row['over_numpy']:.0f} x",
                _or_dash(of_c.get("C -O3"), ".2f"),
                _or_dash(of_c.get(native), ".2f"),
            ]
        )
    head = [
        *("model", "method", "NumPy", "kernel (best)", "C", "C native"),
        *("over NumPy", "of C's speed", "of C native's"),
    ]
    return (
        "**One trajectory**, five thrusters, dt = 0.02 s, microseconds of processor time a step "
        "(medians):\n\n" + table(head, rows)
    )


def _methods(figures: Figures) -> str:
    """Render the price of the fourth order."""
    pairs: dict[str, dict[str, float]] = {}
    for row in figures["single"]:
        pairs.setdefault(row["case"], {})[row["method"]] = row["us_per_step"]["kernel"]
    said = ", ".join(
        f"{pair['rk4'] / pair['semi_implicit']:.1f} x ({case})" for case, pair in pairs.items()
    )
    return f"**RK4 over semi-implicit**, the kernel's time a step: {said}."


def _threads(figures: Figures) -> str:
    said = "; ".join(
        f"{_METHOD[row['method']]} {row['one_ms']:.0f} ms on one thread, {row['two_ms']:.0f} ms on "
        f"two: {row['speed_up']:.2f} x (best rounds {row['best_speed_up']:.2f} x; processor time "
        f"of both threads {row['processor_time_ratio']:.2f} of the one thread's)"
        for row in figures["two_cores"]
    )
    runs = figures["two_cores"][0]["runs"]
    return f"**Two cores**, {runs} runs of 2000 steps, every effect on: {said}."


def _first(figures: Figures) -> str:
    calls = figures["first_call"]
    cold, warm, best = calls["compiling"], calls["from_cache"], calls["from_cache_best"]
    return (
        f"**First call** of a new process, import and first run: {warm['both_s']:.2f} s from the "
        f"cache ({warm['import_s']:.2f} s of it importing, {warm['first_run_s']:.2f} s the run "
        f"that loads the code; {best['both_s']:.2f} s in the best round), {cold['both_s']:.1f} s "
        f"when it is compiled; in processor time of "
        f"the whole process {warm['processor_s']:.2f} s and {cold['processor_s']:.1f} s."
    )


def _sensitivity(figures: Figures) -> str:
    s = figures["sensitivity"]
    return (
        f"**Sensitivity**, every effect on, {s['steps']} steps, semi-implicit, two threads: "
        f"{s['runs']} runs with perturbed parameters {s['runs_ms']:.0f} ms; the Jacobian of one "
        f"run by {s['parameters']} parameters {s['jacobian_ms']:.0f} ms; the Jacobians of all "
        f"{s['runs']} runs {s['all_jacobians_s']:.1f} s. Largest relative error against complex "
        f"steps {s['largest_error']:.1e} ({s['worst']}), median {s['median_error']:.1e}."
    )


def _segments(figures: Figures) -> str:
    rows = figures["segments"]
    lines = [
        [
            str(row["segments"]),
            f"{row['substeps']:.1f}",
            f"{row['us_per_step']:.1f}",
            f"{row['us_per_substep']:.2f}",
        ]
        for row in rows
    ]
    first, last = rows[0], rows[-1]
    each = (last["us_per_substep"] - first["us_per_substep"]) / (
        last["segments"] - first["segments"]
    )
    return (
        "**Lumped tether** of 40 m at the vehicle (RK4; the cable's axial waves set the "
        f"sub-steps): {each:.3f} us a segment and sub-step, on top of the vehicle's own "
        f"{rows[0]['free_us_per_step']:.2f} us a step without a tether.\n\n"
        + table(["segments", "sub-steps a step", "us a step", "us a sub-step"], lines)
    )


def plots(figures: Figures, folder: Path) -> list[Path]:
    """Draw the plots of growth; returns the files."""
    folder.mkdir(parents=True, exist_ok=True)
    written = [_plot_thrusters(figures, folder), _plot_trajectories(figures, folder)]
    if figures["segments"]:
        written.append(_plot_segments(figures, folder))
    return written


def _finish(axes: Axes, path: Path) -> Path:
    if axes.get_yscale() == "linear":
        axes.set_ylim(bottom=0.0)
    axes.grid(alpha=0.3)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False)
    figure = axes.get_figure(root=True)
    if figure is not None:
        figure.savefig(path, dpi=130)
        plt.close(figure)
    return path


def _plot_thrusters(figures: Figures, folder: Path) -> Path:
    rows = figures["thrusters"]
    count = [row["thrusters"] for row in rows]
    _, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
    for method, style in (("semi_implicit", "-"), ("rk4", "--")):
        for name, colour in COLOURS.items():
            if name in rows[0][method]:
                times = [row[method][name] for row in rows]
                label = f"{name}, {_METHOD[method]}"
                axes.plot(count, times, style, color=colour, marker="o", ms=3, label=label)
    axes.set(xlabel="thrusters", ylabel="time of a step [us]", title="Every effect on")
    return _finish(axes, folder / "benchmark_thrusters.png")


def _plot_trajectories(figures: Figures, folder: Path) -> Path:
    rows = figures["trajectories"]
    count = [row["runs"] for row in rows]
    _, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
    for threads, colour in ((1, COLOURS["kernel"]), (2, COLOURS["C -O3"])):
        times = [row[f"threads_{threads}_ms"] for row in rows]
        label = f"{threads} thread{'s' if threads > 1 else ''}"
        axes.plot(count, times, color=colour, marker="o", ms=3, label=label)
    title = "Runs of 2000 steps, semi-implicit, every effect on"
    axes.set(xlabel="runs", ylabel="time of all [ms]", title=title)
    axes.set(xscale="log", yscale="log", xticks=count, xticklabels=[str(c) for c in count])
    axes.minorticks_off()
    return _finish(axes, folder / "benchmark_trajectories.png")


def _plot_segments(figures: Figures, folder: Path) -> Path:
    rows = figures["segments"]
    count = [row["segments"] for row in rows]
    _, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
    times = [row["us_per_substep"] for row in rows]
    axes.plot(count, times, color=COLOURS["kernel"], marker="o", ms=3, label="a sub-step (RK4)")
    free = rows[0]["free_us_per_step"]
    axes.axhline(free, color=COLOURS["C -O3"], ls="--", label="a step without a tether (RK4)")
    title = "Vehicle and lumped tether"
    axes.set(xlabel="segments", ylabel="time [us]", title=title)
    return _finish(axes, folder / "benchmark_segments.png")


def update(path: Path, begin: str, end: str, text: str) -> None:
    """Put a text between its marks in a page.

    Raises
    ------
    ValueError
        Where the page has not each mark once, in their order; it is left as it was.
    """
    page = path.read_text(encoding="utf-8")
    before, _, rest = page.partition(begin)
    _, _, after = rest.partition(end)
    if page.count(begin) != 1 or page.count(end) != 1 or end not in rest:
        raise ValueError(f'{path}: expected "{begin}", then "{end}", each once')
    path.write_text(f"{before}{begin}\n{text}\n{end}{after}", encoding="utf-8")
