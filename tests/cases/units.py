"""Functional mock-up units in tests: opened by fmpy, called function by function."""

import contextlib
import zipfile

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.simulation import simulate_fmu

WAYS = {(3, "cs"): FMU3Slave, (3, "me"): FMU3Model, (2, "cs"): FMU2Slave, (2, "me"): FMU2Model}


class Unit:
    """An instance, asked by names."""

    def __init__(self, path, folder, way="cs"):
        folder.mkdir(exist_ok=True)
        with zipfile.ZipFile(path) as archive:
            archive.extractall(folder)
        told = fmpy.read_model_description(str(folder))
        self.fmi = int(told.fmiVersion[0])
        self.references = {v.name: v.valueReference for v in told.modelVariables}
        kind = told.coSimulation if way == "cs" else told.modelExchange
        self.own = WAYS[self.fmi, way](
            guid=told.guid, unzipDirectory=str(folder), modelIdentifier=kind.modelIdentifier, instanceName="one"
        )
        self.said = []
        self.own.instantiate(**({"logMessage": self._heard} if self.fmi == 3 else {}))

    def _heard(self, environment, status, category, message):
        self.said.append(message.decode())

    def begin(self, at=0.0, way="cs"):
        if self.fmi == 2:
            self.own.setupExperiment(startTime=at)
            self.own.enterInitializationMode()
        else:
            self.own.enterInitializationMode(startTime=at)
        self.own.exitInitializationMode()
        if way == "me":
            self.own.enterContinuousTimeMode()

    def get(self, name, size=1):
        if self.fmi == 2:
            return np.array(self.own.getReal([self.references[name]]))
        return np.array(self.own.getFloat64([self.references[name]], nValues=size))

    def set(self, name, *values):
        if self.fmi == 2:
            return self.own.setReal([self.references[name]], list(values))
        return self.own.setFloat64([self.references[name]], list(values))

    def derivative(self, unknowns, knowns, seed):
        of = [[self.references[name] for name in names] for names in (unknowns, knowns)]
        return np.array(self.own.getDirectionalDerivative(*of, list(seed)))


@contextlib.contextmanager
def opened(path, folder, way="cs", at=0.0):
    """An instance in its mode of steps, or of continuous time."""
    unit = Unit(path, folder, way)
    try:
        unit.begin(at, way)
        yield unit
    finally:
        unit.own.terminate()
        unit.own.freeInstance()


def simulated(path, way, stop, interval, inputs, **options):
    """Time histories by fmpy, inputs held at their values."""
    kinds = [("time", float), *((name, float) for name in inputs)]
    signals = np.array([(0.0, *inputs.values()), (stop, *inputs.values())], dtype=kinds)
    kind = {"cs": "CoSimulation", "me": "ModelExchange"}[way]
    return simulate_fmu(
        str(path), fmi_type=kind, start_time=0.0, stop_time=stop, output_interval=interval, input=signals, **options
    )
