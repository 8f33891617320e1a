"""Goes through the stages of a program, looks after its health, and records.

What each stage does is said at the stages of backends/program.h; averages are taken over the same steps
as in the embedded engine.
"""

import copy
import math

from yade import O

from health import Health
from records import Outcome
from recorder import Recorder
from scene import Scene
from servo import Servo

SERIES_STEPS = 100
HEALTH_STEPS = 500
STRESS_TOLERANCE = 0.05


class Runner:
    def __init__(self, job, records):
        self.job = job
        self.program = job["program"]
        self.records = records
        self.stage = None
        self.saved = {}
        self.held_velocity = None
        self.kinetic_energy_ratio = 0.0

    def run(self):
        reason, message, diagnostics = "ok", "", {}
        self.scene = None
        try:
            self._run_stages()
        except Outcome as outcome:
            reason, message = outcome.reason, outcome.message
            diagnostics = outcome.diagnostics
        self._finish(reason, message, diagnostics)

    def _run_stages(self):
        self.scene = Scene(self.job)
        self.servo = None
        self.health = Health(self.program, self.scene)
        self.recorder = Recorder(self.scene, self.job["servo_wall"])
        self.scene.start()
        self.health.begin()
        for index, stage in enumerate(self.program["stages"]):
            self.records.write("stage", index=index, step=self.scene.steps)
            self.index = index
            self.held_velocity = None
            getattr(self, "_do_" + stage["stage"])(stage)

    def _steps_of(self, duration):
        return max(1, round(min(duration / self.scene.time_step, 1e15)))

    def _run_steps(self, count):
        """Steps with their records; forces of moments are means over these."""
        scene, recorder, servo = self.scene, self.recorder, self.servo
        recorder.begin()
        while count > 0:
            piece = min(count, HEALTH_STEPS)
            for _ in range(piece):
                scene.step()
                recorder.record(servo)
                if servo:
                    servo.control(recorder.force_of(servo.body))
            count -= piece
            scene.remove_leavers()
            self.health.check()
            self.records.alive(scene.steps)

    # --- Stages ---------------------------------------------------------------------------------

    def _do_insert(self, stage):
        pass  # the particles are placed already

    def _do_settle(self, stage):
        scene = self.scene
        interval = self._steps_of(stage["check_interval"])
        gravity = math.hypot(*self.program["gravity"])
        weight = scene.total_mass * gravity * scene.mean_diameter
        begin = scene.time()
        while scene.time() - begin < stage["max_duration"]:
            self._run_steps(interval)
            enough = scene.time() - begin >= stage["min_duration"]
            if enough and scene.kinetic_energy() < stage["kinetic_energy_ratio"] * weight:
                break
        self._moment("settle")

    def _do_servo(self, stage):
        scene = self.scene
        first = self.servo is None
        body = scene.find(stage["wall"])
        above = scene.top() + 0.03 * scene.mean_diameter
        if first:
            scene.place(body, above)
            self.servo = Servo(scene, body)
        bed = max(above - scene.domain["lower"][2], scene.mean_diameter)
        self.servo.aim(stage, self.job["servos"][self.index], bed)
        self.health.drive(stage["max_velocity"])
        self.health.load(stage["stress"])
        self.recorder.restart_windows()
        for _ in range(self._steps_of(stage["max_duration"]) // SERIES_STEPS + 1):
            self._run_steps(SERIES_STEPS)
            load = self.recorder.series[body.name]["force"][-1][2] / self.servo.target
            if load > 0.9 and (first or load < 1.1):
                break
        self._moment("servo")

    def _do_hold(self, stage):
        scene = self.scene
        steps = self._steps_of(stage["window"])
        window = steps * scene.time_step
        loops = self._steps_of(stage["max_duration"]) // steps + 1
        target = self.servo.stress
        before = 0.0
        for _ in range(loops):
            self.recorder.begin_hold()
            self._run_steps(steps)
            stress, height = self.recorder.held(self.servo.area)
            change = abs(height / before - 1) if before else 1.0
            error = abs(stress / target - 1)
            quiet = scene.kinetic_energy() / max(scene.elastic_energy(), 1e-300)
            self.held_velocity = (height - before) / window if before else 0.0
            before = height
            self.kinetic_energy_ratio = quiet
            at_rest = change < stage["strain_rate"] * window
            if at_rest and error < stage["stress_tolerance"]:
                if quiet < stage["kinetic_energy_ratio"]:
                    self._moment("hold")
                    return
        self._moment("hold")
        if error > STRESS_TOLERANCE:
            raise Outcome(
                "not_quasi_static", f"the wall bears {stress:.4g} Pa instead of {target:.4g} Pa"
            )
        raise Outcome(
            "not_quasi_static",
            f"the bed still moves after {stage['max_duration']:.3g} s under load: stress "
            f"{stress:.4g} Pa, relative change of height {change:.2g} in {window:.2g} s, kinetic to "
            f"elastic energy {quiet:.2g}",
        )

    def _do_advance(self, stage):
        scene = self.scene
        for motion in stage["motions"]:
            self._set_velocity(motion["body"], motion["velocity"])
            self.health.drive(math.hypot(*motion["velocity"]))
        left = self._steps_of(stage["duration"])
        every = stage["packing_every"] or left
        while left > 0:
            count = min(left, every)
            self._run_steps(count)
            left -= count
            self._moment(stage["name"])
        for motion in stage["motions"]:
            self._set_velocity(motion["body"], [0.0, 0.0, 0.0])

    def _set_velocity(self, name, velocity):
        body = self.scene.find(name)
        if self.servo and body is self.servo.body:  # it keeps its own along z
            velocity = [velocity[0], velocity[1], body.velocity[2]]
        self.scene.set_velocity(body, velocity)

    def _do_remove(self, stage):
        self.scene.remove(self.scene.find(stage["body"]))

    # --- Records --------------------------------------------------------------------------------

    def _moment(self, name):
        scene = self.scene
        walls = {}
        for body in scene.bodies:
            if body.removed or not body.in_play:
                continue
            velocity = body.velocity[2]
            if self.servo and body is self.servo.body and self.held_velocity is not None:
                velocity = self.held_velocity
            walls[body.name] = {
                "height": body.present_height(),
                "displacement": body.displacement,
                "force": self.recorder.mean_force(body),
                "velocity": velocity,
            }
        self.records.write(
            "moment", name=name, time=scene.time(), packing=scene.packing(), walls=walls, cell=None
        )

    def _finish(self, reason, message, diagnostics):
        figures = {}
        scene = self.scene
        if scene is not None and scene.steps > 0:
            elastic = scene.elastic_energy()
            kinetic = scene.kinetic_energy()
            figures = {
                "steps": scene.steps,
                "leavers": scene.leavers,
                "kinetic_energy": kinetic,
                "kinetic_energy_ratio": kinetic / elastic if elastic > 0 else 0.0,
                "max_overlap": scene.max_overlap(),
                "elastic_energy": elastic,
                "contacts": O.interactions.countReal(),
            }
            figures = {k: v for k, v in figures.items() if math.isfinite(v)}
            self.recorder.write(self.records)
        figures.update(diagnostics)
        self.records.write("end", reason=reason, message=message, **figures)
