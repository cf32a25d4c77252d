//! `documentation/index.html` of the FMUs, and the page of `steerguard report`.

use std::fmt::Write as _;

use steerguard_fmu::BakedDesign;
use steerguard_model_description::detector::DetectorState;
use steerguard_model_description::{
    Causality, Kind, ModelInfo, RealKind, Role, Value, Variable, VariableSet,
};

use super::campaign::Campaign;
use super::design_summary::Record;
use super::html::{Cells, Section, command, escaped, framed, paragraph};
use super::peers::Peers;
use super::replay::Replay;
use super::{page, sections};
use crate::drive::figure::PlotError;

/// First line of the tables of variables.
const HEAD: &str = "<thead><tr><th scope=\"col\">Name</th><th scope=\"col\">Unit or type</th>\
<th scope=\"col\">Value</th><th scope=\"col\">Range or items</th><th scope=\"col\">Meaning</th></tr></thead>\n";

const DETECTOR: &str = "\
<p>Feed it what the vehicle measures and what the driver or controller commands. Its observer predicts
speed and yaw rate; the windowed RMS of the weighted prediction error, <code>J_rms</code>, is held
against the threshold <code>J_th</code>. A steering actuator that turns the wheels by another angle
than commanded raises the alarm.</p>
<ul>
<li>Axes are those of ISO 8855: x forward, y left, yaw rate counter-clockwise. SI units throughout.</li>
<li><code>v_x</code> and <code>r</code>: measured speed and yaw rate.</li>
<li><code>u.T_eng</code>: drive torque at the wheels. <code>u.delta</code>: commanded angle <em>at the
road wheel</em>, after the steering ratio. Both as they act from the communication point on.</li>
<li><code>alarm</code> is <code>J_rms &ge; J_th</code>, or the second test's where the design has one;
<code>alarm_latched</code> and <code>first_alarm_time</code> remember it.</li>
<li><code>excited</code> says whether the smallest fault of interest could be seen at all:
whether the J that it would make alone reaches <code>J_th</code>. Alarms are given in any case.</li>
<li><code>state</code> says which condition holds; <code>state_index</code> is the same as an Integer,
for importers without enumerations. The conditions are listed below.</li>
<li>The detector samples on its own grid. Communication steps of any length are legal; outputs after a
step are those of the last sample run.</li>
</ul>
";

/// What the page says of the detector in FMI 3.0 beside.
const DETECTOR_FMI3: &str = "\
<ul>
<li><code>residual</code> is an array of <code>residual.v_x</code> (m/s) and <code>residual.r</code>
(rad/s), <code>z_0</code> one of <code>z_0[1]</code> to <code>z_0[3]</code>. Reals are Float64, Integers Int32.</li>
<li>The triggered output clock <code>alarm_change</code> ticks at the sample that raises or ends the
alarm; <code>alarm_change_time</code>, clocked by it, is that sample's time. An importer that uses Event
Mode and allows early return gets <code>fmi3DoStep</code> back there, even where the sample falls on the communication
point itself; one that allows no early return finds the tick at the step's end; without Event Mode steps are
done whole.</li>
<li>Terminals group what is wired together: <code>measurement</code>, <code>command</code>,
<code>verdict</code>.</li>
</ul>
";

/// What the page of `VehiclePlant.fmu` says of it.
const PLANT: &str = "\
<p>The plant integrates with steps of 1 ms and holds its inputs over each of them. Parameters are set
before initialisation ends; <code>vehicle.*</code> carry the names that the detector gives the vehicle it
was designed for, <code>actuator.*</code> those of its <code>design.actuator.*</code>. <code>fault</code> is added to the angle of the steering actuator.</p>
";

/// What was found out about a design beside the design itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evidence {
    /// A campaign.
    pub campaign: Option<Campaign>,
    /// Recorded drives.
    pub replay: Option<Replay>,
    /// Other detectors on the same drives.
    pub peers: Option<Peers>,
}

/// The page of `steerguard report`.
///
/// # Errors
/// [`PlotError`] if the drawing library refuses.
pub fn report(
    design: &BakedDesign,
    record: &Record,
    evidence: &Evidence,
) -> Result<String, PlotError> {
    let lead = "<p>What a steering-fault detector for one vehicle is worth: what it sees, how fast, on what evidence, and \
                what it cannot see.</p>\n";
    let mut sections = of_design(design, record, evidence)?;
    sections.push(repeat(design, evidence));
    Ok(page::page("Steering-fault detector", lead, &sections))
}

/// What the page of `SteeringFaultDetector.fmu` says of it, of the design inside and of what is on
/// record of that.
///
/// # Errors
/// [`PlotError`] if the drawing library refuses.
pub fn detector(design: &BakedDesign, record: &Record) -> Result<Vec<Section>, PlotError> {
    let mut sections = of_design(design, record, &Evidence::default())?;
    let wiring = Section { id: "wiring", title: "Wiring", html: DETECTOR.to_owned() };
    sections.insert(1, wiring);
    sections.insert(2, Section { id: "conditions", title: "Conditions", html: states() });
    Ok(sections)
}

/// What it says beside of the detector in FMI 3.0.
pub fn detector_fmi3() -> Section {
    Section { id: "fmi3", title: "In FMI 3.0", html: DETECTOR_FMI3.to_owned() }
}

/// What the page of `VehiclePlant.fmu` says of it.
pub fn plant() -> Vec<Section> {
    vec![Section { id: "use", title: "Use", html: PLANT.to_owned() }]
}

fn of_design(
    design: &BakedDesign,
    record: &Record,
    evidence: &Evidence,
) -> Result<Vec<Section>, PlotError> {
    let mut of = vec![sections::verdict(design, record)];
    if let Some(pictures) = &record.pictures {
        of.extend(sections::drives(pictures)?);
    }
    of.push(on_the_road(evidence)?);
    of.push(sections::threshold(record, &design.configuration)?);
    if let Some(pictures) = &record.pictures {
        of.push(sections::frequency(pictures)?);
    }
    of.push(sections::proof(record));
    of.extend(sections::specification(record));
    of.push(sections::numbers(design));
    Ok(of)
}

/// Campaign, replay and peers; where there are none, the command that makes them.
fn on_the_road(evidence: &Evidence) -> Result<Section, PlotError> {
    let Evidence { campaign, replay, peers } = evidence;
    let mut html = match campaign {
        Some(campaign) => campaign.html()?,
        None => {
            paragraph(
                "No campaign is in this page. One of random drives of uncertain vehicles, and the page with it:",
            ) + &command(
                "steerguard campaign design.json --drives 1000 -o campaign\n\
                     steerguard report design.json --campaign campaign -o report.html",
            )
        }
    };
    html += &match replay {
        Some(replay) => format!("<h3>Recorded drives</h3>\n{}", replay.html()),
        None => {
            paragraph("Recorded drives of the vehicle, if there are any:")
                + &command(
                    "steerguard replay design.json drive.csv --fault-free -o replay\n\
                     steerguard report design.json --replay replay -o report.html",
                )
        }
    };
    if let Some(peers) = peers {
        html += &format!("<h3>Other detectors</h3>\n{}", peers.html());
    }
    Ok(Section { id: "road", title: "On the road", html })
}

/// The commands that give the same again.
fn repeat(design: &BakedDesign, evidence: &Evidence) -> Section {
    let hash = String::from_utf8_lossy(&design.hash);
    let mut html = paragraph(&format!(
        "Made by steerguard {} from the design with the SHA-256 {hash}. The same files give this page again, byte for byte.",
        env!("CARGO_PKG_VERSION")
    ));
    let mut lines = String::from(
        "steerguard design car.toml -o design.json   # the specification is above\n\
         steerguard verify design.json               # what is proven\n\
         steerguard report design.json               # verdict, drives, threshold, frequency\n",
    );
    if let Some(Campaign { folder, settings, .. }) = &evidence.campaign {
        let _infallible = writeln!(
            lines,
            "steerguard campaign design.json --drives {} --duration {} --seed {} --mix {} --faults {} -o {folder}",
            settings.drives, settings.duration_s, settings.seed, settings.mix, settings.faults
        );
    }
    if let Some(Replay { folder, .. }) = &evidence.replay {
        let _infallible = writeln!(lines, "steerguard replay design.json DRIVES... -o {folder}");
    }
    html += &command(lines.trim_end());
    Section { id: "repeat", title: "How to repeat it", html }
}

/// The items of `state`.
fn states() -> String {
    let items = DetectorState::TYPE.items.iter().zip(1..);
    let lines = items.map(|(item, value)| {
        format!("<li>{value} <code>{}</code>: {}</li>\n", item.name, escaped(item.description))
    });
    format!("<ul>\n{}</ul>\n", lines.collect::<String>())
}

/// The page of an FMU: what is said about it, then all variables with their values in a fresh instance.
pub fn page<'a, V: VariableSet>(
    info: &ModelInfo,
    about: &[Section],
    value: impl Fn(V) -> Value<'a>,
) -> String {
    let (name, description) = (escaped(info.name), escaped(info.description));
    let mut variables = String::new();
    for (title, holds) in [
        ("Inputs", &(|role: Role| role.causality == Causality::Input) as &dyn Fn(Role) -> bool),
        ("Outputs", &|role| role.causality == Causality::Output),
        ("Parameters", &|role| role.causality == Causality::Parameter),
        ("Internal", &|role| role.causality == Causality::Local && role != Role::CONSTANT),
        ("Constants", &|role| role == Role::CONSTANT),
    ] {
        let of = V::ALL.iter().zip(V::TABLE).filter(|(_, row)| holds(row.role));
        let rows: String = of.map(|(variable, row)| line(row, value(*variable))).collect();
        if !rows.is_empty() {
            variables += &framed(title, Cells::Words, &format!("{HEAD}<tbody>\n{rows}</tbody>\n"));
        }
    }
    let files = format!(
        "<p><code>extra/{name}_in.csv</code> holds inputs to apply at the communication \
         points, <code>extra/{name}_ref.csv</code> the outputs that are found there before: run the FMU on \
         the one with parameters as they are and compare with the other to see that it is wired and \
         stepped as meant.</p>\n\
         <p>Licences of this FMU and of what is linked into it are in <code>licenses/</code>.</p>\n"
    );
    let mut sections = about.to_vec();
    sections.push(Section { id: "variables", title: "Variables", html: variables });
    sections.push(Section { id: "files", title: "Files", html: files });
    page::page(info.name, &format!("<p>{description}</p>\n"), &sections)
}

fn line(variable: &Variable, value: Value<'_>) -> String {
    let value = if variable.role.has_start() { text(&variable.kind, value) } else { String::new() };
    let cells =
        [kind(&variable.kind), value, limits(&variable.kind), variable.description.to_owned()];
    let cells: String = cells.iter().map(|cell| format!("<td>{}</td>", escaped(cell))).collect();
    format!("<tr><td><code>{}</code></td>{cells}</tr>\n", escaped(variable.name))
}

/// Unit of a Real, type of all others.
fn kind(kind: &Kind) -> String {
    match kind {
        Kind::Real(real) if real.unit.name != "1" => real.unit.name.to_owned(),
        other => other.name().to_owned(),
    }
}

fn limits(kind: &Kind) -> String {
    match kind {
        Kind::Real(RealKind { min, max, .. }) => match (min, max) {
            (Some(min), Some(max)) => format!("{} to {}", number(*min), number(*max)),
            (Some(min), None) => format!("from {}", number(*min)),
            (None, Some(max)) => format!("up to {}", number(*max)),
            (None, None) => String::new(),
        },
        Kind::Integer { min: i32::MIN, max: i32::MAX } | Kind::Boolean | Kind::String => {
            String::new()
        }
        Kind::Integer { min, max } => format!("{min} to {max}"),
        Kind::Enumeration(enumeration) => {
            let items = enumeration.items.iter().zip(1..);
            items.map(|(item, i)| format!("{i} {}", item.name)).collect::<Vec<_>>().join(", ")
        }
    }
}

fn text(kind: &Kind, value: Value<'_>) -> String {
    match (kind, value) {
        (_, Value::Real(value)) => number(value),
        (Kind::Enumeration(enumeration), Value::Integer(value)) => {
            let item = usize::try_from(value - 1).ok().and_then(|i| enumeration.items.get(i));
            item.map_or_else(|| value.to_string(), |item| item.name.to_owned())
        }
        (_, Value::Integer(value)) => value.to_string(),
        (_, Value::Boolean(value)) => value.to_string(),
        (_, Value::String(value)) => value.to_string_lossy().into_owned(),
    }
}

/// A number for people, without loss.
fn number(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 || (1e-4..1e7).contains(&magnitude) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}
