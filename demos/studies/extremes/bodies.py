# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies, their motions and captures at the extremes: what converges, degrades, or is refused.

    python -m demos.studies.extremes.bodies           a minute or two
    python -m demos.studies.extremes.bodies --every   each value tried on its own line

prints a table in Markdown, one line a direction, and leaves every row (direction, value, verdict,
figure) in out/extremes_of_bodies/summary.json. `converges` is said where momentum closes to
roundoff, no point ends inside, contact with a body at rest adds no energy, and closed forms are
met; `degrades` names what is lost; `refused` gives the sentence a user reads.
"""

import numpy as np

from contact.body.segments import Body, Fixed, Segment, Steady
from contact.solver.velocity_correction import VelocityCorrection
from demos.studies.extremes import captures
from demos.studies.extremes.body_cases import (
    CLOTH,
    closing,
    cloth_on,
    impact,
    incline,
    jump,
    moving,
    over_rod,
    patch,
    points_on,
    row_of_spheres,
    slender,
)
from demos.studies.extremes.table import arguments, tell
from shellform.console import run
from shellform.errors import NotConverged, Unstable

ROUNDOFF = 1e-10  # of a momentum over that of the run, in thousands of steps
QUIET = 1e-3  # J: the patch of 2 g would move at 1 m/s
REFUSALS = (ValueError, FloatingPointError, NotConverged, Unstable)
BALL = [0.1] * 3


def row(direction, value, measure):
    """One row of strings; `measure` returns verdict and figure, or refuses."""
    try:
        verdict, figure = measure()
    except REFUSALS as refusal:
        verdict, figure = f"refused: {refusal}", "-"
    return direction, value, verdict, figure


def closed(out, still=True):
    """Verdict on points or cloth that met a body, `still` if it is at rest."""
    figure = f"momentum {out['momentum']:.0e}, inside {out['inside']:.0e} m"
    if still:
        figure += f", energy {out['growth']:+.0e}"
    good = out["momentum"] < ROUNDOFF and out["inside"] < 1e-9
    good = good and (not still or out["growth"] < 1e-9)
    return ("converges" if good else "degrades: balances do not close"), figure


def speeds():
    for speed in (1.0, 30.0, 300.0):
        for name, dt in (("explicit", None), ("implicit", 1e-4)):
            yield row(
                "impact speed", f"{speed:g} m/s, {name}", lambda s=speed, d=dt: closed(impact(s, d))
            )


def frictions():
    def slides(friction, slope):
        slip, exact = incline(friction, slope)
        good = abs(slip - exact) <= (0.03 * exact if exact else 0.0)
        return (
            "converges" if good else "degrades: wrong slip"
        ), f"slip {slip:.4g} m, exact {exact:.4g} m"

    for friction, slope in ((0.0, 1.0), (10.0, 5.0), (10.0, 20.0), (1000.0, 20.0)):
        yield row(
            "friction", f"{friction:g}, slope {slope:g}", lambda f=friction, s=slope: slides(f, s)
        )


def shapes():
    for aspect in (1.0, 1e3, 1e6, 1e10):
        yield row("aspect of an ellipsoid", f"{aspect:g}", lambda a=aspect: closed(slender(a)))
    for radius, samples in ((0.003, 0), (0.003, 6), (0.01, 0), (0.01, 2), (0.025, 0)):

        def caught(r=radius, k=samples):
            out = over_rod(r, k)
            return ("converges", "held") if out["caught"] else ("degrades: passes", "none")

        name = f"{1e3 * radius:g} mm under cells of 40 mm, samples={samples}"
        yield row("semi-axis below the cell", name, caught)
    for count in (1, 62, 200):

        def each(m=count):
            out = row_of_spheres(m)
            verdict, figure = closed(out)
            return verdict, f"{out['own']} of {m} meet their node, {figure}"

        yield row("number of ellipsoids", f"{count}", each)


def motions():
    def carried(motion, dt, steps, fastest, turn=0.0, **options):
        out = moving(motion, dt, steps, **options)
        verdict, figure = closed(out, still=False)
        if not 0 < out["fastest"] < fastest * (1 + 1e-9):
            verdict = "degrades: faster than the body, or not met"
        if turn > np.pi:
            verdict = "degrades: of a turn a step only what is over whole turns is seen"
        return verdict, f"{figure}, fastest {out['fastest']:.4g} m/s"

    for dt in (1e-5, 1e-3):
        ahead = Steady((-0.3, 0.0, 0.0), velocity=(50.0, 0.0, 0.0))
        yield row(
            "body at 50 m/s",
            f"step {dt:g} s",
            lambda m=ahead, d=dt: carried(m, d, round(0.012 / d), 100.0, friction=0.0),
        )
    for spin in (10.0, 1e3, 1e5):
        turning = Steady((0.0, 0.0, 0.0), spin=(0.0, spin, 0.0))
        away = np.array([[0.1, 0.0, -0.1], [0.1, 0.02, -0.12]])
        yield row(
            "spinning ellipsoid",
            f"{spin:g} rad/s, {1e-4 * spin:g} rad a step",
            lambda m=turning, s=spin: carried(
                m,
                1e-4,
                round(max(20, 2e4 / s)),
                0.4 * s,
                1e-4 * s,
                radii=(0.2, 0.05, 0.05),
                x=away.copy(),
                friction=0.0,
            ),
        )
    for size in (0.001, 0.05, 0.5):

        def jumps(d=size, dt=None):
            body = Body([Segment("ball", [0.25] * 3, jump(d, 0.02))])
            out = cloth_on(patch(dt=dt), body, 0.05)
            verdict, figure = closed(out, still=False)
            gained = out["row"]["kinetic"] + out["row"]["strain"]
            if gained > QUIET:
                verdict = "degrades: the step's jump becomes speed of the cloth"
            return verdict, f"{figure}, energy {gained:.2g} J"

        yield row("body that jumps in a step", f"{size:g} m, explicit", jumps)
        yield row(
            "body that jumps in a step", f"{size:g} m, implicit", lambda d=size: jumps(d, 1e-3)
        )


def starts():
    def from_inside(z, seconds):
        body = Body([Segment("ball", [0.25] * 3, Fixed((0.0, 0.0, -0.25)))])
        out = cloth_on(patch(side=0.2, height=z), body, seconds)
        verdict, _ = closed(out, still=False)
        strain = out["row"]["strain"]
        if strain > 0.1:
            verdict = "degrades: cloth in a body is stretched around it"
        return verdict, f"inside {out['inside']:.0e} m, strain energy {strain:.2g} J"

    for z in (0.5 * CLOTH["thickness"], -0.02, -0.25):
        name = f"{-1e3 * z:g} mm below the skin" if z < 0 else "exactly on the surface"
        yield row("cloth starts inside", name, lambda z=z: from_inside(z, 0.5))

    def centre():
        body = Body([Segment("ball", BALL, Fixed())])
        out = points_on(body, np.zeros((1, 3)), np.zeros((1, 3)), 1e-3, 1100)
        return closed(out, still=False)

    yield row("point at the centre", "no normal there", centre)
    for overlap in (0.004, 0.02, 0.05):
        for name, flesh in (("hard", None), ("soft, 2e5 Pa/m", 2e5)):

            def pinched(a=overlap, k=flesh):
                out = closing(a, k)
                energy = out["row"]["kinetic"] + out["row"]["strain"]
                work = abs(out["row"]["energy_residual"])
                quiet = energy < QUIET
                return (
                    "converges" if quiet else "degrades: hard bodies tear what is between them"
                ), f"energy left {energy:.1e} J, not accounted for {work:.1e} J"

            yield row("bodies that close over cloth", f"{1e3 * overlap:g} mm, {name}", pinched)


def numbers():
    body = Body([Segment("ball", BALL, Fixed())])

    def one(x=0.1001, v=-1.0, mass=None, dt=1e-3, **options):
        v, masses = np.array([[0.0, 0.0, v]]), np.array([1.0 if mass is None else mass])
        correction = VelocityCorrection(body, 1, **options)
        correction(np.array([[0.0, 0.0, x]]), v, masses, dt, 0.0)
        if not (np.isfinite(v).all() and np.isfinite(correction.last.impulse).all()):
            return "degrades: not a number, untold", "-"
        return "converges", f"velocity {v[0, 2]:.3g} m/s after"

    nan = float("nan")
    for name, given in (
        ("position NaN", {"x": nan}),
        ("velocity infinite", {"v": -np.inf}),
        ("mass NaN", {"mass": nan}),
        ("step of 1e-300 s", {"dt": 1e-300}),
        ("step of 1e10 s", {"dt": 1e10}),
        ("step NaN", {"dt": nan}),
        ("offset 0, on the surface", {"x": 0.1, "offset": 0.0}),
    ):
        yield row("numbers", name, lambda g=given: one(**g))


def rows():
    """Rows (direction, value, verdict, figure) of this table and that of captures."""
    out = []
    for part in (speeds, frictions, shapes, motions, starts, numbers, captures.rows):
        out += part()
    return out


def main(given=None):
    options = arguments("extremes_of_bodies", given)
    tell(rows(), options)


if __name__ == "__main__":
    run(main)
