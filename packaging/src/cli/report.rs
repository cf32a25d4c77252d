//! `steerguard report`.

use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::input;
use super::package::payload;
use super::print::print;
use super::text::read_text;
use crate::campaign::report::Report;
use crate::cli::arguments::{Allowance, ReportArguments};
use crate::cli::failure::{Exit, Failure};
use crate::cli::progress::Progress;
use crate::output;
use crate::report::campaign::{Campaign, Settings};
use crate::report::design_summary::Record;
use crate::report::documentation::{self, Evidence};
use crate::report::peers::Peers;
use crate::report::replay::{Replay, Summary};

/// A page that was written.
#[derive(JsonSchema, Serialize)]
pub(super) struct Reported<'a> {
    /// The page.
    file: &'a Path,
    /// Its size.
    bytes: usize,
}

pub(super) fn run(arguments: &ReportArguments, json: bool) -> Result<Exit, Failure> {
    let ReportArguments { design, campaign, replay, peers, output } = arguments;
    input::apart(design, output)?;
    // What a design lacks is what its page says first.
    let allowed = [Allowance::Uncertified, Allowance::Blind];
    let progress = Progress::new();
    let (designed, verdict) = input::verified(design, &allowed, &progress)?;
    progress.say("writing the page");
    let evidence = Evidence {
        campaign: campaign
            .as_deref()
            .map(|folder| of_campaign(folder, &designed.hash))
            .transpose()?,
        replay: replay.as_deref().map(|folder| of_replay(folder, &designed.hash)).transpose()?,
        peers: peers.as_deref().map(of_peers).transpose()?,
    };
    let record = Record::of(&designed, &verdict);
    let page =
        documentation::report(&payload(&designed)?, &record, &evidence).map_err(Failure::bad)?;
    output::write(output, page.as_bytes())?;
    drop(progress);
    let reported = Reported { file: output, bytes: page.len() };
    print(json, &reported, &format!("{}  {} bytes\n", output.display(), page.len()))?;
    Ok(Exit::Done)
}

fn of_campaign(folder: &Path, design: &str) -> Result<Campaign, Failure> {
    let help = "`steerguard campaign DESIGN -o DIR` makes such a folder";
    let file = folder.join("campaign.json");
    let settings: Settings = parsed(&file, help)?;
    of_this_design(&settings.design, design, &file)?;
    let figures: Report = parsed(&folder.join("report.json"), help)?;
    Ok(Campaign { folder: folder.display().to_string(), settings, figures })
}

fn of_replay(folder: &Path, design: &str) -> Result<Replay, Failure> {
    let help = "`steerguard replay DESIGN DRIVE... -o DIR` makes such a folder";
    let file = folder.join(super::replay::SUMMARY);
    let summary: Summary = parsed(&file, help)?;
    of_this_design(&summary.design, design, &file)?;
    Ok(Replay { folder: folder.display().to_string(), summary })
}

fn of_peers(file: &Path) -> Result<Peers, Failure> {
    parsed(file, "tests/peers/run --output FILE makes such a file")
}

/// The JSON in the file at `path`.
fn parsed<T: DeserializeOwned>(path: &Path, help: &str) -> Result<T, Failure> {
    serde_json::from_str(&read_text(path)?)
        .map_err(|error| Failure::bad(error).at(path.display()).help(help))
}

/// Refuses results of another design.
fn of_this_design(driven: &str, design: &str, path: &Path) -> Result<(), Failure> {
    if driven == design {
        return Ok(());
    }
    Err(Failure::bad(format!("results of another design: its hash is {driven}, not {design}"))
        .at(path.display())
        .help(
            "give the folder that was made with this design, or the design that it was made with",
        ))
}
