//! `steerguard replay`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};
use steerguard_designer::Design;
use steerguard_model_description::names;

use super::columns::{told, unreadable};
use super::package::{self, caution};
use super::print::print;
use super::{input, simulate};
use crate::cli::arguments::ReplayArguments;
use crate::cli::failure::{Exit, Failure};
use crate::cli::progress::Progress;
use crate::output;
use crate::output::temporary::TemporaryFolder;
use crate::replay::report::Summary;
use crate::replay::{self, Bench, OpenDrive, Outputs, ReplayError};

/// Name of the summary in the folder of results.
pub(super) const SUMMARY: &str = "summary.json";

pub(super) fn run(arguments: &ReplayArguments, json: bool) -> Result<Exit, Failure> {
    let columns = told(&arguments.columns)?;
    // Everything about the drives that can be wrong from the start is said before a design is verified.
    let names = names_of(&arguments.drives);
    let open = |(path, name): (&PathBuf, &String)| OpenDrive::open(path, &columns, name.clone());
    for drive in arguments.drives.iter().zip(&names) {
        open(drive).map_err(|error| unreadable(&error))?;
    }
    let outputs = Outputs { folder: arguments.output.clone() };
    let summary_path = outputs.folder.join(SUMMARY);
    refuse_to_overwrite(arguments, &names, &outputs, &summary_path)?;

    let design = input::design(&arguments.design, &arguments.allow, &Progress::new())?;
    let bench = bench(&design)?;
    output::create_folder(&outputs.folder)?;
    let progress = Progress::bar(names.len() as u64);
    progress.say("drives");
    // Opened anew, a few at a time: there may be more drives than files that can be open.
    let replayed = arguments.drives.par_iter().zip(&names).map(|drive| {
        let (drive, gap_s, fault_free) = (open(drive)?, arguments.gap, arguments.fault_free);
        let report = replay::drive(&bench, drive, &arguments.fault, gap_s, fault_free, &outputs);
        progress.advance(1);
        report
    });
    let replayed = replayed.collect::<Result<Vec<_>, _>>().map_err(failure)?;
    drop(progress);

    let status = design.synthesis.status;
    let summary = Summary::new(status, design.hash, arguments.fault_free, replayed);
    let bytes = serde_json::to_string_pretty(&summary).map_err(Failure::bad)? + "\n";
    output::write(&summary_path, bytes.as_bytes())?;
    let mut text = caution(status) + &summary.text();
    text += &listed(&summary, &summary_path);
    print(json, &summary, &text)?;
    Ok(if summary.has_false_alarms() { Exit::No } else { Exit::Done })
}

/// Files of the recorded drives, a line each, and how many there are of the injected faults.
fn listed(summary: &Summary, path: &Path) -> String {
    let recorded = summary.drives.iter().flat_map(|drive| &drive.files[..drive.files.len().min(2)]);
    let recorded: Vec<_> = recorded.map(PathBuf::as_path).chain([path]).collect();
    let mut text: String = recorded.iter().map(|file| format!("  {}\n", file.display())).collect();
    let all = 1 + summary.drives.iter().map(|drive| drive.files.len()).sum::<usize>();
    if all > recorded.len() {
        text += &format!("  and {} files of the injected faults\n", all - recorded.len());
    }
    text
}

/// Packages the detector and loads it.
fn bench(design: &Design) -> Result<Bench, Failure> {
    let folder = TemporaryFolder::new()
        .map_err(|error| Failure::bad(format!("cannot make a temporary folder: {error}")))?;
    let path = folder.path().join(names::DETECTOR_FILE);
    package::detector_to_drive(design, &path)?;
    Ok(Bench {
        fmu: simulate::open(&path)?,
        vehicle: design.detector.model.vehicle,
        zero: design.spec.sensors.zero(),
        steering_ratio: design.spec.sensors.steering_ratio,
        speeds: design.spec.operating_range.range().v_x,
        period_s: design.detector.model.sampling_period_s,
    })
}

/// Names of the results of drives: that of the file without ending, with a number where several have it.
fn names_of(drives: &[PathBuf]) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let name = |path: &PathBuf| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let numbered = (2..).map(|number| format!("{stem}-{number}"));
        let mut free = std::iter::once(stem.clone()).chain(numbered);
        let free = free.find(|name| taken.insert(name.clone()));
        free.unwrap_or_default()
    };
    drives.iter().map(name).collect()
}

/// Refuses to write over what is read.
fn refuse_to_overwrite(
    arguments: &ReplayArguments,
    names: &[String],
    outputs: &Outputs,
    summary: &Path,
) -> Result<(), Failure> {
    let written = names.iter().flat_map(|name| outputs.of(name, &arguments.fault));
    let written: Vec<_> = written.chain([summary.to_owned()]).collect();
    let mut distinct = BTreeSet::new();
    if let Some(twice) = written.iter().find(|path| !distinct.insert(*path)) {
        return Err(Failure::bad(format!("two results would be written to `{}`", twice.display()))
            .help("give each fault once, and drives other names"));
    }
    let read = arguments.drives.iter().chain([&arguments.design]).chain(&arguments.columns.columns);
    for input in read {
        for output in &written {
            input::apart(input, output).map_err(|_| {
                Failure::bad(format!("`{}` would be written over itself", input.display()))
                    .help("name another folder (-o DIR)")
            })?;
        }
    }
    Ok(())
}

fn failure(error: ReplayError) -> Failure {
    match error {
        ReplayError::Drive(error) => unreadable(&error),
        ReplayError::Output(error) => error.into(),
        other => Failure::bad(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drives_of_the_same_name_get_numbers() {
        let drives = ["a/x.csv", "b/x.parquet", "x-2.csv", "x"].map(PathBuf::from);
        assert_eq!(names_of(&drives), ["x", "x-2", "x-2-2", "x-3"]);
    }
}
