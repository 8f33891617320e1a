"""The simulation in YADE: particles, planes, meshes, glued groups, one step after another.

The engines stand in another order than YADE's examples have them, the integrator first. After a
step, positions, contacts and forces then belong to the same moment, as powdercal's engines have it;
velocities are half a step behind (YADE's integrator is a leapfrog) and are brought forward where a
state is handed out.

Planes are facets much larger than the domain: YADE's Wall applies forces at its surface, half an
overlap nearer than the canonical law does, and hangs in a periodic cell.
"""

import math

import yade
from yade import O, utils

from model import Model

SPHERE_BIT = 1
FAR = 8.0  # [domain's diagonal] inradius of the facet that stands for a plane
IMMOVABLE = 1e200  # [kg m2] moment of inertia of glued spheres
GLANCE = 1e-12  # [steps]
MANY = 16  # bodies in one, from which on its force is sampled
SAMPLE_EVERY = 5  # [steps] then


class Body:
    """A plane, a mesh or a glued group."""

    def __init__(self, name, kind):
        self.name = name
        self.kind = kind
        self.ids = []  # of YADE's bodies
        self.axis = 2  # of a plane
        self.height = 0.0  # [m] as in WallState, at displacement 0
        self.displacement = [0.0, 0.0, 0.0]
        self.velocity = [0.0, 0.0, 0.0]
        self.in_play = True
        self.removed = False

    def present_height(self):
        return self.height + self.displacement[self.axis]


class Scene:
    def __init__(self, job):
        self.program = job["program"]
        self.time_step = self.program["time_step"]
        self.gravity = self.program["gravity"]
        self.domain = self.program["domain"]
        sides = [self.domain["boundary_" + axis] for axis in "xyz"]
        self.sides = sides
        self.periodic = sides == ["periodic"] * 3
        self.lower = list(self.domain["lower"])
        self.upper = list(self.domain["upper"])
        self.steps = 0
        self.leavers = 0
        self._reset_yade()
        self.model = Model(self.program, job["rolling_stiffness"])
        self._add_spheres(job["start"])
        self.bodies = []
        self._add_bodies(job["servo_wall"])
        self._make_engines()
        self.fetch()

    # --- Building -------------------------------------------------------------------------------

    def _reset_yade(self):
        O.reset()
        O.periodic = self.periodic
        if self.periodic:
            lengths = [u - l for u, l in zip(self.upper, self.lower)]
            O.cell.setBox(*lengths)
            # Impulses with the changes of the velocity gradient, but no convective term: the
            # equation of motion is m dv/dt = F, in the laboratory's frame.
            O.cell.homoDeform = 1
        self.origin = list(self.lower) if self.periodic else [0.0, 0.0, 0.0]

    def _add_spheres(self, start):
        density = self.program["materials"]["density"]
        material = self.model.ids["particle"]
        self.group_of = {}
        for index, group in enumerate(self.program["groups"]):
            for number in group["ids"]:
                self.group_of[number] = index
        self.numbers = []  # the program's, by place
        self.sphere_ids = []  # YADE's, by place
        self.radii = []
        self.masses = []
        self.group_ids = [[] for _ in self.program["groups"]]
        for row in start:
            number, radius = row[0], row[1]
            mass = density * 4 / 3 * math.pi * radius**3
            sphere = utils.sphere(self.into_yade(row[2:5]), radius, material=O.materials[material])
            state = sphere.state
            state.mass = mass
            state.inertia = yade.Vector3(*[0.4 * mass * radius**2] * 3)
            group = self.group_of.get(number)
            if group is None:
                state.vel = yade.Vector3(*row[5:8])
                state.angVel = yade.Vector3(*row[8:11])
                sphere.mask = SPHERE_BIT
            else:
                # Were all freedoms blocked, YADE would take the partner's mass for the reduced one.
                state.blockedDOFs = "xyzXY"
                state.inertia = yade.Vector3(*[IMMOVABLE] * 3)
                sphere.mask = SPHERE_BIT | 2 << group
            sphere_id = O.bodies.append(sphere)
            if group is not None:
                self.group_ids[group].append(sphere_id)
            self.numbers.append(number)
            self.sphere_ids.append(sphere_id)
            self.radii.append(radius)
            self.masses.append(mass)
        diameters = [2 * radius for radius in self.radii]
        self.mean_diameter = sum(diameters) / len(diameters)
        self.total_mass = sum(self.masses)

    def _add_bodies(self, servo_wall):
        for plane in self.program["walls"]:
            body = Body(plane["name"], "plane")
            body.axis = plane["axis"]
            body.height = plane["position"]
            body.material = "smooth" if plane["frictionless"] else "wall"
            body.in_play = plane["name"] != servo_wall  # comes with its servo
            self.bodies.append(body)
            if body.in_play:
                self.put_plane(body)
        for mesh in self.program["meshes"]:
            body = Body(mesh["name"], "mesh")
            vertices = [yade.Vector3(*vertex) for vertex in mesh["vertices"]]
            for triangle in mesh["triangles"]:
                facet = utils.facet(
                    [vertices[v] for v in triangle], material=O.materials[self.model.ids["wall"]]
                )
                facet.mask = SPHERE_BIT
                body.ids.append(O.bodies.append(facet))
            body.height = min(vertex[2] for vertex in mesh["vertices"])
            self.bodies.append(body)
        for index, group in enumerate(self.program["groups"]):
            body = Body(group["name"], "group")
            body.ids = self.group_ids[index]
            self.bodies.append(body)

    def put_plane(self, body):
        """Adds a plane's facet at its height."""
        lengths = [u - l for u, l in zip(self.upper, self.lower)]
        reach = 2 * FAR * math.hypot(*lengths)  # from the centre to a vertex
        centre = [0.5 * (u + l) for u, l in zip(self.upper, self.lower)]
        centre[body.axis] = body.height
        first, second = (body.axis + 1) % 3, (body.axis + 2) % 3
        corners = []
        for n in range(3):
            corner = list(centre)
            corner[first] += reach * math.cos(2 * math.pi * n / 3)
            corner[second] += reach * math.sin(2 * math.pi * n / 3)
            corners.append(yade.Vector3(*corner))
        facet = utils.facet(corners, material=O.materials[self.model.ids[body.material]])
        facet.mask = SPHERE_BIT
        facet.state.pos[body.axis] = body.height
        body.ids = [O.bodies.append(facet)]
        body.in_play = True

    def _make_engines(self):
        group_bits = sum(2 << index for index in range(len(self.program["groups"])))
        O.engines = [
            yade.NewtonIntegrator(
                damping=0, gravity=yade.Vector3(*self.gravity), warnNoForceReset=False
            ),
            yade.ForceResetter(),
            yade.InsertionSortCollider(
                [yade.Bo1_Sphere_Aabb(), yade.Bo1_Facet_Aabb()],
                avoidSelfInteractionMask=group_bits,
            ),
            yade.InteractionLoop(
                self.model.geometry_functors(),
                [self.model.physics_functor()],
                [self.model.law_functor()],
            ),
        ]
        O.dt = self.time_step

    def fetch(self):
        """Takes hold of YADE's objects, anew after another state was loaded."""
        self.newton, self.resetter, self.collider, self.loop = O.engines
        self.law_functor = self.loop.lawDispatcher.functors[0]
        self.states = [O.bodies[i].state if O.bodies[i] else None for i in self.sphere_ids]

    # --- Stepping -------------------------------------------------------------------------------

    def compute_forces(self):
        """Forces of this moment, while the springs of contacts grow by next to nothing."""
        O.dt = GLANCE * self.time_step  # not by 0, which YADE divides by
        self.resetter()
        self.collider()
        self.loop()
        O.dt = self.time_step

    def start(self):
        """To be called once, before the first step."""
        self.compute_forces()
        self._shift_velocities(-0.5 * self.time_step)

    def step(self):
        O.step()
        self.steps += 1
        for body in self.bodies:
            if body.velocity[0] or body.velocity[1] or body.velocity[2]:
                for axis in range(3):
                    body.displacement[axis] += self.time_step * body.velocity[axis]

    def time(self):
        return self.steps * self.time_step

    def _shift_velocities(self, duration):
        for sphere_id, state, mass in zip(self.sphere_ids, self.states, self.masses):
            if state is None or state.blockedDOFs:
                continue
            acceleration = O.forces.f(sphere_id) / mass + self.newton.gravity
            state.vel += duration * acceleration
            state.angVel += duration / state.inertia[0] * O.forces.t(sphere_id)

    # --- Bodies ---------------------------------------------------------------------------------

    def find(self, name):
        return next(body for body in self.bodies if body.name == name)

    def set_velocity(self, body, velocity):
        body.velocity = list(velocity)
        vector = yade.Vector3(*velocity)
        for body_id in body.ids:
            O.bodies[body_id].state.vel = vector

    def place(self, body, height):
        """Puts a plane or a mesh, at its lowest point, to a height; displacements begin there."""
        if body.kind == "plane":
            body.height = height
            if body.in_play:
                for body_id in body.ids:
                    O.bodies[body_id].state.pos[2] = height
            else:
                self.put_plane(body)
        else:
            rise = height - body.present_height()
            for body_id in body.ids:
                O.bodies[body_id].state.pos[2] += rise
            body.height = height
        body.displacement = [0.0, 0.0, 0.0]

    def remove(self, body):
        body.removed = True
        body.velocity = [0.0, 0.0, 0.0]
        for body_id in body.ids:
            O.bodies.erase(body_id)
        body.ids = []

    def force_on(self, body):
        """Of the particles on it [N]."""
        if len(body.ids) > MANY:
            return [utils.sumForces(body.ids, axis) for axis in AXES]
        total = [0.0, 0.0, 0.0]
        for body_id in body.ids:
            force = O.forces.f(body_id)
            for axis in range(3):
                total[axis] += force[axis]
        return total

    # --- State ----------------------------------------------------------------------------------

    def into_yade(self, position):
        return yade.Vector3(*[x - o for x, o in zip(position, self.origin)])

    def top(self):
        """Highest point of any particle [m]."""
        return self.origin[2] + max(
            state.pos[2] + radius for state, radius in zip(self.states, self.radii) if state
        )

    def kinetic_energy(self):
        """Of the free particles, without the affine motion of a deforming cell [J]."""
        energy = utils.kineticEnergy()
        for body, ids in zip(self.bodies[-len(self.group_ids) :], self.group_ids):
            speed2 = sum(v * v for v in body.velocity)
            if speed2 > 0:
                energy -= 0.5 * speed2 * sum(O.bodies[i].state.mass for i in ids)
        return energy

    def elastic_energy(self):
        return self.model.elastic_energy(self.law_functor)

    def max_overlap(self):
        """Largest overlap of two spheres over R* [-]."""
        return 2 * utils.maxOverlapRatio()

    def lost(self):
        """How many particles are beyond an open side, or nowhere."""
        count = 0
        for state in self.states:
            if state is None:
                continue
            position = state.pos
            for axis in range(3):
                x = position[axis] + self.origin[axis]
                here = math.isfinite(x)
                if here and self.sides[axis] == "open":
                    here = self.lower[axis] <= x <= self.upper[axis]
                if not here:
                    count += 1
                    break
        return count

    def remove_leavers(self):
        """Takes away what has passed an outflow side."""
        for axis, side in enumerate(self.sides):
            if side != "outflow":
                continue
            for place, state in enumerate(self.states):
                if state is None or self.lower[axis] <= state.pos[axis] <= self.upper[axis]:
                    continue
                O.bodies.erase(self.sphere_ids[place])
                self.states[place] = None
                self.leavers += 1

    def packing(self, velocity_of_images=None):
        """Rows [id, radius, x, y, z, vx, vy, vz, wx, wy, wz] of this moment, by id."""
        half = 0.5 * self.time_step
        gravity = self.newton.gravity
        rows = []
        for place, state in enumerate(self.states):
            if state is None:
                continue
            sphere_id = self.sphere_ids[place]
            position, velocity, spin = state.pos, state.vel, state.angVel
            if not state.blockedDOFs:
                velocity = velocity + half * (O.forces.f(sphere_id) / self.masses[place] + gravity)
                spin = spin + half / state.inertia[0] * O.forces.t(sphere_id)
            rows.append(
                [
                    self.numbers[place],
                    self.radii[place],
                    *[x + o for x, o in zip(position, self.origin)],
                    *velocity,
                    *spin,
                ]
            )
        rows.sort(key=lambda row: row[0])
        return rows


AXES = [yade.Vector3(1, 0, 0), yade.Vector3(0, 1, 0), yade.Vector3(0, 0, 1)]
