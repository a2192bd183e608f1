# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a scene describes, made: wearer, garment, shell, stepper, contact."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from mpi4py import MPI

from contact.body.surface_motion import SurfaceMotion
from shellform.contact_coupling.contact import Contact
from shellform.contact_coupling.explicit_contact import ExplicitContact
from shellform.dressing.belt import Belt
from shellform.dressing.dress import dress
from shellform.dressing.procedure import Dressing, unwatched
from shellform.dressing.saved_state import put_on
from shellform.dressing.settle import AT_LEAST, settle_again, settle_on
from shellform.dynamics.explicit import Newmark
from shellform.fem.shell import Shell
from shellform.motion.wearer import Wearer
from shellform.scene.checks import check_dressing
from shellform.scene.flesh import flesh_of
from shellform.scene.garment import garment_of, stiffer_at_seams, wrinkles_of
from shellform.scene.reach import reach_of
from shellform.scene.scene import Scene
from shellform.scene.shoulders import hangs_on_shoulders
from shellform.scene.skin import skin_of_scene
from shellform.scene.wearer import dressed_wearer, dressing_wearer, wearer_of

if TYPE_CHECKING:
    from contact.body.skinned_surface import SkinnedSurface


class Model:
    """A scene ready to be stepped.

    Parameters
    ----------
    scene : Scene; comm : MPI communicator

    Attributes
    ----------
    wearer : Wearer of those ellipsoids that the garment can come to; whole : Wearer of all of them
    skin : SurfaceMotion that is met instead of them, or None
    surface : meshes.Surface, the garment; shell, stepper, contact : of the garment on the wearer
    belt : Belt, once the garment is on; None for what hangs on the shoulders
    """

    def __init__(self, scene: Scene, comm: MPI.Comm):
        self.scene, self.comm = scene, comm
        self.tension = None if hangs_on_shoulders(scene.garment) else scene.belt
        self.whole = wearer_of(scene)
        self.skin = skin_of_scene(scene, self.whole)
        self.surface = garment_of(scene, self.whole)
        self.wearer = dressed_wearer(scene, self.whole, self.surface)
        fabric = scene.cloth
        check_dressing(scene.steps.dressing, fabric)
        wrinkles = wrinkles_of(scene.garment, self.surface, fabric)
        stiffer = stiffer_at_seams(scene.garment, self.surface)
        self.shell = Shell(self.surface, fabric, comm, wrinkles=wrinkles, stiffer=stiffer)
        if scene.gravity:
            self.shell.loads.gravity((0.0, 0.0, -scene.gravity))
        steps = scene.steps
        self.stepper = Newmark(
            self.shell, steps.time_step_factor, damping=steps.damping, drag=steps.drag
        )
        self.stepper.strain_energy()
        self.contact = self._meet(self.stepper, self.skin)
        self.belt: Belt | None = None

    def _meet(
        self,
        stepper: Newmark,
        skin: SurfaceMotion | None = None,
        wearer: Wearer | None = None,
        bare: bool = False,
    ) -> ExplicitContact:
        """Contact of a stepper's nodes with those parts of the body that each can come to.

        wearer : of the same parts, in another motion than the scene's
        bare : without flesh
        """
        contact, owned = self.scene.contact, self.shell.partition.owned_nodes
        kinetic = contact.kinetic_friction
        flesh = None if bare else flesh_of(self.scene, self.whole.names, self.wearer.names)
        running = stepper.add(
            Contact(
                self.wearer if wearer is None else wearer,
                contact.friction if kinetic is None else (contact.friction, kinetic),
                contact.offset,
                # thighs and calves of a skin meet by its own shape, flesh by its own stiffness
                flesh_stiffness=contact.flesh_stiffness if flesh is None and skin is None else None,
                flesh=flesh,
                surface=skin,
                self_contact=contact.self_contact,
            )
        )
        if skin is None:  # a part of a skin would be open, and known no inside
            running.correction.allowed[:] = reach_of(self.surface, self.wearer)[owned]
        return running

    @property
    def weight(self) -> float:
        """Weight of the garment [N]."""
        return self.comm.allreduce(self.stepper.mass.sum()) * self.scene.gravity

    def dress(self, watch: Callable | None = None) -> dict:
        """Put the garment on; returns the report of `dressing.dress.dress`."""
        put = self._dress_shell if self.scene.steps.dressing == "shell" else self._dress_springs
        if self.tension is None:
            put = self._dress_shoulders
        self.belt, report = put(watch)
        return report

    def put_on(self, path: str | Path) -> dict:
        """Put on the dressed state of a file; returns the report of `dressing.settle.settle`."""
        self.belt, report = put_on(path, self.stepper, self.tension)
        return report

    def lay_belt(self) -> None:
        """The belt alone, around cloth whose state comes from a checkpoint."""
        if self.tension is not None:
            self.belt = self.stepper.add(Belt("waist", self.tension))

    def _dress_shell(self, watch: Callable | None) -> tuple[Belt | None, dict]:
        if self.skin is None:
            return dress(self.stepper, self.scene.belt, watch=watch)
        self.stepper.remove(self.contact)
        belt, seconds = self._dress_skin(self.stepper, self.skin, watch)
        self.contact = self._meet(self.stepper, self.skin)
        report = settle_on(self.stepper, belt, Dressing(), unwatched if watch is None else watch)
        return belt, report | {"seconds": seconds + AT_LEAST + report["seconds"]}

    def _dress_shoulders(self, watch: Callable | None) -> tuple[None, dict]:
        """Sewn around raised arms, the cloth follows them down and settles."""
        # only here: other garments are pulled up by their waist
        from shellform.dressing.shoulders import let_down

        dressing, stepper = Dressing(), self.stepper
        lowering = dressing_wearer(self.scene, self.wearer, self.wearer.start - dressing.settle)
        stepper.remove(self.contact)
        bare = self._meet(stepper, wearer=lowering)
        seconds = let_down(stepper, dressing, watch)
        stepper.remove(bare)
        self.contact = self._meet(stepper)
        report = settle_on(stepper, None, dressing, unwatched if watch is None else watch)
        return None, report | {"seconds": seconds + AT_LEAST + report["seconds"]}

    def _dress_skin(
        self, stepper: Newmark, skin: "SkinnedSurface", watch: Callable | None
    ) -> tuple[Belt, float]:
        """Dress a skin by a stepper that has no contact; the belt, and the seconds it took."""
        # only here: bodies of ellipsoids have no skin
        from shellform.dressing.dress_skin import dress_skin

        def meet(surface: SurfaceMotion) -> ExplicitContact:
            # hard, as flesh would not move what the growing body finds deep inside
            return self._meet(stepper, surface, bare=True)

        return dress_skin(stepper, skin, self.wearer, self.scene.belt, meet, watch=watch)

    def _dress_springs(self, watch: Callable | None) -> tuple[Belt | None, dict]:
        """Masses and springs are put on first; the shell bends where they do not: it settles."""
        # only here: springs compile kernels of their own
        from shellform.dynamics.mass_spring import Particles, hand_over

        steps = self.scene.steps
        particles = Particles(self.shell, steps.time_step_factor, drag=steps.drag)
        if self.skin is None:
            self._meet(particles)
            _, first = dress(particles, self.scene.belt, watch=watch)
            seconds = first["seconds"]
        else:
            _, seconds = self._dress_skin(particles, self.skin, watch)
        hand_over(particles, self.stepper)
        belt, report = settle_again(self.stepper, self.scene.belt, Dressing())
        return belt, report | {"seconds": seconds + AT_LEAST + report["seconds"]}
