"""A periodic cell that is deformed, as the stage Deform of backends/program.h says.

YADE deforms the cell about its origin and adds the affine velocities to the particles' own; its
equation of motion is m dv'/dt = F for velocities v' without the affine part. Shear tilts the cell.
Once it leans by half its length, it is replaced by the one that leans the other way: the same
lattice of images, so that contacts stay as they are (YADE's `flipCell` tilts other edges as well).
"""

import yade
from yade import O, utils
from yade.minieigenHP import Matrix3, Vector3i

from records import Outcome

STRESS_EVERY = 20  # [steps]
STRESS_WEIGHT = 0.3
MOST_PACE = 6
# [largest diameter] YADE wants particles, bounds and all, below half of a period.
LEAST_WIDTH = 2.05


def matrix_rows(matrix):
    return [[matrix[a, b] for b in range(3)] for a in range(3)]


class Cell:
    def __init__(self, scene):
        self.scene = scene
        lower, upper = scene.domain["lower"], scene.domain["upper"]
        self.centre = [0.5 * (l + u) for l, u in zip(lower, upper)]
        self.drive = None
        self.rates = [0.0, 0.0, 0.0]  # [1/s] of the edges
        self.shear_rate = 0.0  # [1/s]
        self.strain = 0.0
        self.flips = 0
        self.filtered = None  # [Pa] along the edges
        self.filtered_at = -1  # state's step at the filter's end, while the cell is not driven
        self.stress = [[0.0] * 3] * 3

    def remember(self):
        return dict(self.__dict__, rates=list(self.rates), filtered=list(self.filtered or []))

    def go_back_to(self, saved):
        flips = self.flips
        self.__dict__.update(saved, rates=list(saved["rates"]), filtered=list(saved["filtered"]))
        self.flips = flips

    # --- Stages ---------------------------------------------------------------------------------

    def start(self, deform):
        self.drive = deform
        shear = deform["shear_rate"]
        self.pace = abs(shear) if shear != 0 else deform["relaxation_rate"]
        if self.filtered_at != self.scene.state_steps:
            stress = self.measure_stress()
            self.filtered = [stress[axis][axis] for axis in range(3)]
        self._set_rates(self._controlled_rates(), shear)

    def stop(self):
        self.drive = None
        self._set_rates([0.0, 0.0, 0.0], 0.0)
        self.filtered_at = self.scene.state_steps

    def after_step(self):
        """Returns whether the stress was measured."""
        self.strain += self.scene.time_step * self.shear_rate
        if self.drive is None or self.scene.state_steps % STRESS_EVERY != 0:
            return False
        if min(self.lengths()) < LEAST_WIDTH * self.scene.largest_diameter:
            raise Outcome("unstable", "the periodic cell has shrunk below four particle radii")
        self.stress = self.measure_stress()
        for axis in range(3):
            change = self.stress[axis][axis] - self.filtered[axis]
            self.filtered[axis] += STRESS_WEIGHT * change
        self._set_rates(self._controlled_rates(), self.drive["shear_rate"])
        self._keep_upright()
        return True

    # --- The edges ------------------------------------------------------------------------------

    def _controlled_rates(self):
        rates = []
        for edge, stress in zip(self.drive["edges"], self.filtered):
            rate = edge["value"]
            if edge["kind"] == "stress":
                error = self.drive["gain"] * (stress - edge["value"]) / edge["value"]
                rate = self.pace * max(-MOST_PACE, min(error, MOST_PACE))
            rates.append(rate)
        return rates

    def _set_rates(self, rates, shear_rate):
        """From the next step on: YADE then gives particles the change of the affine velocity."""
        self._turn(shear_rate - self.shear_rate)
        self.rates, self.shear_rate = list(rates), shear_rate
        O.cell.velGrad = Matrix3(rates[0], 0, shear_rate, 0, rates[1], 0, 0, 0, rates[2])

    def _turn(self, change):
        """Takes away in advance the spin that YADE gives particles as the vorticity changes."""
        if change == 0:
            return
        spin = yade.Vector3(0, 0.5 * change, 0)
        for state in self.scene.states:
            state.angVel -= spin

    def _keep_upright(self):
        size = O.cell.hSize
        if abs(size[0, 2]) <= 0.5 * size[0, 0]:
            return
        turns = round(size[0, 2] / size[0, 0])
        size[0, 2] -= turns * size[0, 0]
        O.cell.hSize = size
        O.interactions.eraseNonReal()  # the new collider finds them again, between the right images
        for contact in O.interactions:
            x, y, z = contact.cellDist
            contact.cellDist = Vector3i(x + turns * z, y, z)
        self.flips += 1
        self.scene.renew_collider()

    # --- State ----------------------------------------------------------------------------------

    def lengths(self):
        size = O.cell.hSize
        return [size[axis, axis] for axis in range(3)]

    def lower(self):
        return [c - 0.5 * length for c, length in zip(self.centre, self.lengths())]

    def measure_stress(self):
        """Rows x, y, z [Pa], compressive positive: of the contacts and of the motion."""
        return matrix_rows(-utils.getStress() - utils.getTotalDynamicStress())

    def state(self):
        """CellState of backends/trace.h."""
        size = O.cell.hSize
        return {
            "lower": self.lower(),
            "upper": [c + 0.5 * length for c, length in zip(self.centre, self.lengths())],
            "shear_offset": size[0, 2],
            "shear_rate": self.shear_rate,
            "stress": self.measure_stress(),
        }

    def into_box(self, position, velocity):
        """The image within the upright box, relative to its lower corner, with that image's
        velocity relative to the box's centre."""
        size = O.cell.hSize
        x, v = list(position), list(velocity)
        middle = [0.5 * size[axis, axis] for axis in range(3)]
        v[0] -= self.rates[0] * middle[0] + self.shear_rate * middle[2]
        v[1] -= self.rates[1] * middle[1]
        v[2] -= self.rates[2] * middle[2]
        for axis in (2, 1, 0):
            length = size[axis, axis]
            turns = x[axis] // length
            if turns == 0:
                continue
            x[axis] -= turns * length
            v[axis] -= turns * self.rates[axis] * length
            if axis == 2:
                x[0] -= turns * size[0, 2]
                v[0] -= turns * (self.shear_rate * length + self.rates[0] * size[0, 2])
        return x, v
