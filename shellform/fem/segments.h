/* SPDX-License-Identifier: LGPL-3.0-or-later

Cells in blocks of W, one a lane of a vector, and what a sheet measures along segments: Eq. 14.

`vector` holds one number of W cells; GCC's vectors become whatever registers the processor has. A
difference x of positions and d of directors, b = x.d, c = d.d, measure (arc.py)

    half the squared length of the arc   x.x/2 + a b^2 (1 + 2/15 c)/24,   a the weight of the arc
    curvature by the turning angle       b (1 + c/12 + c^2/90)  */

#ifndef NODES
#define NODES 4 /* of a cell */
#endif

#include <stddef.h>

#ifndef W
#ifdef __AVX512F__
#define W 8
#elif defined __AVX__
#define W 4
#else
#define W 2
#endif
#endif

typedef double vector __attribute__((vector_size(8 * W)));
typedef long long mask __attribute__((vector_size(8 * W)));
typedef struct { vector x, y, z; } vector3;
typedef struct { vector3 x, d; vector b, c; } pair;      /* along a segment or a line */
typedef struct { vector3 x, d; vector b, c; } pair_rate; /* what it changes by */
typedef struct { vector3 force, couple; } load;          /* conjugate to x and d of a pair */

#define INLINE static inline __attribute__((always_inline))
#define UNROLL _Pragma("GCC unroll 8")

/* ------------------------------------------------------------------ vectors */

INLINE vector dot(vector3 a, vector3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
INLINE vector3 add(vector3 a, vector3 b) { return (vector3){a.x + b.x, a.y + b.y, a.z + b.z}; }
INLINE vector3 sub(vector3 a, vector3 b) { return (vector3){a.x - b.x, a.y - b.y, a.z - b.z}; }
INLINE vector3 scale(vector s, vector3 a) { return (vector3){s * a.x, s * a.y, s * a.z}; }
INLINE vector3 mix(double s, vector3 a, double t, vector3 b)
{
    return (vector3){s * a.x + t * b.x, s * a.y + t * b.y, s * a.z + t * b.z};
}
INLINE vector3 plus(vector3 a, vector s, vector3 b)
{
    return (vector3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}
INLINE vector all(double a) { return a - (vector){}; }
INLINE vector where(mask m, vector a, vector b)
{
    return (vector)((m & (mask)a) | (~m & (mask)b));
}
INLINE int any(mask m)
{
    long long found = 0;
    for (int l = 0; l < W; l++) found |= m[l];
    return found != 0;
}
/* numbers given cell by cell */
INLINE vector given(const double *numbers, int width, ptrdiff_t first, ptrdiff_t count)
{
    vector t;
    for (int l = 0; l < W; l++) {
        ptrdiff_t cell = first + l < count ? first + l : count - 1;
        t[l] = numbers[width * cell];
    }
    return t;
}
/* y += upper triangle of a symmetric matrix times x */
INLINE void symmetric(int n, const vector *matrix, const vector *x, vector *y)
{
    UNROLL for (int i = 0; i < n; i++)
        UNROLL for (int j = i; j < n; j++) {
            vector k = *matrix++;
            y[i] += k * x[j];
            if (j > i) y[j] += k * x[i];
        }
}

/* ------------------------------------------------------------------ segments and lines */

INLINE pair measured(vector3 x, vector3 d) { return (pair){x, d, dot(x, d), dot(d, d)}; }
INLINE pair_rate rated(pair p, vector3 x, vector3 d)
{
    return (pair_rate){x, d, dot(x, p.d) + dot(p.x, d), 2.0 * dot(p.d, d)};
}
INLINE vector chord(pair p) { return 0.5 * dot(p.x, p.x); }
INLINE vector arc(pair p) { return p.b * p.b * (1.0 / 24.0 + p.c * (1.0 / 180.0)); }
INLINE vector length_rate(pair p, pair_rate v, vector a)
{
    vector slope = v.b * (1.0 / 12.0 + p.c * (1.0 / 90.0)) + p.b * v.c * (1.0 / 180.0);
    return dot(p.x, v.x) + a * p.b * slope;
}
INLINE load pulled(vector pull, pair p, vector a)
{
    vector bent = a * pull * p.b;
    vector along = bent * (1.0 / 12.0 + p.c * (1.0 / 90.0)), across = bent * p.b * (1.0 / 90.0);
    return (load){plus(scale(pull, p.x), along, p.d), plus(scale(along, p.x), across, p.d)};
}
INLINE vector slope_b(pair p) { return 1.0 + p.c * (1.0 / 12.0 + p.c * (1.0 / 90.0)); }
INLINE vector slope_c(pair p) { return p.b * (1.0 / 12.0 + p.c * (1.0 / 45.0)); }
INLINE vector turning(pair p) { return p.b * slope_b(p); }
INLINE vector turning_rate(pair p, vector b, vector c) { return b * slope_b(p) + c * slope_c(p); }
INLINE load turned(vector moment, pair p)
{
    vector s = moment * slope_b(p), t = 2.0 * moment * slope_c(p);
    return (load){scale(s, p.d), plus(scale(s, p.x), t, p.d)};
}
/* the pairs along the sum and the difference of two lines that cross */
INLINE void diagonals(pair p, pair q, pair *sum, pair *difference)
{
    vector b = dot(p.x, q.d) + dot(q.x, p.d), c = 2.0 * dot(p.d, q.d);
    *sum = (pair){add(p.x, q.x), add(p.d, q.d), p.b + q.b + b, p.c + q.c + c};
    *difference = (pair){sub(p.x, q.x), sub(p.d, q.d), p.b + q.b - b, p.c + q.c - c};
}
INLINE vector twist_rate(pair p, pair q, pair sum, pair difference, pair_rate v, pair_rate u)
{
    vector b = dot(v.x, q.d) + dot(u.x, p.d) + dot(p.x, u.d) + dot(q.x, v.d);
    vector c = 2.0 * (dot(v.d, q.d) + dot(p.d, u.d));
    return 0.25 * (turning_rate(sum, v.b + u.b + b, v.c + u.c + c)
                   - turning_rate(difference, v.b + u.b - b, v.c + u.c - c));
}
INLINE load with(load a, load b) { return (load){add(a.force, b.force), add(a.couple, b.couple)}; }
INLINE load without(load a, load b)
{
    return (load){sub(a.force, b.force), sub(a.couple, b.couple)};
}
INLINE load near_far(double s, load a, double t, load b)
{
    return (load){mix(s, a.force, t, b.force), mix(s, a.couple, t, b.couple)};
}

/* ------------------------------------------------------------------ nodes of a block */

/* fields of the nodes of a block: (n, 6) to two vectors a node; points (n, 3) are added */
INLINE void gather(const int *cells, const double *points, const double *w, vector3 *x, vector3 *d)
{
    UNROLL for (int a = 0; a < NODES; a++) {
        vector t[6] = {};
        UNROLL for (int l = 0; l < W; l++) {
            const double *from = w + 6 * (ptrdiff_t)cells[W * a + l];
            const double *at = points + 3 * (ptrdiff_t)cells[W * a + l];
            for (int k = 0; k < 3; k++) t[k][l] = at[k] + from[k], t[3 + k][l] = from[3 + k];
        }
        x[a] = (vector3){t[0], t[1], t[2]}, d[a] = (vector3){t[3], t[4], t[5]};
    }
}
/* add to the nodes cell by cell, so that sums do not depend on W */
INLINE void scatter(const int *cells, const vector3 *force, const vector3 *couple, double *r)
{
    vector t[NODES][6];
    UNROLL for (int a = 0; a < NODES; a++) {
        t[a][0] = force[a].x, t[a][1] = force[a].y, t[a][2] = force[a].z;
        t[a][3] = couple[a].x, t[a][4] = couple[a].y, t[a][5] = couple[a].z;
    }
    for (int l = 0; l < W; l++)
        UNROLL for (int a = 0; a < NODES; a++) {
            double *to = r + 6 * (ptrdiff_t)cells[W * a + l];
            UNROLL for (int k = 0; k < 6; k++) to[k] += t[a][k][l];
        }
}
