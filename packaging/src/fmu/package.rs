//! FMUs from a design: description, baked libraries, documentation, icon, licences, reference results.

use std::io;

use steerguard_detector::Vehicle;
use steerguard_fmu::{BakedDesign, DesignError, DetectorModel};
use steerguard_fmu_core::Model;
use steerguard_model_description::plant::PlantVariable;
use steerguard_model_description::{DefaultExperiment, xml};
use steerguard_plant::PlantModel;

use crate::fmu::archive::Archive;
use crate::fmu::bake::{BakeError, bake};
use crate::fmu::design_summary::Record;
use crate::fmu::documentation;
use crate::fmu::reference;
use crate::fmu::runtime::Runtimes;
use crate::platform::Platform;

/// Length of the run that the FMUs propose, s: the scenario of the paper's Fig. 1.
pub(crate) const STOP_TIME_S: f64 = 20.0;

/// Communication step that the plant proposes, s.
const PLANT_STEP_S: f64 = 0.01;

/// Licence texts by file name under `documentation/licenses/`.
const LICENCES: [(&str, &str); 4] = [
    ("LICENSE-APACHE", include_str!("../../../LICENSE-APACHE")),
    ("LICENSE-MIT", include_str!("../../../LICENSE-MIT")),
    ("crc.txt", include_str!("../../assets/licenses/crc.txt")),
    ("libm.txt", include_str!("../../assets/licenses/libm.txt")),
];

const ICON: &[u8] = include_bytes!("../../assets/model.png");

/// Why an FMU cannot be packaged.
#[derive(Debug, thiserror::Error)]
pub enum PackageError {
    /// The numbers of the design are of no use to the detector.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// The model refuses what is to be baked in.
    #[error("{0}")]
    Model(&'static str),
    /// A library does not take the design.
    #[error("library for {}: {source}", platform.folder())]
    Library {
        /// Its platform.
        platform: Platform,
        /// Why.
        source: BakeError,
    },
    /// There is no library at all.
    #[error("no library for any platform: this command has none for its own machine")]
    NoLibrary,
    /// Description or archive cannot be written.
    #[error(transparent)]
    Write(#[from] io::Error),
}

/// The bytes of `SteeringFaultDetector.fmu` with `design` in it, whose documentation
/// states what is on `record`: the same for the same arguments.
///
/// # Errors
/// [`PackageError`].
pub fn detector_fmu(
    design: &BakedDesign,
    record: &Record,
    runtimes: &Runtimes,
) -> Result<Vec<u8>, PackageError> {
    let payload = design.encode()?;
    let model = DetectorModel::new(&payload).map_err(PackageError::Model)?;
    let parts = Parts {
        payload: &payload,
        step_s: design.configuration.model.sampling_period_s,
        about: documentation::detector(design, record),
        reference: reference::detector(&design.configuration)
            .map_err(DesignError::Configuration)?,
    };
    fmu(&model, &parts, runtimes)
}

/// The bytes of `VehiclePlant.fmu`.
///
/// # Errors
/// [`PackageError`].
pub fn plant_fmu(runtimes: &Runtimes) -> Result<Vec<u8>, PackageError> {
    let model = PlantModel::new(&[]).map_err(PackageError::Model)?;
    let mut speed_m_per_s = 0.0;
    model.get(PlantVariable::InitialSpeedX).store_real(&mut speed_m_per_s);
    let parts = Parts {
        payload: &[],
        step_s: PLANT_STEP_S,
        about: documentation::PLANT.to_owned(),
        reference: reference::plant(&Vehicle::PAPER, speed_m_per_s, PLANT_STEP_S),
    };
    fmu(&model, &parts, runtimes)
}

/// What tells the FMU of one model from that of another.
struct Parts<'a> {
    payload: &'a [u8],
    /// Communication step to propose, s.
    step_s: f64,
    /// The model's part of the documentation.
    about: String,
    reference: reference::Files,
}

/// The FMU of `model`, which is fresh.
fn fmu<M: Model>(
    model: &M,
    parts: &Parts<'_>,
    runtimes: &Runtimes,
) -> Result<Vec<u8>, PackageError> {
    if runtimes.0.is_empty() {
        return Err(PackageError::NoLibrary);
    }
    let start = |variable| model.get(variable);
    let experiment =
        DefaultExperiment { start_time: 0.0, stop_time: STOP_TIME_S, step_size: parts.step_s };
    let described = xml::describe(&M::INFO, start, &experiment)?;

    let mut archive = Archive::new(described.xml);
    for (&platform, library) in &runtimes.0 {
        let library = bake(library, platform, &described.guid, parts.payload)
            .map_err(|source| PackageError::Library { platform, source })?;
        archive.insert(platform.library_path(M::INFO.identifier), library);
    }
    let page = documentation::page(&M::INFO, &parts.about, start);
    archive.insert("documentation/index.html", page);
    archive.insert("model.png", ICON);
    for (name, text) in LICENCES {
        archive.insert(format!("documentation/licenses/{name}"), text);
    }
    for (name, table) in &parts.reference {
        archive.insert(format!("extra/{}{name}", M::INFO.identifier), table.as_bytes());
    }
    archive.to_bytes().map_err(|error| PackageError::Write(error.into()))
}
