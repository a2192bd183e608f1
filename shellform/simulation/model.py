# SPDX-License-Identifier: LGPL-3.0-or-later
"""A scene ready to be stepped: wearer, garment, shell, stepper, contact."""

from shellform.contact_coupling.contact import Contact
from shellform.dressing.belt import Belt
from shellform.dressing.dress import Dressing, dress, settle
from shellform.dynamics.explicit import Newmark
from shellform.fem.shell import Shell
from shellform.material.card import fabric_of
from shellform.scene.garment import garment_of
from shellform.scene.reach import reach_of
from shellform.scene.wearer import dressed_wearer, wearer_of


class Activity:
    """A scene ready to be stepped.

    Parameters
    ----------
    scene : Scene; comm : MPI communicator

    Attributes
    ----------
    wearer : Wearer of those ellipsoids that the garment can come to
    surface, shell, stepper, touch : see build.py, Shell, Newmark, ExplicitContact
    whole : Wearer of all of them
    """

    def __init__(self, scene, comm):
        self.scene, self.comm = scene, comm
        self.whole = wearer_of(scene)
        self.surface = garment_of(scene, self.whole)
        self.wearer = dressed_wearer(scene, self.whole, self.surface)
        self.shell = Shell(self.surface, fabric_of(scene.fabric), comm)
        if scene.gravity:
            self.shell.loads.gravity((0.0, 0.0, -scene.gravity))
        steps = scene.steps
        self.stepper = Newmark(
            self.shell, steps.time_step_factor, damping=steps.damping, drag=steps.drag
        )
        self.stepper.strain_energy()
        self.touch = self._touch(self.stepper)

    def _touch(self, stepper):
        contact, owned = self.scene.contact, self.shell.partition.owned_nodes
        friction = contact.friction
        if contact.kinetic_friction is not None:
            friction = (friction, contact.kinetic_friction)
        soft = {"flesh_stiffness": contact.flesh_stiffness}
        touch = stepper.add(Contact(self.wearer, friction, contact.offset, **soft))
        touch.correction.allowed[:] = reach_of(self.surface, self.wearer)[owned]
        return touch

    @property
    def weight(self):
        """Weight of the garment [N]."""
        return self.comm.allreduce(self.stepper.mass.sum()) * self.scene.gravity

    def dress(self, watch=None):
        """Put the garment on; returns the report of `dressing.dress`."""
        tension = self.scene.belt
        if self.scene.steps.dressing == "shell":
            self.belt, report = dress(self.stepper, self.touch, tension, watch=watch)
            return report
        from shellform.dynamics.mass_spring import Particles, hand_over

        steps = self.scene.steps
        particles = Particles(self.shell, steps.time_step_factor, drag=steps.drag)
        touch = self._touch(particles)
        _, report = dress(particles, touch, tension, watch=watch)
        hand_over(particles, self.stepper)
        # the shell bends where springs do not: it settles once more
        plan = Dressing()
        self.belt = self.stepper.add(Belt("waist", tension))
        self.stepper.time = self.wearer.start - plan.settle
        self.stepper.advance(self.stepper.time + 0.1)
        again = settle(self.stepper, self.touch, self.belt, plan, lambda *_: None)
        self.stepper.drag = steps.drag
        return again | {"seconds": report["seconds"] + 0.1 + again["seconds"]}
