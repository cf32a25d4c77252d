//! FMUs from a design: description, baked libraries, documentation, icon, licences, reference results.

use std::collections::BTreeMap;
use std::io;

use steerguard_detector::Vehicle;
use steerguard_fmu::{BakedDesign, DesignError, DetectorModel};
use steerguard_fmu_core::Model;
use steerguard_model_description::detector::DetectorVariable;
use steerguard_model_description::plant::PlantVariable;
use steerguard_model_description::xml::Rendered;
use steerguard_model_description::{DefaultExperiment, xml};
use steerguard_plant::PlantModel;

use crate::drive::figure::PlotError;
use crate::fmu::archive::Archive;
use crate::fmu::bake::{BakeError, bake};
use crate::fmu::bill::{self, BillError};
use crate::fmu::reference;
use crate::fmu::runtime::Runtimes;
use crate::fmu::slices;
use crate::platform::Platform;
use crate::report::design_summary::Record;
use crate::report::documentation;
use crate::report::html::Section;

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

/// Path of the icon in FMI 3.0.
pub(crate) const ICON_FMI3: &str = "terminalsAndIcons/icon.png";

/// Path of the terminals in FMI 3.0.
pub(crate) const TERMINALS: &str = "terminalsAndIcons/terminalsAndIcons.xml";

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
    /// A figure of the documentation cannot be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// What a library links is not known.
    #[error("bill of materials: {0}")]
    Bill(#[from] BillError),
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
    fmu(&model, &detector_parts(design, record, &payload)?, runtimes)
}

/// The same in FMI 3.0: libraries are those of [`Runtimes::detector_fmi3`].
///
/// # Errors
/// [`PackageError`].
pub fn detector_fmi3(
    design: &BakedDesign,
    record: &Record,
    runtimes: &Runtimes,
) -> Result<Vec<u8>, PackageError> {
    let payload = design.encode()?;
    let model = DetectorModel::new(&payload).map_err(PackageError::Model)?;
    let mut parts = detector_parts(design, record, &payload)?;
    parts.about.push(documentation::detector_fmi3());
    parts.linked = &["steerguard-fmi3", "steerguard-fmi3-cdylib", "steerguard-fmu"];
    for (_, table) in &mut parts.reference {
        *table = reference::with_arrays::<DetectorVariable>(table);
    }
    let start = |variable| model.get(variable);
    let described = xml::fmi3::describe(&DetectorModel::INFO, start, &parts.experiment())?;
    let libraries: Vec<(Platform, &[u8])> = runtimes
        .0
        .iter()
        .flat_map(|(platform, library)| {
            platform.of_fmi3().iter().map(move |of_fmi3| (*of_fmi3, library))
        })
        .filter_map(|(platform, library)| Some((platform, slices::slice(library, platform)?)))
        .collect();
    let mut archive = archive(&model, &parts, &described, &libraries)?;
    archive.insert(TERMINALS, xml::fmi3::terminals::<DetectorVariable>()?);
    archive.insert(ICON_FMI3, ICON);
    archive.to_bytes().map_err(|error| PackageError::Write(error.into()))
}

fn detector_parts<'a>(
    design: &BakedDesign,
    record: &Record,
    payload: &'a [u8],
) -> Result<Parts<'a>, PackageError> {
    Ok(Parts {
        payload,
        linked: &["steerguard-fmi2", "steerguard-fmu", "steerguard-fmu-cdylib"],
        step_s: design.configuration.model.sampling_period_s,
        about: documentation::detector(design, record)?,
        reference: reference::detector(&design.configuration)
            .map_err(DesignError::Configuration)?,
    })
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
        linked: &[
            "steerguard-fmi2",
            "steerguard-plant",
            "steerguard-plant-cdylib",
            "steerguard-world",
        ],
        step_s: PLANT_STEP_S,
        about: documentation::plant(),
        reference: reference::plant(&Vehicle::PAPER, speed_m_per_s, PLANT_STEP_S),
    };
    fmu(&model, &parts, runtimes)
}

/// What tells the FMU of one model from that of another.
struct Parts<'a> {
    payload: &'a [u8],
    /// Packages of ours that its library links, and no other does.
    linked: &'static [&'static str],
    /// Communication step to propose, s.
    step_s: f64,
    /// The model's part of the documentation.
    about: Vec<Section>,
    reference: reference::Files,
}

impl Parts<'_> {
    fn experiment(&self) -> DefaultExperiment {
        DefaultExperiment { start_time: 0.0, stop_time: STOP_TIME_S, step_size: self.step_s }
    }
}

/// The FMU of `model`, which is fresh, in FMI 2.0.
fn fmu<M: Model>(
    model: &M,
    parts: &Parts<'_>,
    runtimes: &Runtimes,
) -> Result<Vec<u8>, PackageError> {
    let described = xml::describe(&M::INFO, |variable| model.get(variable), &parts.experiment())?;
    let libraries: Vec<(Platform, &[u8])> =
        runtimes.0.iter().map(|(platform, library)| (*platform, library.as_slice())).collect();
    let mut archive = archive(model, parts, &described, &libraries)?;
    archive.insert("model.png", ICON);
    archive.to_bytes().map_err(|error| PackageError::Write(error.into()))
}

/// What FMUs of all versions hold.
fn archive<M: Model>(
    model: &M,
    parts: &Parts<'_>,
    described: &Rendered,
    libraries: &[(Platform, &[u8])],
) -> Result<Archive, PackageError> {
    if libraries.is_empty() {
        return Err(PackageError::NoLibrary);
    }
    let mut archive = Archive::new(described.xml.as_str());
    let mut baked = BTreeMap::new();
    for &(platform, library) in libraries {
        let library = bake(library, platform, &described.guid, parts.payload)
            .map_err(|source| PackageError::Library { platform, source })?;
        baked.insert(platform.library_path(M::INFO.identifier), library);
    }
    archive.insert(bill::BILL, bill::bill(M::INFO.identifier, parts.linked, &baked)?);
    for (path, library) in baked {
        archive.insert(path, library);
    }
    let page = documentation::page(&M::INFO, &parts.about, |variable| model.get(variable));
    archive.insert("documentation/index.html", page);
    for (name, text) in LICENCES {
        archive.insert(format!("documentation/licenses/{name}"), text);
    }
    for (name, table) in &parts.reference {
        archive.insert(format!("extra/{}{name}", M::INFO.identifier), table.as_bytes());
    }
    Ok(archive)
}
