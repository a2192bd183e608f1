/* SPDX-License-Identifier: LGPL-3.0-or-later

Internal force of the 4-node quad with six lengths and turning angles: Eq. 14 of the paper.

Cells come in blocks of W, one cell a lane of a vector (segments.h). All strains of a cell are
differences along six segments and along the four lines through its Gauss points:

    nodes (0,0), (1,0), (0,1), (1,1) are 0, 1, 2, 3
    segments 0 = 01, 1 = 23 along axis 1; 2 = 02, 3 = 13 along axis 2; diagonals 4 = 21, 5 = 03
    lines 0, 1 along axis 1; 2, 3 along axis 2; Gauss points 0, 1, 2, 3 where 02, 03, 12, 13 cross

Membrane: strains s of the six segments; E = B s in the axes of the fabric, stress N(E), two modes
m.s of bending in the plane. Transverse shear at the four corners, bending at the four Gauss points.
Damped, the stress is that of the strains plus their rates times a time, in the present
configuration. */

#include "segments.h"

#define NEAR 0.78867513459481288 /* (1 + 1/sqrt 3)/2: a line from the segment near it */
#define FAR 0.21132486540518712

/* numbers of a cell, in this order */
enum { SHEAR = 12, BENDING = 24, REST = 12 };            /* shared by both membranes */
enum { STIFFNESS = 21, LENGTHS = 6 };                    /* resolved membrane */
enum { STRAIN = 18, MODES = 12, AREA = 1, CHORDS = 6, ARCS = 6 }; /* relaxed membrane */
enum { SAMPLES = 24, NEWTON = 6 };

/* The fabric, one in the whole sheet: see taut_fibres.py. Fibres at an angle theta are
   v = (cos^2, sin^2, cos sin). */
struct fabric {
    double stiffness[6];                 /* C, upper triangle [N/m] */
    double shift[3];                     /* C^-1 (1, 1, 0) [m/N] */
    double compliance[5];                /* v.C^-1.v = sum of q_k tan^k over (1 + tan^2)^2 [m/N] */
    double mean[SAMPLES], half[SAMPLES], shear[SAMPLES]; /* (1, cos 2 theta, sin 2 theta) over
                                                            the root of v.C^-1.v */
    double weft[SAMPLES];                /* 1 if nearer the weft, angles being counted from there */
    double at[SAMPLES], low[SAMPLES], high[SAMPLES]; /* tan of the angle, of the neighbours' */
};

int lanes(void) { return W; }

/* ------------------------------------------------------------------ relaxed membrane */

/* Stress of a wrinkled cell without cost: the energy is the largest (v.e)_+^2/(2 v.C^-1.v) over
   the angle theta of the taut fibres, the stress (v.e)_+/(v.C^-1.v) v. There are several maxima: the
   best of many samples is refined. With t the tangent from the nearer yarn, v.e is P(t) and
   v.C^-1.v is Q(t), over powers of 1 + t^2; the maximum is a root of F = 2 P' Q - P Q', of fourth
   degree, which Newton steps find between the neighbours of the sample. */
INLINE void uniaxial(const struct fabric *f, const vector *e, vector *stress)
{
    vector mean = 0.5 * (e[0] + e[1]), half = 0.5 * (e[0] - e[1]), shear = 0.5 * e[2];
    vector best = {};
    mask chosen = {};
    for (int j = 0; j < SAMPLES; j++) { /* root of the energy */
        vector gain = mean * f->mean[j] + half * f->half[j] + shear * f->shear[j];
        mask better = gain > best;
        best = where(better, gain, best);
        chosen = (better & j) | (~better & chosen);
    }
    vector start, low, high, side;
    for (int l = 0; l < W; l++) {
        ptrdiff_t j = chosen[l];
        start[l] = f->at[j], low[l] = f->low[j], high[l] = f->high[j], side[l] = f->weft[j];
    }
    mask weft = side > 0.0;
    /* the axis of the largest strain: the only one where hardly any fibre is taut */
    const double *q = f->compliance;
    vector square = half * half + shear * shear, root;
    for (int l = 0; l < W; l++) root[l] = __builtin_sqrt(square[l]);
    mask nearer = half < 0.0;
    vector t = shear / (root + where(nearer, -half, half)), P = (mean + root) * (1.0 + t * t);
    vector q0 = where(nearer, all(q[4]), all(q[0])), q1 = where(nearer, all(q[3]), all(q[1]));
    vector q4 = (q[0] + q[4]) - q0, q3 = (q[1] + q[3]) - q1;
    vector Q = q0 + t * (q1 + t * (q[2] + t * (q3 + t * q4)));
    mask better = (P > 0.0) & (P * P > best * best * Q);
    weft = (better & nearer) | (~better & weft);
    start = where(better, t, start);
    low = where(better, t - 0.5, low), high = where(better, t + 0.5, high);

    vector a = where(weft, e[1], e[0]), b = e[2], c = where(weft, e[0], e[1]);
    q0 = where(weft, all(q[4]), all(q[0])), q1 = where(weft, all(q[3]), all(q[1]));
    q4 = (q[0] + q[4]) - q0, q3 = (q[1] + q[3]) - q1;
    vector F0 = 2.0 * b * q0 - a * q1, F1 = b * q1 + 4.0 * c * q0 - 2.0 * a * q[2];
    vector F2 = 3.0 * (c * q1 - a * q3), F3 = 2.0 * c * q[2] - 4.0 * a * q4 - b * q3;
    vector F4 = c * q3 - 2.0 * b * q4;
    t = start;
    for (int step = 0; step < NEWTON; step++) {
        vector F = F0 + t * (F1 + t * (F2 + t * (F3 + t * F4)));
        vector slope = F1 + t * (2.0 * F2 + t * (3.0 * F3 + t * (4.0 * F4)));
        vector next = t - F / slope;
        mask taut = a + t * (b + t * c) > 0.0;
        mask rises = (taut & (F > 0.0)) | (~taut & (t < start));
        low = where(rises, t, low), high = where(rises, high, t);
        mask inside = taut & (slope < 0.0) & (next >= low) & (next <= high);
        t = where(inside, next, 0.5 * (low + high));
    }
    P = a + t * (b + t * c), Q = q0 + t * (q1 + t * (q[2] + t * (q3 + t * q4)));
    vector along = where(P < 0.0, all(0.0), P / Q), across = along * t * t;
    stress[0] = where(weft, across, along), stress[1] = where(weft, along, across);
    stress[2] = along * t;
}

INLINE void elastic(const struct fabric *f, const vector *e, vector *n)
{
    const double *C = f->stiffness;
    n[0] = C[0] * e[0] + C[1] * e[1] + C[2] * e[2];
    n[1] = C[1] * e[0] + C[3] * e[1] + C[4] * e[2];
    n[2] = C[2] * e[0] + C[4] * e[1] + C[5] * e[2];
}

/* Stress of least energy of E + W at the cost of W, W >= 0: that without cost at a shifted strain.
   Taut, slack or, by `uniaxial`, in between. */
INLINE void relaxed(const struct fabric *f, const vector *strain, vector cost, vector *n)
{
    vector e[3];
    UNROLL for (int k = 0; k < 3; k++) e[k] = strain[k] + cost * f->shift[k];
    elastic(f, e, n);
    mask taut = (n[0] >= 0.0) & (n[1] >= 0.0) & (n[0] * n[1] >= n[2] * n[2]);
    mask slack = (e[0] <= 0.0) & (e[1] <= 0.0) & (4.0 * e[0] * e[1] >= e[2] * e[2]);
    if (any(~taut)) {
        vector wrinkled[3] = {};
        if (any(~taut & ~slack)) {
            uniaxial(f, e, wrinkled);
            UNROLL for (int k = 0; k < 3; k++) wrinkled[k] = where(slack, all(0.0), wrinkled[k]);
        }
        UNROLL for (int k = 0; k < 3; k++) n[k] = where(taut, n[k], wrinkled[k]);
    }
    n[0] -= cost, n[1] -= cost;
}

/* the same for strains (count, 3) one by one */
void relax(ptrdiff_t count, const struct fabric *fabric, const double *strain, const double *cost,
           double *stress)
{
    for (ptrdiff_t first = 0; first < count; first += W) {
        vector e[3], n[3];
        UNROLL for (int k = 0; k < 3; k++) e[k] = given(strain + k, 3, first, count);
        relaxed(fabric, e, given(cost, 1, first, count), n);
        for (int l = 0; l < W && first + l < count; l++)
            for (int k = 0; k < 3; k++) stress[3 * (first + l) + k] = n[k][l];
    }
}

/* ------------------------------------------------------------------ cells */

INLINE void differences(const vector3 *x, vector3 *segment)
{
    segment[0] = sub(x[1], x[0]), segment[1] = sub(x[3], x[2]);
    segment[2] = sub(x[2], x[0]), segment[3] = sub(x[3], x[1]);
    segment[4] = sub(x[1], x[2]), segment[5] = sub(x[3], x[0]);
}
INLINE void middles(const vector3 *d, vector3 *middle)
{
    middle[0] = mix(0.5, d[0], 0.5, d[1]), middle[1] = mix(0.5, d[2], 0.5, d[3]);
    middle[2] = mix(0.5, d[0], 0.5, d[2]), middle[3] = mix(0.5, d[1], 0.5, d[3]);
}
/* on the four lines, of what the segments have */
INLINE void lines_of(const vector3 *segment, vector3 *line)
{
    UNROLL for (int k = 0; k < 4; k += 2) {
        line[k] = mix(NEAR, segment[k], FAR, segment[k + 1]);
        line[k + 1] = mix(FAR, segment[k], NEAR, segment[k + 1]);
    }
}
/* have numbers at hand when the next block is worked on */
INLINE void prefetch(const vector *numbers, int width)
{
    UNROLL for (size_t at = 0; at < width * sizeof(vector); at += 64)
        __builtin_prefetch((const char *)numbers + at);
}
/* Add the internal forces of all cells to r (n, 6) [N, N m], see quad_force.py.

   count: of cells; cells (blocks, 4, W); points (n, 3) [m]
   numbers (blocks, SHEAR + BENDING + REST + membrane, W)
   fabric: of the relaxed membrane; null: resolved
   w, ahead (n, 6): (u, d), and w plus its rates times the time of damping; null: undamped
   cost [N/m], arcs (count,): of the relaxed membrane
   frozen (count, 3) [N/m]: if not null, stress that relaxation adds to that of the taut sheet,
       written if `freeze`, else taken in place of relaxation
   Returns twice what the rates would store as strains [J]. */
double add_forces(ptrdiff_t count, const int *nodes, const double *points, const double *numbers,
                  const struct fabric *fabric, const double *w, const double *ahead,
                  const double *cost, const double *arcs, double *frozen, int freeze, double *r)
{
    const int width = SHEAR + BENDING + REST
                      + (fabric ? STRAIN + MODES + AREA + CHORDS + ARCS : STIFFNESS + LENGTHS);
    double lost = 0.0;
    for (ptrdiff_t first = 0, block = 0; first < count; first += W, block++) {
        const int *cells = nodes + 4 * W * block;
        const vector *shear = (const vector *)numbers + width * block, *next = shear + width;
        const vector *bending = shear + SHEAR, *rest = bending + BENDING, *membrane = rest + REST;
        vector3 x[4], d[4], xs[6], ds[6], middle[4], xl[4], dl[4];
        pair segment[6], line[4];
        vector s[6], y[4], k[4], twist[4], loss = {};
        vector weight = fabric ? given(arcs, 1, first, count) : all(1.0);

        /* strains: of segments, shear of sides, curvature of lines, twist where they cross */
        prefetch(next + 0 * width / 6, (width + 5) / 6);
        gather(cells, points, w, x, d);
        differences(x, xs), differences(d, ds);
        middles(d, middle), lines_of(xs, xl), lines_of(ds, dl);
        prefetch(next + 1 * width / 6, (width + 5) / 6);
        UNROLL for (int i = 0; i < 6; i++) {
            const vector *lengths = membrane + (fabric ? STRAIN + MODES + AREA : STIFFNESS);
            segment[i] = measured(xs[i], ds[i]);
            s[i] = chord(segment[i]) - lengths[i];
            s[i] += fabric ? weight * (arc(segment[i]) - lengths[CHORDS + i]) : arc(segment[i]);
        }
        UNROLL for (int i = 0; i < 4; i++) {
            y[i] = dot(xs[i], middle[i]) - rest[i];
            line[i] = measured(xl[i], dl[i]);
            k[i] = turning(line[i]) - rest[4 + i];
        }
        prefetch(next + 2 * width / 6, (width + 5) / 6);
        UNROLL for (int p = 0; p < 4; p++) {
            pair sum, difference;
            diagonals(line[p / 2], line[2 + p % 2], &sum, &difference);
            twist[p] = 0.25 * (turning(sum) - turning(difference)) - rest[8 + p];
        }

        vector s_rate[6] = {};
        if (ahead) { /* rates, times the time of damping */
            vector3 vx[4], vd[4], vxs[6], vds[6], vxl[4], vdl[4], turn[4];
            pair_rate rate[4];
            vector y_rate[4], k_rate[4], load_of[4] = {};
            gather(cells, points, ahead, vx, vd);
            UNROLL for (int a = 0; a < 4; a++) vx[a] = sub(vx[a], x[a]), vd[a] = sub(vd[a], d[a]);
            differences(vx, vxs), differences(vd, vds);
            middles(vd, turn), lines_of(vxs, vxl), lines_of(vds, vdl);
            UNROLL for (int i = 0; i < 6; i++)
                s_rate[i] = length_rate(segment[i], rated(segment[i], vxs[i], vds[i]), weight);
            UNROLL for (int i = 0; i < 4; i++) {
                y_rate[i] = dot(vxs[i], middle[i]) + dot(xs[i], turn[i]);
                y[i] += y_rate[i];
                rate[i] = rated(line[i], vxl[i], vdl[i]);
                k_rate[i] = turning_rate(line[i], rate[i].b, rate[i].c);
                k[i] += k_rate[i];
            }
            UNROLL for (int p = 0; p < 4; p++) {
                int i = p / 2, j = 2 + p % 2;
                pair sum, difference;
                diagonals(line[i], line[j], &sum, &difference);
                vector t = twist_rate(line[i], line[j], sum, difference, rate[i], rate[j]);
                twist[p] += t;
                vector strain[3] = {k_rate[i], k_rate[j], t}, moment[3] = {};
                symmetric(3, bending + 6 * p, strain, moment);
                loss += moment[0] * strain[0] + moment[1] * strain[1] + moment[2] * strain[2];
                const vector *S = shear + 3 * p;
                load_of[i] += S[0] * y_rate[i] + S[1] * y_rate[j];
                load_of[j] += S[1] * y_rate[i] + S[2] * y_rate[j];
            }
            UNROLL for (int i = 0; i < 4; i++) loss += load_of[i] * y_rate[i];
        }

        prefetch(next + 3 * width / 6, (width + 5) / 6);
        /* pulls of the segments */
        vector pull[6] = {};
        if (!fabric) {
            if (ahead) {
                vector viscous[6] = {};
                symmetric(6, membrane, s_rate, viscous);
                UNROLL for (int i = 0; i < 6; i++) loss += viscous[i] * s_rate[i], s[i] += s_rate[i];
            }
            symmetric(6, membrane, s, pull);
        } else {
            const vector *B = membrane, *modes = membrane + STRAIN;
            vector area = membrane[STRAIN + MODES], N_c = given(cost, 1, first, count);
            vector e[3] = {}, e_rate[3] = {}, n[3];
            UNROLL for (int j = 0; j < 3; j++)
                UNROLL for (int i = 0; i < 6; i++) e[j] += B[6 * j + i] * s[i];
            if (ahead) {
                vector still[3];
                relaxed(fabric, e, N_c, still);
                UNROLL for (int j = 0; j < 3; j++) {
                    UNROLL for (int i = 0; i < 6; i++) e_rate[j] += B[6 * j + i] * s_rate[i];
                    e[j] += e_rate[j];
                    loss -= area * still[j] * e_rate[j];
                }
            }
            if (frozen && !freeze) {
                elastic(fabric, e, n);
                UNROLL for (int j = 0; j < 3; j++)
                    n[j] += given(frozen + j, 3, first, count);
            } else
                relaxed(fabric, e, N_c, n);
            if (frozen && freeze) {
                vector taut[3];
                elastic(fabric, e, taut);
                for (int l = 0; l < W && first + l < count; l++)
                    for (int j = 0; j < 3; j++) frozen[3 * (first + l) + j] = n[j][l] - taut[j][l];
            }
            UNROLL for (int j = 0; j < 3; j++) {
                loss += area * n[j] * e_rate[j];
                n[j] *= area;
                UNROLL for (int i = 0; i < 6; i++) pull[i] += B[6 * j + i] * n[j];
            }
            UNROLL for (int j = 0; j < 2; j++) {
                const vector *mode = modes + 6 * j;
                vector bent = {}, rate = {};
                UNROLL for (int i = 0; i < 6; i++) bent += mode[i] * s[i];
                if (ahead) {
                    UNROLL for (int i = 0; i < 6; i++) rate += mode[i] * s_rate[i];
                    bent += rate;
                    loss += rate * rate;
                }
                UNROLL for (int i = 0; i < 6; i++) pull[i] += mode[i] * bent;
            }
        }
        if (ahead)
            for (int l = 0; l < W; l++) lost += loss[l];

        prefetch(next + 4 * width / 6, (width + 5) / 6);
        /* loads of the segments: pulls, shear of the sides, bending and twisting moments */
        vector side[4] = {}, along[4] = {};
        load on[6], bend[4] = {};
        UNROLL for (int i = 0; i < 6; i++) on[i] = pulled(pull[i], segment[i], weight);
        UNROLL for (int p = 0; p < 4; p++) {
            int i = p / 2, j = 2 + p % 2;
            const vector *S = shear + 3 * p;
            side[i] += S[0] * y[i] + S[1] * y[j];
            side[j] += S[1] * y[i] + S[2] * y[j];
            vector strain[3] = {k[i], k[j], twist[p]}, moment[3] = {};
            pair sum, difference;
            symmetric(3, bending + 6 * p, strain, moment);
            along[i] += moment[0], along[j] += moment[1];
            diagonals(line[i], line[j], &sum, &difference);
            load plus_load = turned(0.25 * moment[2], sum);
            load minus_load = turned(0.25 * moment[2], difference);
            bend[i] = with(bend[i], without(plus_load, minus_load));
            bend[j] = with(bend[j], with(plus_load, minus_load));
        }
        UNROLL for (int i = 0; i < 4; i++) {
            bend[i] = with(bend[i], turned(along[i], line[i]));
            on[i].force = plus(on[i].force, side[i], middle[i]);
        }
        prefetch(next + 5 * width / 6, (width + 5) / 6);
        UNROLL for (int i = 0; i < 4; i += 2) {
            on[i] = with(on[i], near_far(NEAR, bend[i], FAR, bend[i + 1]));
            on[i + 1] = with(on[i + 1], near_far(FAR, bend[i], NEAR, bend[i + 1]));
        }

        /* to the nodes; the shear of a side turns both of its directors */
        vector3 force[4], couple[4], half[4];
        UNROLL for (int i = 0; i < 4; i++) half[i] = scale(0.5 * side[i], xs[i]);
        force[0] = sub(sub((vector3){}, add(on[0].force, on[2].force)), on[5].force);
        force[1] = add(sub(on[0].force, on[3].force), on[4].force);
        force[2] = sub(sub(on[2].force, on[1].force), on[4].force);
        force[3] = add(add(on[1].force, on[3].force), on[5].force);
        couple[0] = sub(add(half[0], half[2]), add(add(on[0].couple, on[2].couple), on[5].couple));
        couple[1] = add(add(half[0], half[3]), add(sub(on[0].couple, on[3].couple), on[4].couple));
        couple[2] = add(add(half[1], half[2]), sub(sub(on[2].couple, on[1].couple), on[4].couple));
        couple[3] = add(add(half[1], half[3]), add(add(on[1].couple, on[3].couple), on[5].couple));
        scatter(cells, force, couple, r);
    }
    return lost;
}
