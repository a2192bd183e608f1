# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact between cloth and a moving body: Eqs. 15 (shapes), 16 (friction) and 17 (motion).

The package works on arrays (positions, velocities, masses) and knows no finite elements, so that
one and the same contact serves the shell and the particle model, and any other program.

    geometry/   shapes of segments: `shape` is the seam, `ellipsoid` and `capsule` are shapes;
                patches on the skin; triangle_mesh/: closed surfaces of triangles
    body/       bodies: named segments, their motion, sets of them; surfaces that move with them,
                rigid or skinned (surface_motion); flesh under the skin (flesh_bed)
    solver/     what a body does to nodes
        explicit steps   velocity_correction: the hook between steps
                         broad_phase -> supporting_planes -> nearest_step -> plane_friction
                         -> contact_ledger, node by node (node_contact); soft_contact in creases
                         surface_correction, flesh_correction: the same for surfaces of triangles
                         and for flesh; node_correction is what they share
        implicit steps   active_set, held_nodes -> node_constraints, slip_friction; obstacle is the
                         seam to segment_obstacle and surface_obstacle (moving_surface)
        of both          friction: the laws; segment_motion and step_record: what kernels share
    self_contact/  what a sheet of triangles does to itself: features -> trust_region, broad_phase
                -> rows -> sweeps, driven by solver; intersections counts what has passed through
    kernel      compiled once and kept beside the sources under a name that says what is computed:
                what has changed is compiled anew by itself

A new shape is one file in geometry/ and its name in `shape.SHAPES`; a new law of friction is one
file anywhere.

    body = Body([Segment("ball", (0.1, 0.1, 0.1), Fixed()),
                 Segment("bar", Capsule(length=0.4, radius=0.05), Fixed((0.0, 0.0, 0.3)))])
    correction = VelocityCorrection(body, len(x), friction=(0.4, 0.3))
    correction(x, v, mass, dt, t)     # v is now admissible; correction.last says what was done
"""
