# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tables and pictures of the drape studies; only rank 0 prints, writes and draws."""

from mpi4py import MPI

import numpy as np

from demos.studies.drape.square import CENTRE, RADIUS, RIM
from shellform.pictures.surfaces import (
    BACK,
    CLOTH,
    draw_surfaces,
    ellipsoid_facets,
    facets_and_sides,
    new_figure,
    save_figure,
)
from shellform.results.files import write_atomically

FIRST = MPI.COMM_WORLD.rank == 0
UNITS = {
    "height": "mean height [m]",
    "corner_z": "free corner, height [m]",
    "force_up": "contact force up [N]",
    "strain": "strain energy [J]",
    "depth": "depth of the folds at the hem [m]",
    "hem": "width of the hem [m]",
    "side": "force aside [N]",
    "membrane_energy": "membrane energy [J]",
}
COST = ["steps", "dt", "us", "seconds"]
FORMATS = {"seconds": ".1f", "us": ".2f", "dt": ".2e", "kinetic": ".1e", "gained": ".1e"}
COLOURS = ("#1f5a7a", "#b5533c", "#5a8f3c", "#8a6bb0", "#c79a2b")


def text(key, value):
    """A cell of a table."""
    if value is None or (isinstance(value, float) and np.isnan(value)):
        return "-"
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, (float, np.floating)):
        if key in FORMATS:
            return format(value, FORMATS[key])
        return f"{value:.4f}" if 0.05 <= abs(value) < 1e3 else f"{value:.4g}"
    return str(value)


def print_table(title, rows, columns):
    """Print rows of dicts, right-aligned; absent entries are blank."""
    if not FIRST:
        return
    cells = [[text(c, row[c]) if c in row else "" for c in columns] for row in rows]
    widths = [max(len(c), *(len(line[i]) for line in cells)) for i, c in enumerate(columns)]
    print(f"\n{title}")
    for line in (columns, *cells):
        print("  ".join(word.rjust(w) for word, w in zip(line, widths, strict=True)).rstrip())


def write_table(path, rows):
    """Write the numbers of rows of dicts as CSV; columns in the order they are first met."""
    if not FIRST:
        return
    columns = list(dict.fromkeys(k for row in rows for k, v in row.items() if np.ndim(v) == 0))
    lines = [",".join(columns)]
    for row in rows:
        lines.append(",".join(str(row.get(c, "")).replace(",", ";") for c in columns))
    write_atomically(path, "\n".join(lines) + "\n")


def draw_refinement(path, rows, steps, keys):
    """Quantities over the cell size with the range over starts, and with smaller time steps."""
    if not FIRST:
        return
    figure, axes = new_figure(1, (4 * len(keys), 3.6), "Pinned drape at rest", columns=len(keys))
    h = np.array([1 / row["cells"] for row in rows])
    for ax, key in zip(axes, keys, strict=True):
        spread = np.nan_to_num([row[f"{key}_spread"] for row in rows])
        ax.errorbar(h, [row[key] for row in rows], spread, fmt="o-", color=COLOURS[0], capsize=3)
        for factor, mark in ((0.45, "v"), (0.225, "s")):
            these = [row for row in steps if row["factor"] == factor]
            at = [1 / row["cells"] for row in these]
            values = [row[key] for row in these]
            ax.plot(
                at, values, mark, color=COLOURS[1], mfc="none", label=f"step x {factor / 0.9:g}"
            )
        ax.set_xlabel("cell size [m]")
        ax.set_title(UNITS[key], fontsize=10)
        ax.set_xlim(0, None)
    axes[0].legend(fontsize=8, title="bars: range over starts", title_fontsize=8)
    save_figure(figure, path)


def draw_starts(path, rows, cells):
    """Heights of the rim for every start, a panel a mesh, pinned above and free below."""
    if not FIRST:
        return
    title = "Heights along the rim, one line a start"
    figure, axes = new_figure(2, (4.2 * len(cells), 6), title, columns=len(cells), dpi=110)
    for line, pinned in zip(np.reshape(axes, (2, -1)), (True, False), strict=True):
        for ax, n in zip(line, cells, strict=True):
            for row in rows:
                if row["cells"] == n and row["pinned"] == pinned:
                    z = np.append(row["rim"][:, 2], row["rim"][0, 2])
                    label = f"state {row['state']}, {row['folds']} folds"
                    ax.plot(np.arange(RIM + 1) * 4 / RIM, z, lw=1, label=label)
            ax.set_title(f"{'pinned' if pinned else 'free'}, {n} cells", fontsize=10)
            low, high = ax.get_ylim()
            ax.set_ylim(low, high + 0.35 * (high - low))
            ax.legend(fontsize=7, loc="upper center", ncol=2)
            ax.set_xticks(range(5))
    for ax in axes.ravel():
        ax.set_xlabel("sides from corner 0", fontsize=8)
        ax.set_ylabel("z [m]", fontsize=8)
    save_figure(figure, path)


def draw_membrane(path, rows, exact):
    """Errors over cells, and the reference beside the finest sheets of both membranes."""
    if not FIRST:
        return
    shown = ["height", "force_up" if "rim" in exact else "side", "strain"]
    figure, axes = new_figure(2, (13, 8), "", columns=3, height_ratios=(2, 3))
    for ax, key in zip(axes[0], shown, strict=True):
        for k, kind in enumerate(("arcs", "chords")):
            for distortion, style in ((0.0, "o-"), (0.25, "s--")):
                these = [r for r in rows if r["membrane"] == kind and r["distortion"] == distortion]
                label = kind + (", distorted" if distortion else "")
                error = [max(abs(r[key] - exact[key]), 1e-9) for r in these]
                ax.loglog([r["cells"] for r in these], error, style, color=COLOURS[k], label=label)
        ax.set_title(f"error of {UNITS[key]}", fontsize=10)
        ax.set_xlabel("cells along a side")
        ticks = sorted({r["cells"] for r in rows})
        ax.set_xticks(ticks, [str(n) for n in ticks])
        ax.minorticks_off()
        ax.grid(alpha=0.3)
    axes[0][0].legend(fontsize=8)
    middle = ticks[min(1, len(ticks) - 1)]
    pick = {r["membrane"]: r for r in rows if r["cells"] == middle and r["distortion"] == 0.25}
    draped = "rim" in exact
    panels = (("reference", exact), ("arcs", pick["arcs"]), ("chords", pick["chords"]))
    for ax, (name, run) in zip(axes[1], panels, strict=True):
        draw_cloth(ax, run, (-60, 20) if draped else (-75, 25), draped)
        kind = "distorted" if run["distortion"] else "regular"
        title = f"{name}, {run['cells']} {kind} cells, strain energy {run['strain']:.2e} J"
        ax.set_title(title, fontsize=10)
    save_figure(figure, path)


def draw_methods(path, rows):
    """The draped sheet by each method, its figures below."""
    if not FIRST:
        return
    figure, axes = new_figure(1, (5 * len(rows), 5), "", columns=len(rows))
    for ax, run in zip(np.atleast_1d(axes), rows, strict=True):
        draw_cloth(ax, run, (-60, 12), True)
        facts = [f"mean height {run['height']:.4f} m", f"contact {run['force_up']:.3f} N up"]
        facts += [f"strain energy {1e3 * run['strain']:.1f} mJ", f"{run['folds']} folds"]
        facts += [f"{run['seconds']:.1f} s of processor time"]
        ax.set_title(f"{run['method']}, {run['cells']} cells\n", fontsize=12)
        ax.text(0.5, -0.02, "\n".join(facts), transform=ax.transAxes, ha="center", va="top")
    save_figure(figure, path)


def draw_cloth(axes, run, view, body):
    """A sheet, and the sphere under it if there is one."""
    cloth = facets_and_sides(run["positions"], run["directors"], run["quads"])
    surfaces = [(*cloth, CLOTH, BACK, 0.0)]
    if body:
        away = 0.5 / np.sqrt(len(run["quads"]))
        skin = ellipsoid_facets(CENTRE, np.eye(3), [RADIUS] * 3)
        surfaces.append((skin, None, "#d8a48f", "#d8a48f", away))
    draw_surfaces(axes, surfaces, *view)
