//! The packaged detector, unpacked and loaded, and what drives it.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![allow(dead_code, reason = "not every test needs everything")]

pub mod drive;
pub mod raw;

use std::ffi::CString;
use std::fs;
use std::path::{Path, PathBuf};

use libloading::Library;
use steerguard::fmu::package::detector_fmu;
use steerguard::fmu::runtime::Runtimes;
use steerguard::platform::Platform;
use steerguard::report::design_summary::Record;
use steerguard_conformance_tests::Functions;
use steerguard_designer::{Design, Spec, design};
use steerguard_detector::Detector;
use steerguard_model_description::detector::{DetectorVariable, INFO};
use steerguard_model_description::{Variable, VariableSet, names};
use tempfile::TempDir;

/// The detector FMU of the paper's vehicle as a file, and its library beside it.
pub struct Packaged {
    pub design: Design,
    /// `SteeringFaultDetector.fmu`.
    pub fmu: PathBuf,
    pub library: PathBuf,
    pub guid: CString,
    folder: TempDir,
}

impl Packaged {
    /// Packages it, with the design that `tests/run` made, or one made here.
    pub fn new() -> Self {
        let design = match std::env::var_os("STEERGUARD_FIXTURES") {
            Some(fixtures) => {
                let text = fs::read_to_string(Path::new(&fixtures).join("design.json")).unwrap();
                Design::from_json(&text).unwrap()
            }
            None => design(&Spec::paper(), &mut |_| {}).unwrap(),
        };
        let baked = steerguard::report::design_summary::baked(&design).unwrap();
        let bytes = detector_fmu(&baked, &Record::default(), &Runtimes::detector()).unwrap();

        let folder = tempfile::tempdir().unwrap();
        let fmu = folder.path().join(names::DETECTOR_FILE);
        fs::write(&fmu, bytes).unwrap();
        let mut archive = zip::ZipArchive::new(fs::File::open(&fmu).unwrap()).unwrap();
        archive.extract(folder.path()).unwrap();
        let library = Platform::HOST.unwrap().library_path(INFO.identifier);
        let xml = fs::read_to_string(folder.path().join("modelDescription.xml")).unwrap();
        let description = steerguard_model_description::xml::read(&xml).unwrap();
        Self {
            design,
            fmu,
            library: folder.path().join(library),
            guid: CString::new(description.guid).unwrap(),
            folder,
        }
    }

    /// Loads the library.
    pub fn load(&self) -> (Functions, Library) {
        Functions::load(&self.library).unwrap()
    }

    /// The same detector without an FMU around it.
    pub fn plain_detector(&self) -> Detector {
        Detector::new(&self.design.configuration()).unwrap()
    }

    pub fn sample_period_s(&self) -> f64 {
        self.design.configuration().model.sampling_period_s
    }
}

/// The variables of the detector, by value reference.
pub const VARIABLES: &[Variable] = DetectorVariable::TABLE;
