"""The connected system SteeringFaultSystem.ssp (SSP 1.0) and the reference results inside the FMUs.

What fmpy's SSP support does, and what follows for these tests
- It reads structure and parameter sets and validates both against the schemas of SSP 1.0.
- `simulate_ssp` applies no parameter binding of the file by itself: it takes a parameter set as an
  argument, whose names are `<component>.<variable>`. The one in the file is read and passed.
- Units are not evaluated, and an input without a function stays 0.
- Every connection passes its value on after the step: all inputs act one communication step later
  than they are given, and are 0 in the first step. The detector starts with v_x = 0 m/s there, outside
  its range, and arms itself one step later.
- Results are recorded at the beginning of a step and hold what was found at its end.
"""

import io
import shutil
import subprocess
import sys
import zipfile
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
import scenario
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import find_components, get_connections, read_ssd, read_ssv
from fmu import Fmu
from reference import MONITORING, OUT_OF_RANGE

PARAMETERS = "resources/SteeringFaultSystem.ssv"
SYSTEM_INPUTS = ["u.T_eng", "u.delta", "fault", "disturbance.side_force", "disturbance.yaw_moment"]
SYSTEM_OUTPUTS = ["residual.v_x", "residual.r", "J_rms", "J_th", "alarm", "state"]
SYSTEM_OUTPUTS += ["fault_estimate", "fault_estimate_bound"]
NAMES = ["SteeringFaultDetector", "VehiclePlant"]


@pytest.fixture(scope="module")
def system(fixtures):
    return fixtures / "SteeringFaultSystem.ssp"


@pytest.fixture(scope="module")
def structure(system):
    return read_ssd(str(system), validate=True)


@pytest.fixture(scope="module")
def parameters(system):
    return read_ssv(str(system), resource=PARAMETERS, validate=True)


def in_system(variable):
    return variable.replace(".", "_")


def name(connector):
    return f"{connector.parent.name}.{connector.name}"


def test_structure_follows_the_schema_and_connects_everything(structure):
    assert (structure.version, structure.name) == ("1.0", "SteeringFaultSystem")
    components = {c.name: c.source for c in find_components(structure.system)}
    assert components == {
        "plant": "resources/VehiclePlant.fmu",
        "detector": "resources/SteeringFaultDetector.fmu",
    }
    kinds = {c.name: c.kind for c in structure.system.connectors}
    expected = {in_system(n): "input" for n in SYSTEM_INPUTS}
    assert kinds == expected | {in_system(n): "output" for n in SYSTEM_OUTPUTS}
    system_name = structure.system.name
    connections = {(name(a), name(b)) for a, b in get_connections(structure.system)}
    assert connections == (
        {(f"{system_name}.{in_system(n)}", f"plant.{n}") for n in SYSTEM_INPUTS}
        | {(f"plant.{n}", f"detector.{n}") for n in ["v_x", "r"]}
        | {(f"{system_name}.{in_system(n)}", f"detector.{n}") for n in ["u.T_eng", "u.delta"]}
        | {(f"detector.{n}", f"{system_name}.{in_system(n)}") for n in SYSTEM_OUTPUTS}
    )


def test_rules_of_omsimulator_are_kept(system, reference):
    """What OMSimulator 2 asks of a system beyond the standard; no registry has the tool itself.

    A dot ends the name of a component, so that connectors of the system, and parameters set through them, have
    none. A system without a master of its own namespace's annotation is of no kind that it knows.
    """
    ssd = "{http://ssp-standard.org/SSP1/SystemStructureDescription}"
    ssc = "{http://ssp-standard.org/SSP1/SystemStructureCommon}"
    ssv = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"
    oms = "{https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd}"
    with zipfile.ZipFile(system) as archive:
        root = ElementTree.fromstring(archive.read("SystemStructure.ssd"))
        parameter_set = ElementTree.fromstring(archive.read(PARAMETERS))
    (structure,) = root.findall(f"{ssd}System")
    connectors = [c.get("name") for c in structure.findall(f"{ssd}Connectors/{ssd}Connector")]
    assert len(connectors) == len(set(connectors)) == len(SYSTEM_INPUTS) + len(SYSTEM_OUTPUTS)
    assert [name for name in connectors if "." in name] == []
    components = [c.get("name") for c in structure.findall(f"{ssd}Elements/{ssd}Component")]
    assert all("." not in name for name in [structure.get("name"), *components])
    for connection in structure.findall(f"{ssd}Connections/{ssd}Connection"):
        for end in ("start", "end"):
            is_of_component = connection.get(f"{end}Element") in components
            assert is_of_component or connection.get(f"{end}Connector") in connectors
    for parameter in parameter_set.findall(f"{ssv}Parameters/{ssv}Parameter"):
        component, dot, _ = parameter.get("name").partition(".")
        assert component in (components if dot else connectors), parameter.get("name")
    (annotation,) = structure.findall(f"{ssd}Annotations/{ssc}Annotation")
    assert annotation.get("type") == "org.openmodelica"
    (master,) = annotation.findall(f"{oms}Annotations/{oms}SimulationInformation/{oms}FixedStepMaster")
    assert master.get("description") == "oms-ma"
    assert float(master.get("stepSize")) == reference.period


def test_connectors_are_those_of_the_fmus(structure, system, tmp_path):
    fmpy.extract(str(system), unzipdir=str(tmp_path))
    for component in find_components(structure.system):
        description = fmpy.read_model_description(str(tmp_path / component.source))
        connectable = {v.name: v.causality for v in description.modelVariables
                       if v.causality in ("input", "output")}  # fmt: skip
        # What is left out keeps its start value.
        connectable.pop("enabled", None)
        assert {c.name: c.kind for c in component.connectors} == connectable


def test_fmus_inside_are_the_packaged_ones(system, fixtures):
    with zipfile.ZipFile(system) as archive:
        assert archive.namelist()[0] == "SystemStructure.ssd"
        for fmu in NAMES:
            assert archive.read(f"resources/{fmu}.fmu") == (fixtures / f"{fmu}.fmu").read_bytes()


def test_parameters_are_the_vehicle_and_actuator_of_the_design(structure, parameters, detector, design):
    binding = structure.system.parameterBindings
    assert [b.source for b in binding] == [PARAMETERS]
    values = {p.name: float(p.value) for p in parameters.parameters}
    vehicle = {n for n in values if n.startswith("plant.vehicle.")}
    names = [n.removeprefix("plant.") for n in sorted(vehicle)]
    with detector.instance() as instance:
        found = instance.get(names)
        assert set(names) == {n for n in instance.variables if n.startswith("vehicle.")}
    assert {n: values[f"plant.{n}"] for n in names} == found
    actuator = ["lag", "delay", "rate_limit", "angle_limit"]
    with detector.instance() as instance:
        found = instance.get([f"design.actuator.{n}" for n in actuator])
    assert [values[f"plant.actuator.{n}"] for n in actuator] == list(found.values())
    speeds = design["detector"]["model"]["range"]["v_x"]
    slowest, fastest = speeds["min"], speeds["max"]
    assert slowest < values["plant.initial.v_x"] < fastest
    assert set(values) - vehicle == {
        "u_T_eng", "plant.initial.v_x", "plant.initial.v_y", "plant.initial.r",
        *(f"plant.actuator.{n}" for n in actuator),
    }  # fmt: skip


def test_fault_is_detected_in_the_system(system, parameters, reference):
    values = {p.name: float(p.value) for p in parameters.parameters}
    speed, mass = values["plant.initial.v_x"], values["plant.vehicle.M_v"]

    def force(t):
        return mass * scenario.side_wind_m_per_s2(t)

    result = simulate_ssp(
        str(system),
        stop_time=scenario.DURATION_S - 0.5 * reference.period,
        step_size=reference.period,
        parameter_set=parameters,
        input={
            "u_T_eng": lambda t: values["u_T_eng"],
            "u_delta": lambda t: scenario.steering_angle_rad(t, speed),
            "fault": scenario.fault_rad,
            "disturbance_side_force": force,
            "disturbance_yaw_moment": lambda t: scenario.SIDE_WIND_LEVER_ARM_M * force(t),
        },
    )
    t = result["time"]
    assert len(t) == round(scenario.DURATION_S / reference.period)
    assert np.abs(result["plant.v_x"] - speed).max() < 0.5, "the parameter set was applied"
    assert result["alarm"].dtype == np.bool_ and result["state"].dtype == np.int32
    for output in SYSTEM_OUTPUTS:
        assert (result[in_system(output)] == result[f"detector.{output}"]).all(), output

    assert result["state"][0] == OUT_OF_RANGE and (result["state"][1:] == MONITORING).all()
    acts = scenario.FAULT_ONSET_S + reference.period  # one step after it is given
    first_alarm = t[result["alarm"]][0]
    assert acts <= first_alarm + 1e-6 <= acts + 0.10 + 2e-6
    assert result["alarm"][t > scenario.FAULT_ONSET_S + 0.5].all()


def test_the_manipulation_toolbox_makes_an_fmu_of_the_system_that_detects_the_fault(system, tmp_path, reference):
    """The toolbox reads no parameter set: the vehicle is the plant's own, the paper's at 15 m/s."""
    shutil.copy(system, tmp_path)
    code = "from fmu_manipulation_toolbox.cli.fmucontainer import fmucontainer; fmucontainer()"
    description = f"{system.name}:{reference.period}"
    result = subprocess.run(
        [sys.executable, "-c", code, "-container", description, "-fmu-directory", "."],
        capture_output=True, text=True, timeout=300, check=False, cwd=tmp_path,
    )  # fmt: skip
    report = result.stdout + result.stderr
    container = tmp_path / "SteeringFaultSystem.fmu"
    assert result.returncode == 0 and container.is_file(), report
    connected = [line for line in report.splitlines() if "is not connected" in line]
    # What the system leaves to its start value, and what nobody reads.
    assert len(connected) == 5 and sum("enabled" in line for line in connected) == 1, report

    variables = {v.name: v for v in fmpy.read_model_description(str(container)).modelVariables}
    assert {n for n, v in variables.items() if v.causality == "input"} == set(map(in_system, SYSTEM_INPUTS))
    assert {n for n, v in variables.items() if v.causality == "output"} == set(map(in_system, SYSTEM_OUTPUTS))

    speed, torque = 15.0, float(variables["u_T_eng"].start)
    times = np.arange(round(scenario.DURATION_S / reference.period)) * reference.period
    rows = [
        (t, torque, scenario.steering_angle_rad(t, speed), scenario.fault_rad(t)) for t in times
    ]
    columns = ["time", "u_T_eng", "u_delta", "fault"]
    inputs = np.array(rows, dtype=[(n, float) for n in columns])
    result = fmpy.simulate_fmu(
        str(container), stop_time=times[-1], step_size=reference.period, output_interval=reference.period,
        input=inputs, output=["alarm", "state", "J_rms", "J_th"],
        # Its own: fmpy else hands messages to the logger of an earlier instance, which is gone.
        logger=lambda *message: None,
    )  # fmt: skip
    t, alarm = result["time"], result["alarm"].astype(bool)
    assert not alarm[t < scenario.FAULT_ONSET_S].any()
    assert scenario.FAULT_ONSET_S < t[alarm][0] < scenario.FAULT_ONSET_S + 0.3
    assert (alarm == (result["J_rms"] >= result["J_th"]))[t < t[alarm][0] + 0.1].all()


def read_table(fmu, table):
    with zipfile.ZipFile(fmu) as archive:
        lines = io.StringIO(archive.read(f"extra/{table}").decode("ascii"))
    return np.genfromtxt(lines, delimiter=",", names=True, deletechars="")


@pytest.mark.parametrize("fmu", NAMES)
def test_reference_results_are_what_an_importer_gets(fixtures, tmp_path, fmu):
    path = fixtures / f"{fmu}.fmu"
    inputs, expected = (read_table(path, f"{fmu}{end}") for end in ("_in.csv", "_ref.csv"))
    unpacked = Fmu(path, tmp_path)
    names = expected.dtype.names
    assert names == ("time", *(o.variable.name for o in unpacked.description.outputs))
    assert (inputs["time"] == expected["time"]).all()

    step = float(unpacked.description.defaultExperiment.stepSize)
    with unpacked.instance() as instance:
        instance.initialise({n: inputs[n][0] for n in inputs.dtype.names[1:]})
        found = instance.get(names[1:])
        assert [found[n] for n in names[1:]] == [expected[n][0] for n in names[1:]]
        drive = {n: inputs[n][:-1] for n in inputs.dtype.names[1:]}
        record = instance.record(drive, names[1:], step)
    for column in names[1:]:
        assert np.array_equal(record[column], expected[column][1:]), column


def test_reference_results_hold_an_alarm(fixtures):
    table = read_table(fixtures / "SteeringFaultDetector.fmu", "SteeringFaultDetector_ref.csv")
    alarmed = table["time"][table["alarm"] == 1.0]
    assert scenario.FAULT_ONSET_S < alarmed[0] < scenario.FAULT_ONSET_S + 0.15
    assert table["time"][-1] == pytest.approx(10.0)
