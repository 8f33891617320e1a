"""Watches for lost particles and for simulations that blow up."""

import math

from records import Outcome

WORST_OVERLAP = 1.0  # δ/R*: beyond it contact laws mean nothing
ENERGY_FACTOR = 100  # over all the energy that anything could have put in


class Health:
    def __init__(self, program, scene):
        self.program = program
        self.scene = scene
        self.fastest = 0.0  # [m/s] that anything was driven
        self.stress = 0.0  # [Pa] largest of the servo

    def begin(self):
        self.first_energy = self.scene.kinetic_energy() + self.scene.elastic_energy()

    def drive(self, speed):
        self.fastest = max(self.fastest, speed)

    def load(self, stress):
        self.stress = max(self.stress, stress)

    def check(self):
        """Before lost particles what may have thrown them out."""
        scene = self.scene
        overlap = scene.max_overlap()
        if not overlap <= WORST_OVERLAP:
            raise Outcome(
                "unstable",
                f"particles overlap by {overlap:.2f} R* at step {scene.steps}: too soft for the load, "
                "or the time step is too long",
            )
        energy = scene.kinetic_energy()
        if not energy <= ENERGY_FACTOR * self._budget():
            raise Outcome(
                "unstable",
                f"the kinetic energy of {energy:.3g} J at step {scene.steps} is far more than "
                "gravity, walls and cohesion can have put in",
            )
        lost = scene.lost()
        if lost > 0:
            raise Outcome(
                "lost_particles",
                f"{lost} of {len(scene.numbers)} particles are outside the domain at step "
                f"{scene.steps}",
                lost_particles=lost,
            )

    def _budget(self):
        scene = self.scene
        lengths = [u - l for u, l in zip(scene.upper, scene.lower)]
        largest = max(lengths)
        gravity = math.hypot(*self.program["gravity"])
        energy = self.first_energy + scene.total_mass * gravity * largest
        energy += 0.5 * scene.total_mass * self.fastest**2
        energy += self.stress * lengths[0] * lengths[1] * largest
        # Bonds that form and snap: a quarter of E R*³ per particle is more than any holds.
        d = scene.mean_diameter
        materials = self.program["materials"]
        hertz = self.program["law"]["normal"] == "hertz"
        stiffness = materials["young_modulus"] * d if hertz else materials["linear"]["normal"]
        return energy + 1e-6 * stiffness * d * d * len(scene.numbers)
