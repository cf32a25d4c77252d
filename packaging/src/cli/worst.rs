//! `steerguard campaign --worst`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use rayon::ThreadPoolBuilder;
use schemars::JsonSchema;
use serde::Serialize;
use steerguard_designer::worst::{BUDGET, Family, FamilyWorst, Objective, STARTS, Search, worst};
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
#[derive(JsonSchema, Serialize)]
pub(super) struct Report {
    /// What the design may be called.
    status: DesignStatus,
    /// Seed of the search.
    seed: u64,
    /// Drives of a family at most.
    budget: u64,
    /// Starts of the search.
    starts: usize,
    /// Largest J/J_th by family, of what the specification states.
    ratio: BTreeMap<&'static str, Option<f64>>,
    /// The same of what it does not state.
    not_stated: BTreeMap<&'static str, Option<f64>>,
    /// The same of the second test's statistic over its threshold; none where it does not run.
    second_ratio: Option<BTreeMap<&'static str, Option<f64>>>,
    /// The same of what the specification does not state.
    second_not_stated: Option<BTreeMap<&'static str, Option<f64>>>,
    /// What was found, family by family.
    families: Vec<Row>,
    /// The same of the second test.
    second_families: Option<Vec<Row>>,
}

/// What was found of a family.
#[derive(JsonSchema, Serialize)]
struct Row {
    /// Its name.
    family: &'static str,
    /// Whether the specification states all that its drives make use of.
    stated: bool,
    /// Largest J/J_th, or statistic of the second test over its threshold; null where no drive was monitored.
    ratio: Option<f64>,
    /// The largest of the drives at random among them.
    ratio_at_random: Option<f64>,
    /// Drives that the search took.
    drives: u64,
    /// When it was that large, s.
    time_s: Option<f64>,
    /// Speed then.
    v_x_m_per_s: Option<f64>,
    /// Lateral acceleration then.
    lateral_acceleration_m_per_s2: Option<f64>,
    /// The drive, for `steerguard simulate`.
    scenario: Option<PathBuf>,
}

/// Largest ratios by family of the `rows` that are stated, or not.
fn ratios(rows: &[Row], stated: bool) -> BTreeMap<&'static str, Option<f64>> {
    let of = rows.iter().filter(|row| row.stated == stated);
    of.map(|row| (row.family, row.ratio)).collect()
}

/// Searches the worst drives of `design` on so many `workers`.
pub(super) fn run(
    arguments: &CampaignArguments,
    design: &Design,
    workers: usize,
    json: bool,
) -> Result<Exit, Failure> {
    let families = Family::of(&design.spec);
    let budget = arguments.budget.unwrap_or(BUDGET);
    let configuration = design.configuration();
    let second = configuration.estimator.map(|_| Objective::Second);
    let objectives = 1 + u64::from(second.is_some());
    let progress = Progress::bar(objectives * budget * families.len() as u64);
    let advance = |drives| progress.advance(drives);
    let workers =
        ThreadPoolBuilder::new().num_threads(workers).build().map_err(CampaignError::from)?;
    let found = |objective: Objective| {
        let search = Search { objective, budget, seed: arguments.seed };
        workers
            .install(|| worst(&design.spec, &configuration, &families, search, &advance))
            .map_err(Failure::bad)
    };
    let of_residual = found(Objective::Residual)?;
    let of_second = second.map(found).transpose()?;
    drop(progress);

    create_folder(&arguments.output)?;
    let rows = |objective: Objective, found: &[FamilyWorst]| {
        let rows = found.iter().map(|found| row(arguments, design, objective, found));
        rows.collect::<Result<Vec<Row>, Failure>>()
    };
    let families = rows(Objective::Residual, &of_residual)?;
    let second_families = of_second.map(|found| rows(Objective::Second, &found)).transpose()?;
    let of_second = |stated: bool| second_families.as_ref().map(|rows| ratios(rows, stated));
    let report = Report {
        status: design.synthesis.status,
        seed: arguments.seed,
        budget,
        starts: STARTS,
        ratio: ratios(&families, true),
        not_stated: ratios(&families, false),
        second_ratio: of_second(true),
        second_not_stated: of_second(false),
        families,
        second_families,
    };
    print(json, &report, &text(&report))?;
    Ok(Exit::Done)
}

/// Writes the worst drive of a family.
fn row(
    arguments: &CampaignArguments,
    design: &Design,
    objective: Objective,
    found: &FamilyWorst,
) -> Result<Row, Failure> {
    let name = found.family.name();
    let suffix = match objective {
        Objective::Residual => "",
        Objective::Second => "-second",
    };
    let scenario = match file(found, objective, &design.spec).map_err(Failure::bad)? {
        Some(text) => {
            let path = arguments.output.join(format!("worst-{name}{suffix}.toml"));
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
    let table = |of: &str, rows: &[Row], stated: bool| {
        let head = [
            ["family", of, "at random", "time", "v_x", "a_y", "drives"],
            ["", "largest", "largest", "s", "m/s", "m/s^2", ""],
        ];
        let mut lines: Vec<Vec<String>> = head.map(|row| row.map(String::from).to_vec()).to_vec();
        let number =
            |x: Option<f64>, digits: usize| x.map_or("-".to_owned(), |x| format!("{x:.digits$}"));
        lines.extend(rows.iter().filter(|row| row.stated == stated).map(|row| {
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
        aligned(&lines, "  ")
    };
    let Report { seed, budget, starts, families, second_families, .. } = report;
    let mut text = caution(report.status);
    let mut tables = |head: &str, stated: bool| {
        text += head;
        text += &table("J/J_th", families, stated);
        if let Some(rows) = second_families {
            text += "\n";
            text += &table("second", rows, stated);
        }
    };
    tables("Worst fault-free drives found, within what the specification states\n", true);
    tables("\nBeyond what it states\n", false);
    if second_families.is_some() {
        text += "\nsecond: the second test's statistic over its threshold.\n";
    }
    text += &format!(
        "\nAt most {budget} drives a family, {starts} starts, seed {seed}. What a search finds is a lower \
         bound.\n"
    );
    let rows = families.iter().chain(second_families.iter().flatten());
    for path in rows.filter_map(|row| row.scenario.as_ref()) {
        text += &format!("  {}\n", path.display());
    }
    text
}
