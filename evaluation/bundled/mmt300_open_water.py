"""The two open-water files of `mmt300`, from the polynomials of Table 1."""

from evaluation.bundled.mmt300_truth import KM, KT
from evaluation.bundled.noise import Noise
from pipeline.physics.propeller import polynomial

#: Standard deviation of a coefficient, as a share of its value at J = 0.
NOISE_SHARE = 0.004


def points(advance_ratios: list[float], noise: Noise) -> list[tuple[float, float, float]]:
    """J, K_T and K_M with noise."""
    return [
        (
            ratio,
            float(polynomial(ratio, KT)) + noise.normal(NOISE_SHARE * KT[0]),
            float(polynomial(ratio, KM)) + noise.normal(NOISE_SHARE * KM[0]),
        )
        for ratio in advance_ratios
    ]


def open_water_files() -> dict[str, bytes]:
    """File name -> contents of both files."""
    return {"screw-01.csv": _russian(), "screw-02.csv": _english()}


def _russian() -> bytes:
    """J, K_T, K_M; semicolons, decimal commas, Russian names, CRLF, UTF-8 with mark."""
    lines = [
        "# Кривые действия гребного винта маршевого движителя",
        "# D = 0,14 м; H/D = 0,60; A/Ad = 0,26; Z = 3",
        "Относительная поступь;Коэффициент упора;Коэффициент момента",
    ]
    ratios = [round(0.03 * step, 2) for step in range(27)]
    lines += [
        ";".join(f"{value:.5f}".replace(".", ",") for value in row)
        for row in points(ratios, Noise("mmt300 open water 01"))
    ]
    return ("\ufeff" + "\r\n".join(lines) + "\r\n").encode("utf-8")


def _english() -> bytes:
    """J, KT, 10KQ; commas, decimal points, comment lines."""
    lines = [
        "# propeller open-water test, stern thruster screw",
        "# diameter 0.14 m, pitch ratio 0.60, area ratio 0.26, 3 blades",
        "# 10KQ: torque coefficient times ten",
        "J,KT,10KQ",
    ]
    ratios = [round(0.02 + 0.035 * step, 3) for step in range(23)]
    lines += [
        f"{ratio:.3f},{k_t:.4f},{10 * k_m:.4f}"
        for ratio, k_t, k_m in points(ratios, Noise("mmt300 open water 02"))
    ]
    return ("\n".join(lines) + "\n").encode("utf-8")
