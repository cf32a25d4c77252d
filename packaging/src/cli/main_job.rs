//! The main job: from the paper's vehicle to a detected fault.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;
use steerguard_designer::Spec;

use super::package::Packaged;
use super::print::print;
use super::text::read_text;
use super::{design, input, package, simulate, verify};
use steerguard_model_description::names;

use crate::cli::detection_table::detection_table;
use crate::cli::failure::{Exit, Failure};
use crate::cli::progress::Progress;
use crate::drive::detection::Detection;
use crate::drive::scenario::Scenario;
use crate::drive::simulation::Files;
use crate::fmu::runtime::Runtimes;
use crate::output;
use crate::report::design_summary::{DesignSummary, Record};

/// All that the main job made and found.
#[derive(JsonSchema, Serialize)]
pub(super) struct Demonstration {
    /// Its figures.
    design: DesignSummary,
    /// What the check of the design file said.
    proof: verify::Proof,
    /// What was detected, a drive each.
    detections: Vec<Detection>,
    /// Where all of it is.
    files: Results,
}

/// The files of the main job.
#[derive(JsonSchema, Serialize)]
struct Results {
    /// The design file.
    design: PathBuf,
    /// Detector and reference vehicle.
    fmus: Vec<Packaged>,
    #[serde(flatten)]
    simulation: Files,
}

pub(super) fn run(folder: &Path, json: bool) -> Result<Exit, Failure> {
    output::create_folder(folder)?;
    let progress = Progress::new();
    let designed = input::make(&Spec::default(), Path::new(""), &progress)?;
    let design_file = folder.join("design.json");
    design::write(&designed, &design_file)?;

    progress.say("proving the design file");
    let checked = steerguard_verify::verify(&read_text(&design_file)?);
    let proof = verify::Proof::of(&checked);
    if !proof.holds {
        return Err(Failure::no(proof.text()).at(design_file.display()));
    }
    let verdict = checked.map_err(|refusal| input::refused(refusal, &design_file))?;
    progress.say("packaging");
    let detector_file = folder.join(names::DETECTOR_FILE);
    let plant_file = folder.join(names::PLANT_FILE);
    let fmus = vec![
        package::detector(
            &designed,
            &Record::of(&designed, &verdict),
            &Runtimes::detector(),
            &detector_file,
        )?,
        package::plant(&Runtimes::plant(), &plant_file)?,
    ];
    let (detector, plant) = (simulate::open(&detector_file)?, simulate::open(&plant_file)?);
    let simulation = simulate::simulate(&detector, &plant, &Scenario::default(), &progress)?;
    let files = simulate::write(&simulation, folder)?;
    drop(progress);

    let right = simulation.detections().all(Detection::is_right);
    let demonstration = Demonstration {
        design: DesignSummary::of(&designed),
        proof,
        detections: simulation.detections().cloned().collect(),
        files: Results { design: design_file, fmus, simulation: files },
    };
    print(json, &demonstration, &text(&demonstration))?;
    Ok(if right { design::exit(&designed) } else { Exit::No })
}

fn text(demonstration: &Demonstration) -> String {
    let Demonstration { design, proof, detections, files } = demonstration;
    format!(
        "Design: the paper's vehicle\n{}\n\
         Detection: steering fault of 0.5 deg, under side wind, over 20 s\n{}\n\
         Files\n{}  {}\n{}",
        design.text(Some(&proof.text())),
        detection_table(detections.iter()),
        package::listed(&files.fmus, "  "),
        files.design.display(),
        simulate::listed(&files.simulation),
    )
}
