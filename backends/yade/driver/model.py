"""Materials and contact law in YADE's terms.

Hertz–Mindlin. With E* and G* of the canonical law, YADE computes k_no = 4/3 E* √R*, k_s = 8 G* √(R* δ),
k_n = 3/2 k_no √δ = 2 E* √(R* δ) and damps with 2 betan √(m* k_n), 2 betas √(m* k_s): the canonical
law for betan = betas = √(5/6) β. (`en` instead of `betan` follows another formula.) Planes and facets
count as spheres of 1e8 radii, so that R* there is the sphere's radius but for 1e-8 of it.

Linear. YADE puts the constants of two materials in series, hence twice each.
"""

import math

import yade

KINDS = ("particle", "wall", "smooth")  # smooth: frictionless planes


def damping_ratio(restitution):
    log_e = math.log(restitution)
    return -log_e / math.hypot(log_e, math.pi)


def by_kind(ids, particle, wall, smooth):
    """A parameter for contacts of particles with each kind of body."""
    particles = ids["particle"]
    matches = [
        (particles, particles, particle),
        (particles, ids["wall"], wall),
        (particles, ids["smooth"], smooth),
    ]
    return yade.MatchMaker(matches=matches, algo="zero")


class Model:
    """Adds the materials to the scene and makes the functors of the interaction loop."""

    def __init__(self, program, rolling_stiffness):
        self.law = program["law"]
        self.materials = program["materials"]
        self.rolling_stiffness = rolling_stiffness
        self.linear = self.law["normal"] == "linear"
        self.ids = {kind: yade.O.materials.append(self._material(kind)) for kind in KINDS}

    def geometry_functors(self):
        # The canonical law takes slip from the true arms of the contact; YADE's correction against
        # ratcheting would change them.
        return [
            yade.Ig2_Sphere_Sphere_ScGeom(avoidGranularRatcheting=False),
            yade.Ig2_Facet_Sphere_ScGeom(hertzian=True),
        ]

    def physics_functor(self):
        particle = self.materials["particle_particle"]
        wall = self.materials["particle_wall"]
        angles = by_kind(
            self.ids, math.atan(particle["friction"]), math.atan(wall["friction"]), 0.0
        )
        if self.linear:
            return yade.Ip2_ViscElMat_ViscElMat_ViscElPhys(frictAngle=angles)
        factor = math.sqrt(5 / 6)
        of_particles = factor * damping_ratio(particle["restitution"])
        of_walls = factor * damping_ratio(wall["restitution"])
        damping = by_kind(self.ids, of_particles, of_walls, of_walls)
        functor = yade.Ip2_FrictMat_FrictMat_MindlinPhys(
            frictAngle=angles, betan=damping, betas=damping
        )
        if self.law["cohesion"] == "dmt":
            functor.gamma = particle["surface_energy"]
        if self.rolls():
            # YADE's limit is eta times the mean radius, of equal spheres 2 R*.
            functor.eta = particle["rolling_friction"] / 2
            functor.krot = self.rolling_stiffness
        return functor

    def law_functor(self):
        if self.linear:
            return yade.Law2_ScGeom_ViscElPhys_Basic()
        return yade.Law2_ScGeom_MindlinPhys_Mindlin(
            includeAdhesion=self.sticks(), includeMoment=self.rolls()
        )

    def sticks(self):
        energy = self.materials["particle_particle"]["surface_energy"]
        return self.law["cohesion"] == "dmt" and energy > 0

    def rolls(self):
        friction = self.materials["particle_particle"]["rolling_friction"]
        return self.law["rolling"] != "none" and friction > 0

    def elastic_energy(self, law_functor):
        """Energy in the normal springs [J]."""
        if self.linear:
            stiffness = self.materials["linear"]["normal"]
            return sum(
                0.5 * stiffness * max(0.0, contact.geom.penetrationDepth) ** 2
                for contact in yade.O.interactions
                if contact.isReal
            )
        # Else YADE would take the work of adhesion off.
        law_functor.includeAdhesion = False
        energy = law_functor.normElastEnergy()
        law_functor.includeAdhesion = self.sticks()
        return energy

    def _material(self, kind):
        materials = self.materials
        if self.linear:
            linear = materials["linear"]
            return yade.ViscElMat(
                kn=2 * linear["normal"],
                ks=2 * linear["tangential"],
                cn=2 * linear["normal_damping"],
                cs=2 * linear["tangential_damping"],
                density=materials["density"],
                label=kind,
            )
        return yade.FrictMat(
            young=materials["young_modulus"],
            poisson=materials["poisson_ratio"],
            density=materials["density"],
            label=kind,
        )
