/* SPDX-License-Identifier: LGPL-3.0-or-later

Stress in the middle of cells beyond the quadratic energy: measured curves, friction inside the
cloth. Eq. 14 of the paper.

Of a cell with segments and lines (cell_stress.py says which) whose measures less those at rest are
s and t, the strains along warp and weft are

    E = B s = (E11, E22, 2 E12),    K = C t = (K11, K22, 2 K12)

and the forces are those of area N(E) and area M(K).

Curves (material/measured.py): N and M are what the curve's energy gives less the quadratic one.
Friction (material/friction.py): in each strain several springs k, each in series with a slider that
yields at Y; state is the slip p of each slider,

    stress = clip(k (e - p), -Y, Y),    Y = m + g |e|,    p = e - stress/k.

A slip that began at the strain a, where k |a - p| = Y, and goes on to e loses the integral of Y over
the slip: that of a trapezoid, or of two, of a to 0 and 0 to e, where the strain has changed its
sign. That is exact however long the step, if strains go one way in it. */

#include "segments.h"
#include <math.h>

#if NODES == 4
enum { SEGMENTS = 6, LINES = 4 };
#else
enum { SEGMENTS = 3, LINES = 3 };
#endif
enum { STRAINS = 3, CURVES = 6 };
/* numbers of a cell, in this order; areas: of the membrane, of bending */
enum { B = STRAINS * SEGMENTS, C = STRAINS * LINES, AREAS = 2 };
enum { WIDTH = B + SEGMENTS + C + LINES + AREAS };

/* what the sheet stores and has lost in friction [J] */
struct sums { double stored, lost; };

int lanes(void) { return W; }

/* ------------------------------------------------------------------ curves */

/* A table of numbers: count of points, 1 if mirrored, slope at rest, steepest slope, then the points
   and the coefficients of what is stored, five a piece, see curve.py. */
struct curve { const double *x, *pieces; double rest, steepest; int count, mirrored; };

static const double *read(const double *table, struct curve *curve)
{
    int count = (int)table[0];
    *curve = (struct curve){table + 4, table + 4 + count, table[2], table[3], count, table[1] > 0.0};
    return table + 4 + 6 * count;
}

/* load at x */
static double loaded(const struct curve *curve, double x)
{
    double u = x < 0.0 ? -x : x;
    if (x < 0.0 && !curve->mirrored) return curve->rest * x;
    int k = 0;
    while (k + 1 < curve->count && u >= curve->x[k + 1]) k++;
    const double *c = curve->pieces + 5 * k;
    u -= curve->x[k];
    double load = c[1] + u * (2.0 * c[2] + u * (3.0 * c[3] + u * 4.0 * c[4]));
    return x < 0.0 ? -load : load;
}

/* The same of W cells; in a straightened law the line of the steepest slope about `about`. */
INLINE vector loads(const struct curve *curve, vector x, const vector *about)
{
    vector y;
    if (about) {
        for (int l = 0; l < W; l++) y[l] = loaded(curve, (*about)[l]);
        return y + curve->steepest * (x - *about);
    }
    for (int l = 0; l < W; l++) y[l] = loaded(curve, x[l]);
    return y;
}

INLINE vector root(vector x)
{
    for (int l = 0; l < W; l++) x[l] = sqrt(x[l]);
    return x;
}

/* What curves of tension and shear give beyond A E; `about`: strains at which they are made straight */
INLINE void stretched(const struct curve *curves, const double *A, const vector *E,
                      const vector *about, vector *N)
{
    vector stretch[2], e[2], at[2], e_at[2], load[3];
    const struct curve *coupling = curves + 5;
    int tension = curves[0].count || curves[1].count || coupling->count;
    UNROLL for (int i = 0; i < 2; i++) {
        stretch[i] = root(1.0 + 2.0 * E[i]), e[i] = stretch[i] - 1.0;
        if (about) at[i] = root(1.0 + 2.0 * about[i]), e_at[i] = at[i] - 1.0;
    }
    UNROLL for (int i = 0; i < 2; i++) { /* of the quadratic energy where there is no curve */
        load[i] = A[4 * i] * E[i] * stretch[i];
        if (curves[i].count) load[i] = loads(curves + i, e[i], about ? e_at + i : NULL);
        N[i] += load[i] / stretch[i] - A[4 * i] * E[i];
    }
    if (tension) {
        vector both = all(A[1]), product = e[0] * e[1]; /* derivative by the product */
        if (coupling->count)
            for (int l = 0; l < W; l++)
                if (product[l] > 0.0) {
                    double q = sqrt(product[l]);
                    both[l] = loaded(coupling, q) / q;
                }
        N[0] += both * e[1] / stretch[0] - A[1] * E[1];
        N[1] += both * e[0] / stretch[1] - A[1] * E[0];
    }
    if (curves[2].count) {
        vector product = stretch[0] * stretch[1], sine = E[2] / product, angle, angle_at;
        for (int l = 0; l < W; l++) angle[l] = asin(sine[l]);
        if (about) {
            vector sine_at = about[2] / (at[0] * at[1]);
            for (int l = 0; l < W; l++) angle_at[l] = asin(sine_at[l]);
        }
        vector pull = loads(curves + 2, angle, about ? &angle_at : NULL);
        pull /= root(1.0 - sine * sine); /* by the sine of the angle */
        N[2] += pull / product - A[8] * E[2];
        N[0] -= pull * sine / (stretch[0] * stretch[0]);
        N[1] -= pull * sine / (stretch[1] * stretch[1]);
    }
}

INLINE void bent(const struct curve *curves, const double *D, const vector *K, const vector *about,
                 vector *M)
{
    UNROLL for (int i = 0; i < 2; i++)
        if (curves[i].count) M[i] += loads(curves + i, K[i], about ? about + i : NULL) - D[4 * i] * K[i];
}

/* ------------------------------------------------------------------ friction */

/* what is lost by a slip that ends at e, begun from the slip p, see above */
INLINE vector lost_by(vector slip, vector e, vector p, double k, double m, double g)
{
    if (g == 0.0) return m * where(slip < 0.0, -slip, slip);
    mask down = slip < 0.0;
    vector a = p + where(down, all(-m), all(m)) * (1.0 / k), size = where(e < 0.0, -e, e);
    /* slip by strain where it began and where it ends */
    vector early = where((a < 0.0) == down, all(1.0 - g / k), all(1.0 + g / k));
    vector late = where((e < 0.0) == down, all(1.0 - g / k), all(1.0 + g / k));
    a /= early;
    vector begun = where(a < 0.0, -a, a);
    vector one = (m + 0.5 * g * (size + begun)) * where(down, -slip, slip);
    vector two = (m + 0.5 * g * begun) * begun * early + (m + 0.5 * g * size) * size * late;
    return where(slip == 0.0, all(0.0), where((a < 0.0) == (e < 0.0), one, two));
}

/* springs (count, 3) of k, m, g; slips p (count, W) of a block, kept if `keep`, not held to the yield
   stress if `stuck`; adds up stored and lost energy per area */
INLINE vector rubbed(int count, const double *springs, vector e, vector *p, int keep, int stuck,
                     vector *stored, vector *lost)
{
    vector stress = {};
    for (int i = 0; i < count; i++) {
        double k = springs[3 * i], m = springs[3 * i + 1], g = springs[3 * i + 2];
        vector f = k * (e - p[i]);
        if (!stuck) {
            vector most = m + g * where(e < 0.0, -e, e), free = f;
            f = where(f > most, most, where(f < -most, -most, f));
            if (any(free != f)) {
                vector slip = (free - f) * (1.0 / k);
                *lost += lost_by(slip, e, p[i], k, m, g);
                if (keep) p[i] += slip;
            }
        }
        *stored += f * f * (0.5 / k);
        stress += f;
    }
    return stress;
}

/* ------------------------------------------------------------------ cells */

INLINE void parts_of(const vector3 *x, vector3 *segment, vector3 *line)
{
#if NODES == 4
    segment[0] = sub(x[1], x[0]), segment[1] = sub(x[3], x[2]);
    segment[2] = sub(x[2], x[0]), segment[3] = sub(x[3], x[1]);
    segment[4] = sub(x[1], x[2]), segment[5] = sub(x[3], x[0]);
    line[0] = mix(0.5, segment[0], 0.5, segment[1]), line[1] = mix(0.5, segment[2], 0.5, segment[3]);
    line[2] = segment[5], line[3] = segment[4];
#else
    segment[0] = sub(x[1], x[0]), segment[1] = sub(x[2], x[0]), segment[2] = sub(x[1], x[2]);
    for (int i = 0; i < 3; i++) line[i] = segment[i];
#endif
}

/* forces at the nodes of those on segments and lines, the transpose of `parts_of` */
INLINE void to_nodes(vector3 *segment, const vector3 *line, vector3 *x)
{
#if NODES == 4
    segment[0] = add(segment[0], scale(all(0.5), line[0]));
    segment[1] = add(segment[1], scale(all(0.5), line[0]));
    segment[2] = add(segment[2], scale(all(0.5), line[1]));
    segment[3] = add(segment[3], scale(all(0.5), line[1]));
    segment[5] = add(segment[5], line[2]), segment[4] = add(segment[4], line[3]);
    x[0] = sub(sub((vector3){}, add(segment[0], segment[2])), segment[5]);
    x[1] = add(sub(segment[0], segment[3]), segment[4]);
    x[2] = sub(sub(segment[2], segment[1]), segment[4]);
    x[3] = add(add(segment[1], segment[3]), segment[5]);
#else
    for (int i = 0; i < 3; i++) segment[i] = add(segment[i], line[i]);
    x[0] = sub((vector3){}, add(segment[0], segment[1]));
    x[1] = add(segment[0], segment[2]), x[2] = sub(segment[1], segment[2]);
#endif
}

/* Add the forces of all cells to r (n, 6) [N, N m], unless r is null.

   count: of cells; nodes (blocks, NODES, W); points (n, 3) [m]; numbers (blocks, WIDTH, W)
   curves: table of CURVES curves, warp, weft, shear, bending of warp and weft, coupling; or null
   stiffness: A and D (2, 3, 3); springs (., 3), of the six strains one after another, and how many
       each has; slips (blocks, all springs, W), or null without friction
   w (n, 6): (u, d); about (count, 6): strains about which curves are made straight, sliders being
       stuck; or null
   strains (count, 6): if not null, set to E and K
   keep: whether sliders stay where they slip to */
struct sums cell_stress(ptrdiff_t count, const int *nodes, const double *points,
                        const double *numbers, const double *curves, const double *stiffness,
                        const double *springs, const int *many, double *slips, const double *w,
                        const double *about, double *strains, int keep, double *r)
{
    struct sums sums = {0.0, 0.0};
    struct curve curve[CURVES] = {};
    int all_springs = 0, in_plane = 0, in_bending = 0, used[2 * STRAINS] = {};
    if (curves)
        for (int i = 0; i < CURVES; i++) {
            curves = read(curves, curve + i);
            *(i == 3 || i == 4 ? &in_bending : &in_plane) |= curve[i].count > 0;
        }
    int stretch = in_plane, bend = in_bending;
    for (int j = 0; j < STRAINS; j++)
        used[j] = stretch || strains, used[3 + j] = (bend && j < 2) || strains;
    if (slips)
        for (int i = 0; i < 2 * STRAINS; i++) {
            all_springs += many[i];
            used[i] |= many[i] > 0;
            *(i < STRAINS ? &in_plane : &in_bending) |= many[i] > 0;
        }
    for (ptrdiff_t first = 0, block = 0; first < count; first += W, block++) {
        const int *cells = nodes + NODES * W * block;
        const vector *b = (const vector *)numbers + WIDTH * block, *rest = b + B;
        const vector *c = rest + SEGMENTS, *flat = c + C, *area = flat + LINES;
        vector3 x[NODES], d[NODES], xs[SEGMENTS], ds[SEGMENTS], xl[LINES], dl[LINES];
        pair segment[SEGMENTS], line[LINES];
        vector e[2 * STRAINS] = {}, from[2 * STRAINS], stress[2 * STRAINS] = {};
        vector stored = {}, lost = {}, *p = slips ? (vector *)slips + all_springs * block : NULL;
        const double *spring = springs;

        for (size_t at = 0; at < WIDTH * sizeof(vector); at += 64)
            __builtin_prefetch((const char *)(b + WIDTH) + at);
        gather(cells, points, w, x, d);
        parts_of(x, xs, xl), parts_of(d, ds, dl);
        if (in_plane || strains)
            UNROLL for (int i = 0; i < SEGMENTS; i++) {
                segment[i] = measured(xs[i], ds[i]);
                vector s = chord(segment[i]) + arc(segment[i]) - rest[i];
                UNROLL for (int j = 0; j < STRAINS; j++)
                    if (used[j]) e[j] += b[SEGMENTS * j + i] * s;
            }
        if (in_bending || strains)
            UNROLL for (int i = 0; i < LINES; i++) {
                line[i] = measured(xl[i], dl[i]);
                vector t = turning(line[i]) - flat[i];
                UNROLL for (int j = 0; j < STRAINS; j++)
                    if (used[3 + j]) e[3 + j] += c[LINES * j + i] * t;
            }
        if (strains)
            for (int l = 0; l < W && first + l < count; l++)
                for (int j = 0; j < 6; j++) strains[6 * (first + l) + j] = e[j][l];
        if (about)
            for (int j = 0; j < 6; j++) from[j] = given(about + j, 6, first, count);
        if (stretch) stretched(curve, stiffness, e, about ? from : NULL, stress);
        if (bend) bent(curve + 3, stiffness + 9, e + 3, about ? from + 3 : NULL, stress + 3);
        if (slips)
            for (int j = 0; j < 6; j++) {
                vector held = {}, gone = {};
                stress[j] += rubbed(many[j], spring, e[j], p, keep, about != NULL, &held, &gone);
                stored += area[j / 3] * held, lost += area[j / 3] * gone;
                p += many[j], spring += 3 * many[j];
            }
        for (int l = 0; l < W && first + l < count; l++) sums.stored += stored[l], sums.lost += lost[l];
        if (!r) continue;

        load on[SEGMENTS] = {}, bending[LINES] = {};
        if (in_plane)
            UNROLL for (int i = 0; i < SEGMENTS; i++) {
                vector pull = {};
                UNROLL for (int j = 0; j < STRAINS; j++)
                    if (used[j]) pull += b[SEGMENTS * j + i] * stress[j];
                on[i] = pulled(area[0] * pull, segment[i], all(1.0));
            }
        if (in_bending)
            UNROLL for (int i = 0; i < LINES; i++) {
                vector moment = {};
                UNROLL for (int j = 0; j < STRAINS; j++)
                    if (used[3 + j]) moment += c[LINES * j + i] * stress[3 + j];
                bending[i] = turned(area[1] * moment, line[i]);
            }
        vector3 f[SEGMENTS], g[LINES], force[NODES], couple[NODES];
        UNROLL for (int i = 0; i < SEGMENTS; i++) f[i] = on[i].force;
        UNROLL for (int i = 0; i < LINES; i++) g[i] = bending[i].force;
        to_nodes(f, g, force);
        UNROLL for (int i = 0; i < SEGMENTS; i++) f[i] = on[i].couple;
        UNROLL for (int i = 0; i < LINES; i++) g[i] = bending[i].couple;
        to_nodes(f, g, couple);
        scatter(cells, force, couple, r);
    }
    return sums;
}
