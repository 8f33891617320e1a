"""Presses a body down on the bed with a force, by its velocity along z."""

INTEGRAL_FROM = 0.5  # relative error of the force below which it gathers


class Servo:
    """v = −(P e + ∫ P e dt/T), e = 1 − F/F_target, F the particles' force upward; as the embedded
    engine has it."""

    def __init__(self, scene, body):
        self.scene = scene
        self.body = body
        lower, upper = scene.domain["lower"], scene.domain["upper"]
        self.area = (upper[0] - lower[0]) * (upper[1] - lower[1])
        self.integral = 0.0

    def aim(self, stage, gains, bed_height):
        """`gains`: "speed" P [m/s], see servo_gain.h, and "kappa" [-] of the stress."""
        self.stress = stage["stress"]
        self.target = self.stress * self.area
        self.speed = gains["speed"]
        self.max_velocity = stage["max_velocity"]
        self.integral = max(-self.speed, min(self.integral, self.speed))
        # Ten times what the bed takes to answer: its stress grows by about 1.5 kappa sigma per strain.
        self.integral_time = 10 * bed_height / (1.5 * gains["kappa"] * self.speed)

    def control(self, force):
        error = 1 - force[2] / self.target
        if abs(error) < INTEGRAL_FROM or error * self.integral < 0:
            self.integral += self.speed * error * self.scene.time_step / self.integral_time
            self.integral = max(-self.speed, min(self.integral, self.speed))
        wish = self.speed * error + self.integral
        velocity = -max(-self.max_velocity, min(wish, self.max_velocity))
        self.scene.set_velocity(self.body, [*self.body.velocity[:2], velocity])
