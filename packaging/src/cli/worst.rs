//! `steerguard campaign --worst`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use rayon::ThreadPoolBuilder;
use serde::Serialize;
use steerguard_designer::worst::{BUDGET, Family, FamilyWorst, STARTS, Search, worst};
use steerguard_designer::{Design, DesignStatus};

use super::package::caution;
use super::print::print;
use crate::campaign::{CampaignError, worst::file};
use crate::cli::arguments::CampaignArguments;
use crate::cli::failure::{Exit, Failure};
use crate::cli::progress::Progress;
use crate::output::table::aligned;
use crate::output::{self, create_folder};

/// What a search found.
#[derive(Serialize)]
struct Report {
    /// What the design may be called.
    status: DesignStatus,
    seed: u64,
    /// Drives of a family at most.
    budget: u64,
    starts: usize,
    /// Largest J/J_th by family, of what the specification states.
    ratio: BTreeMap<&'static str, Option<f64>>,
    /// The same of what it does not state.
    not_stated: BTreeMap<&'static str, Option<f64>>,
    families: Vec<Row>,
}

/// What was found of a family.
#[derive(Serialize)]
struct Row {
    family: &'static str,
    stated: bool,
    ratio: Option<f64>,
    /// The largest of the drives at random among them.
    ratio_at_random: Option<f64>,
    drives: u64,
    time_s: Option<f64>,
    v_x_m_per_s: Option<f64>,
    lateral_acceleration_m_per_s2: Option<f64>,
    scenario: Option<PathBuf>,
}

/// Searches the worst drives of `design` on so many `workers`.
pub(super) fn run(
    arguments: &CampaignArguments,
    design: &Design,
    workers: usize,
    json: bool,
) -> Result<Exit, Failure> {
    let families = Family::of(&design.spec);
    let search = Search { budget: arguments.budget.unwrap_or(BUDGET), seed: arguments.seed };
    let progress = Progress::bar(search.budget * families.len() as u64);
    let advance = |drives| progress.advance(drives);
    let configuration = design.configuration();
    let workers =
        ThreadPoolBuilder::new().num_threads(workers).build().map_err(CampaignError::from)?;
    let found = workers
        .install(|| worst(&design.spec, &configuration, &families, search, &advance))
        .map_err(Failure::bad)?;
    drop(progress);

    create_folder(&arguments.output)?;
    let rows: Vec<Row> =
        found.iter().map(|found| row(arguments, design, found)).collect::<Result<_, _>>()?;
    let ratios = |stated: bool| {
        let of = rows.iter().filter(|row| row.stated == stated);
        of.map(|row| (row.family, row.ratio)).collect()
    };
    let report = Report {
        status: design.synthesis.status,
        seed: search.seed,
        budget: search.budget,
        starts: STARTS,
        ratio: ratios(true),
        not_stated: ratios(false),
        families: rows,
    };
    print(json, &report, &text(&report))?;
    Ok(Exit::Done)
}

/// Writes the worst drive of a family.
fn row(
    arguments: &CampaignArguments,
    design: &Design,
    found: &FamilyWorst,
) -> Result<Row, Failure> {
    let name = found.family.name();
    let scenario = match file(found, &design.spec).map_err(Failure::bad)? {
        Some(text) => {
            let path = arguments.output.join(format!("worst-{name}.toml"));
            output::write(&path, text.as_bytes())?;
            Some(path)
        }
        None => None,
    };
    let at = found.worst.as_ref().map(|(_, worst)| worst);
    Ok(Row {
        family: name,
        stated: found.family.is_stated(),
        ratio: found.ratio(),
        ratio_at_random: found.ratio_at_random,
        drives: found.drives,
        time_s: at.map(|at| at.time_s),
        v_x_m_per_s: at.map(|at| at.v_x_m_per_s),
        lateral_acceleration_m_per_s2: at.map(|at| at.lateral_acceleration_m_per_s2),
        scenario,
    })
}

/// The same for people.
fn text(report: &Report) -> String {
    let head = [
        ["family", "J/J_th", "at random", "time", "v_x", "a_y", "drives"],
        ["", "largest", "largest", "s", "m/s", "m/s^2", ""],
    ];
    let table = |stated: bool| {
        let mut rows: Vec<Vec<String>> = head.map(|row| row.map(String::from).to_vec()).to_vec();
        let number =
            |x: Option<f64>, digits: usize| x.map_or("-".to_owned(), |x| format!("{x:.digits$}"));
        rows.extend(report.families.iter().filter(|row| row.stated == stated).map(|row| {
            vec![
                row.family.to_owned(),
                number(row.ratio, 3),
                number(row.ratio_at_random, 3),
                number(row.time_s, 2),
                number(row.v_x_m_per_s, 1),
                number(row.lateral_acceleration_m_per_s2, 1),
                row.drives.to_string(),
            ]
        }));
        aligned(&rows, "  ")
    };
    let Report { seed, budget, starts, .. } = report;
    let mut text = caution(report.status);
    text += "Worst fault-free drives found, within what the specification states\n";
    text += &table(true);
    text += "\nBeyond what it states\n";
    text += &table(false);
    text += &format!(
        "\nAt most {budget} drives a family, {starts} starts, seed {seed}. What a search finds is a lower \
         bound.\n"
    );
    for path in report.families.iter().filter_map(|row| row.scenario.as_ref()) {
        text += &format!("  {}\n", path.display());
    }
    text
}
