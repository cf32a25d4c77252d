"""Hears the alarm of an FMI 3.0 detector as an event, at its sample within a long communication step.

    python alarm_clock.py SteeringFaultDetector.fmi3.fmu run.csv

With Event Mode and early return allowed, fmi3DoStep returns at the sample at which the alarm is raised or ends; the
clock `alarm_change` ticks then. The table is that of detect.py. Needs fmpy.
"""

import shutil
import sys

import fmpy
from detect import INPUTS, read
from fmpy.fmi3 import FMU3Slave

STEP_S = 0.1  # ten samples of the default design


def instantiate(fmu, description, folder):
    instance = FMU3Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="detector",
    )
    instance.instantiate(eventModeUsed=True, earlyReturnAllowed=True)
    return instance


def events(fmu, table):
    """(time, alarm, J) at each tick of the clock."""
    description = fmpy.read_model_description(fmu)
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    inputs, folder = read(table), fmpy.extract(fmu)
    detector = instantiate(fmu, description, folder)
    try:
        detector.enterInitializationMode()
        detector.exitInitializationMode()
        detector.enterStepMode()  # after initialisation an instance with events is in Event Mode
        rows, end = iter(inputs), inputs["time"][-1]
        point = 0
        while (time := point * STEP_S) + STEP_S <= end:
            row = next(row for row in rows if row["time"] >= time - 1e-9)
            detector.setFloat64([references[name] for name in INPUTS], [row[name] for name in INPUTS])
            point += 1
            while True:
                event, _, early, reached = detector.doStep(time, point * STEP_S - time)
                if event:
                    detector.enterEventMode()
                    if detector.getClock([references["alarm_change"]])[0]:
                        (when,) = detector.getFloat64([references["alarm_change_time"]])
                        (j,) = detector.getFloat64([references["J_rms"]])
                        yield when, bool(detector.getBoolean([references["alarm"]])[0]), j
                    detector.updateDiscreteStates()
                    detector.enterStepMode()
                if not early:
                    break
                time = reached  # the rest of the step
    finally:
        detector.terminate()
        detector.freeInstance()
        shutil.rmtree(folder, ignore_errors=True)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    for when, alarm, j in events(*sys.argv[1:]):
        print(f"{when:8.3f} s: {'alarm' if alarm else 'over'}, J = {j:.2e}")


if __name__ == "__main__":
    main()
