"""Measured runs to diagnose, and what is done to them that the diagnosis is not told.

Nothing is done to the vehicle: it was flown once, by others. A measurement effect is put into the
readings of the velocity. An effect of the vehicle is put, the other way round, into the *model*:
where the model has a thruster that is stronger than the identified one, the vehicle as it was
measured looks as if that thruster were weak. Healthy runs would show the same against that model,
so these cases have none. A weak thruster is therefore made in a second way as well, in the log:
its codes are raised until the model's thrust for them is what acted over the weakness.
"""

from dataclasses import dataclass, field

#: How strong the thruster is, by the model that was altered, that looks weak. [1]
WEAK = 0.6


@dataclass(frozen=True)
class Fold:
    """Which runs take part in what; names are the beginnings of the logs' names.

    The nominal model is identified from `fit`, and no run of `fit` is diagnosed or called healthy.
    """

    name: str
    fit: tuple[str, ...]
    runs: tuple[str, ...]
    healthy: tuple[str, ...]


@dataclass(frozen=True)
class Injection:
    """What is withheld.

    `truth` is the effect that the diagnosis should name (None: nothing was injected), `target` its
    thruster, `value` what its parameters should come out as. `scale` and `delay_s` alter the
    measured velocity, `raised` is the thruster whose codes are raised; `model` are effects that the
    model gets, `lighter_kg` is taken off its mass.
    """

    name: str
    truth: str | None = None
    target: str | None = None
    value: dict[str, float] = field(default_factory=dict)
    scale: float = 1.0
    delay_s: float = 0.0
    raised: str | None = None
    model: tuple[str, ...] = ()
    lighter_kg: float = 0.0

    @property
    def in_the_model(self) -> bool:
        """Tell whether the model is altered: then no run can be called healthy."""
        return bool(self.model) or self.lighter_kg > 0.0


@dataclass(frozen=True)
class WithheldCase:
    """One diagnosis: a vehicle, its runs, what was injected, with or without healthy runs.

    `hidden` are quantities that the diagnosis does not get, `most_s` ends the runs early.
    """

    subject: str
    fold: Fold
    injection: Injection
    healthy: bool
    hidden: tuple[str, ...] = ()
    most_s: float | None = None

    @property
    def key(self) -> str:
        """Name of the case, which the result file knows it by."""
        parts = [self.subject, self.fold.name, self.injection.name]
        parts += [f"without {', '.join(self.hidden)}"] if self.hidden else []
        parts += [f"first {self.most_s:g} s"] if self.most_s is not None else []
        return " / ".join([*parts, "healthy runs" if self.healthy else "no healthy runs"])


AS_IT_IS = Injection("as it is")


def overstated(name: str) -> Injection:
    """Let a thruster look weak: the log has more code than what acted."""
    return Injection(
        f"{name} weak (log)", "thruster_degraded", name, {"thrust_fraction": WEAK}, raised=name
    )


def weak_thruster(name: str) -> Injection:
    """Let a thruster look weak: the model has it stronger."""
    return Injection(
        f"{name} weak (model)",
        "thruster_degraded",
        name,
        {"thrust_fraction": WEAK},
        model=(f"thruster_degraded:thrust_fraction={1.0 / WEAK!r}@{name}",),
    )


def buoyant(force_n: float) -> Injection:
    """Let the vehicle look lighter in water by a force: the model is heavier by it."""
    return Injection(
        f"buoyancy {force_n:+g} N",
        "residual_buoyancy",
        None,
        {"force_n": force_n},
        model=(f"residual_buoyancy:force_n={-force_n!r}",),
    )


def shifted(name: str, by_m: float) -> Injection:
    """Let the centre of gravity look shifted along an axis."""
    return Injection(
        f"centre of gravity {name[1]} {100 * by_m:+g} cm",
        "cg_shift",
        None,
        {name: by_m},
        model=(f"cg_shift:{name}={-by_m!r}",),
    )


def loaded(mass_kg: float) -> Injection:
    """Let the vehicle look loaded with lead at its centre: the model lacks that mass."""
    return Injection(
        f"load {mass_kg:g} kg", "payload", None, {"mass_kg": mass_kg}, lighter_kg=mass_kg
    )


def read_wrong(scale: float = 1.0, delay_s: float = 0.0) -> Injection:
    """Scale or delay the measured velocity."""
    if delay_s > 0.0:
        name = f"velocity {delay_s:g} s late"
        return Injection(name, "dvl_delay", None, {"delay_s": delay_s}, delay_s=delay_s)
    return Injection(f"velocity x {scale:g}", "dvl_scale", None, {"scale": scale}, scale=scale)


_T1, _T2, _T3, _T4 = (f"rosbag2_2025_05_27-{t}" for t in ("11_10", "11_46", "12_04", "12_09"))
#: One model for both: the runs that it is identified from hold all six axes between them.
TANK = (
    Fold("12_09", fit=(_T1, _T2), runs=(_T4,), healthy=(_T3,)),
    Fold("12_04", fit=(_T1, _T2), runs=(_T3,), healthy=(_T4,)),
)
_SINES = ("sinPhi", "sinQ", "sinPsi", "sinDepth")
_ALL, _STEPS = ("stepAllAttitude", "stepR", "sinAll"), ("stepPsi", "stepDepth")
POOL = (
    Fold("all axes", fit=_SINES, runs=_ALL, healthy=_STEPS),
    Fold("single steps", fit=_SINES, runs=_STEPS, healthy=_ALL),
)
FOLDS = {"tank": TANK, "pool": POOL}

_INJECTED = {
    "tank": (
        read_wrong(1.1),
        read_wrong(0.9),
        read_wrong(delay_s=0.15),
        read_wrong(delay_s=0.3),
        overstated("front_right"),
        overstated("vertical_rear_left"),
        weak_thruster("front_right"),
        weak_thruster("vertical_rear_left"),
        buoyant(10.0),
        loaded(1.5),
        shifted("dx_m", 0.03),
    ),
    "pool": (
        overstated("surge_left"),
        overstated("vertical_front_left"),
        overstated("vertical_rear"),
        weak_thruster("surge_left"),
        weak_thruster("vertical_front_left"),
        weak_thruster("vertical_rear"),
        buoyant(8.0),
        loaded(0.8),
        shifted("dx_m", 0.02),
        shifted("dy_m", 0.02),
    ),
}


def all_cases() -> tuple[WithheldCase, ...]:
    """Return every case in the order in which they are run."""
    found: list[WithheldCase] = []
    for subject, folds in FOLDS.items():
        both = (False, True)
        found += [WithheldCase(subject, fold, AS_IT_IS, h) for fold in folds for h in both]
        for healthy in both:
            found += [
                WithheldCase(subject, folds[0], one, healthy)
                for one in _INJECTED[subject]
                if not (healthy and one.in_the_model)
            ]
        if subject == "tank":
            late, weak, tank = read_wrong(delay_s=0.3), overstated("front_right"), folds[0]
            found += [
                WithheldCase("tank", tank, late, False, ("position",)),
                WithheldCase("tank", tank, weak, False, ("velocity",)),
                WithheldCase("tank", tank, weak, False, ("velocity", "position")),
                WithheldCase("tank", tank, AS_IT_IS, False, most_s=20.0),
                WithheldCase("tank", tank, AS_IT_IS, False, ("command",)),
            ]
    found += [
        WithheldCase("pool", POOL[0], overstated("surge_left"), False, ("attitude",)),
        WithheldCase("pool", POOL[0], overstated("vertical_rear"), False, ("depth",)),
    ]
    return tuple(found)
