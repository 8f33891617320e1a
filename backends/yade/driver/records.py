"""The result file: one JSON object a line, each with its kind under "record".

start   version
stage   index, step: a stage begins
alive   step: written now and then, so that a run that is stopped says how far it came
moment  name, time, packing, walls, cell
series  wall, time, height, force: one for each body whose history is kept
cell    time, strain, lengths, stress: history of a periodic cell
end     reason, message, and diagnostics; a file without it is of a run that died
"""

import json
import time

ALIVE_EVERY = 2.0  # [s] of wall clock


class Outcome(Exception):
    """Ends the run with a reason code of powdercal's."""

    def __init__(self, reason, message, **diagnostics):
        super().__init__(message)
        self.reason = reason
        self.message = message
        self.diagnostics = diagnostics


class Records:
    def __init__(self, stream):
        self._stream = stream
        self._last = time.monotonic()

    def write(self, record, **members):
        try:
            text = json.dumps({"record": record, **members}, allow_nan=False)
        except ValueError:
            raise Outcome("unstable", "positions, velocities or forces are not numbers") from None
        self._stream.write(text + "\n")
        self._stream.flush()

    def alive(self, step):
        now = time.monotonic()
        if now - self._last > ALIVE_EVERY:
            self._last = now
            self.write("alive", step=step)
