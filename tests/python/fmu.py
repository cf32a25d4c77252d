"""An FMU in the hands of fmpy: variables by name, log messages kept, steps recorded.

Conventions: times and steps in s, values in the units of modelDescription.xml.
"""

from contextlib import contextmanager
from ctypes import byref

import fmpy
import numpy as np
from fmpy import calloc, free, fmi2
from fmpy.fmi2 import FMU2Slave
from fmpy.logging import addLoggerProxy

SETTERS = {"Real": "setReal", "Integer": "setInteger", "Enumeration": "setInteger", "Boolean": "setBoolean"}
GETTERS = {"Real": "getReal", "Integer": "getInteger", "Enumeration": "getInteger",
           "Boolean": "getBoolean", "String": "getString"}  # fmt: skip


class FMU2Instance(FMU2Slave):  # fmpy reads the version of FMI from the beginning of this name
    """A Co-Simulation instance whose variables have names."""

    def __init__(self, description, folder, guid, name):
        super().__init__(
            guid=guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.variables = {v.name: v for v in description.modelVariables}
        self.messages = []  # (status, category, text)

    def complaints(self):
        """Texts of the log messages that are warnings or worse."""
        return [text for status, _, text in self.messages if status > 0]

    def open(self, missing=()):
        """Instantiates with logging on, callbacks `missing` NULL; an FMU that refuses raises."""

        def logger(environment, name, status, category, message):
            self.messages.append((status, category.decode(), message.decode()))

        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(logger)
        callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(free)
        addLoggerProxy(byref(callbacks))
        for callback in missing:
            setattr(callbacks, callback, type(getattr(callbacks, callback))())
        self.instantiate(callbacks=callbacks, loggingOn=True)

    def set(self, values):
        """Sets variables from a mapping of names to values."""
        for kind, setter in SETTERS.items():
            chosen = {n: v for n, v in values.items() if self.variables[n].type == kind}
            if chosen:
                references = [self.variables[n].valueReference for n in chosen]
                getattr(self, setter)(references, list(chosen.values()))

    def get(self, names):
        """Values of variables, by name."""
        found = {}
        for kind, getter in GETTERS.items():
            chosen = [n for n in names if self.variables[n].type == kind]
            if chosen:
                references = [self.variables[n].valueReference for n in chosen]
                found |= zip(chosen, getattr(self, getter)(references), strict=True)
        return found

    def initialise(self, values=None, start_time=0.0, stop_time=None):
        """From instantiated to the first communication point."""
        self.setupExperiment(startTime=start_time, stopTime=stop_time)
        self.set(values or {})
        self.enterInitializationMode()
        self.exitInitializationMode()

    def record(self, inputs, outputs, step, start_time=0.0):
        """Steps through rows of `inputs` (name to array); `outputs` after each step, as arrays."""
        rows = zip(*inputs.values(), strict=True)
        records = {name: [] for name in outputs}
        for k, row in enumerate(rows):
            self.set(dict(zip(inputs, row, strict=True)))
            self.doStep(start_time + k * step, step)
            for name, value in self.get(outputs).items():
                records[name].append(value)
        return {name: np.array(values) for name, values in records.items()}


class Fmu:
    """A packaged FMU, unpacked."""

    def __init__(self, path, folder):
        self.path = path
        self.folder = fmpy.extract(str(path), unzipdir=str(folder))
        self.description = fmpy.read_model_description(self.folder)

    @contextmanager
    def instance(self, guid=None, name="instance", missing=()):
        """An instance, freed at the end; callbacks `missing` are NULL."""
        instance = FMU2Instance(self.description, self.folder, guid or self.description.guid, name)
        instance.open(missing)
        try:
            yield instance
        finally:
            instance.freeInstance()
