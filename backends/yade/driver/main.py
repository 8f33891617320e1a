"""Runs one program of powdercal with YADE.

    python3 -I main.py YADE_MODULES JOB RESULT

YADE_MODULES is the folder that holds the Python package `yade`; JOB is the JSON file that the C++ side
wrote (program, placed particles, gains of the servos); RESULT becomes a file of JSON records, one a
line (records.py). Whatever happens in the simulation is an outcome in that file and exit status 0. Any
other status means that YADE or this driver failed; the reason is then on the standard error.
"""

import json
import os
import sys


def main(modules, job_file, result_file):
    # Before YADE is imported: threads that wait for one another are slower than one alone.
    os.environ["OMP_NUM_THREADS"] = "1"
    sys.path.insert(0, modules)
    sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
    with open(job_file, encoding="utf-8") as stream:
        job = json.load(stream)
    import yade

    # A crash is to end the process by its signal, not to start a debugger.
    yade.O.disableGdb()
    from records import Records
    from stages import Runner

    with open(result_file, "w", encoding="utf-8") as stream:
        records = Records(stream)
        records.write("start", version=yade.config.version)
        Runner(job, records).run()


if __name__ == "__main__":
    main(*sys.argv[1:])
