"""Averages over steps: forces on bodies, and their histories in windows of 100 steps."""

SERIES_STEPS = 100


def add(total, force):
    total[0] += force[0]
    total[1] += force[1]
    total[2] += force[2]


class Recorder:
    def __init__(self, scene, servo_wall):
        self.scene = scene
        self.servo_wall = servo_wall
        self.series = {}  # the servo's wall first, then meshes and groups
        names = [body.name for body in scene.bodies if body.kind != "plane"]
        if servo_wall is not None:
            names = [servo_wall] + [name for name in names if name != servo_wall]
        for name in names:
            self.series[name] = {"time": [], "height": [], "force": []}
        self._forces = {}  # of this step
        self.begin()
        self.begin_hold()
        self.restart_windows()

    def begin(self):
        """The means of moments begin anew."""
        self._sums = {body.name: [0.0, 0.0, 0.0] for body in self.scene.bodies}
        self._samples = 0

    def begin_hold(self):
        self._hold_force = 0.0
        self._hold_height = 0.0
        self._hold_steps = 0

    def restart_windows(self):
        self._window = {name: [[0.0, 0.0, 0.0], 0.0] for name in self.series}
        self._window_steps = 0

    def record(self, servo):
        """The step that was just done."""
        self._samples += 1
        self._window_steps += 1
        for body in self.scene.bodies:
            if body.removed or not body.in_play:
                continue
            force = self.scene.force_on(body)
            self._forces[body.name] = force
            add(self._sums[body.name], force)
            window = self._window.get(body.name)
            if window is not None:
                add(window[0], force)
                window[1] += body.present_height()
        if servo is not None:
            self._hold_force += self._forces[servo.body.name][2]
            self._hold_height += servo.body.present_height()
            self._hold_steps += 1
        if self._window_steps == SERIES_STEPS:
            self._end_windows()

    def force_of(self, body):
        return self._forces[body.name]

    def held(self, area):
        """Mean stress [Pa] and height [m] of the servo's body since begin_hold()."""
        steps = self._hold_steps
        return self._hold_force / steps / area, self._hold_height / steps

    def mean_force(self, body):
        samples = max(1, self._samples)
        return [component / samples for component in self._sums[body.name]]

    def _end_windows(self):
        time = self.scene.time()
        for name, (force, height) in self._window.items():
            body = self.scene.find(name)
            if body.removed or not body.in_play:
                continue
            series = self.series[name]
            series["time"].append(time)
            series["height"].append(height / SERIES_STEPS)
            series["force"].append([component / SERIES_STEPS for component in force])
        self.restart_windows()

    def write(self, records):
        for name, series in self.series.items():
            records.write("series", wall=name, **series)
