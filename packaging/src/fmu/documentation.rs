//! `documentation/index.html` of the FMUs: what they are, how to wire them, which design is inside.
//! One page, no scripts, nothing to fetch.

use std::fmt::Write as _;

use steerguard_designer::sight::Sight;
use steerguard_designer::threshold::by_cause;
use steerguard_detector::{Configuration, Estimator, Interval};
use steerguard_fmu::BakedDesign;
use steerguard_model_description::detector::DetectorState;
use steerguard_model_description::{
    Causality, Kind, ModelInfo, RealKind, Role, Value, Variable, VariableSet,
};

use crate::fmu::design_summary::{Cause, Record, cause_rows};
use crate::fmu::sight;

const STYLE: &str = "body{font:16px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em;\
color:#222}table{border-collapse:collapse;width:100%}th,td{text-align:left;padding:.25em .75em;\
border-bottom:1px solid #ddd;vertical-align:top}code{background:#f3f3f3;padding:0 .2em;\
overflow-wrap:anywhere}\
td code{white-space:nowrap}td:nth-child(3){overflow-wrap:anywhere;min-width:10em}\
.figures td,.figures th{text-align:right;min-width:0;vertical-align:bottom;padding:.25em .5em}";

/// First line of the tables of variables.
const HEAD: &str = "<tr><th>Name<th>Unit or type<th>Value<th>Range or items<th>Meaning\n";

const DETECTOR: &str = "\
<p>Feed it what the vehicle measures and what the driver or controller commands. Its observer predicts
speed and yaw rate; the windowed RMS of the weighted prediction error, <code>J_rms</code>, is held
against the threshold <code>J_th</code>. A steering actuator that turns the wheels by another angle
than commanded raises the alarm.</p>
<h2>Wiring</h2>
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
pub const DETECTOR_FMI3: &str = "\
<h2>In FMI 3.0</h2>
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
pub const PLANT: &str = "\
<h2>Use</h2>
<p>The plant integrates with steps of 1 ms and holds its inputs over each of them. Parameters are set
before initialisation ends; <code>vehicle.*</code> carry the names that the detector gives the vehicle it
was designed for, <code>actuator.*</code> those of its <code>design.actuator.*</code>. <code>fault</code> is added to the angle of the steering actuator.</p>
";

/// What the page of `SteeringFaultDetector.fmu` says of it, of the design inside and of what is on
/// record of that.
pub fn detector(design: &BakedDesign, record: &Record) -> String {
    let about_design = summary(design);
    let threshold = threshold(&record.causes, &design.configuration);
    let sight = record.sight.as_ref().map_or(String::new(), what_it_sees);
    let second = second(design.configuration.estimator.as_ref(), &record.second);
    format!("{DETECTOR}{}{about_design}{sight}{threshold}{second}", states())
}

/// Whether there is a second test, and what its threshold rests on.
fn second(estimator: Option<&Estimator>, sentences: &[String]) -> String {
    let Some(estimator) = estimator else {
        return "<h2>Second test</h2>\n<p>None: <code>second_ratio</code> and <code>fault_estimate</code> stay \
                0.</p>\n"
            .to_owned()
            + &sentences.iter().map(|x| format!("<p>{}</p>\n", escaped(x))).collect::<String>();
    };
    let Estimator { threshold, estimate_factor, .. } = estimator;
    let mut text = format!(
        "<h2>Second test</h2>\n<p>Beside the residual a Kalman filter that is told what is uncertain looks for a \
         constant angle that the road wheel is off by since some sample. <code>second_ratio</code> is the statistic of \
         the likeliest over its threshold, {threshold:.3}; from 1 on the alarm is raised, \
         <code>alarm_cause</code> SecondTest, and <code>fault_estimate</code> is the angle, which acts from \
         <code>fault_onset_time</code> on. <code>fault_estimate_bound</code> is what its error stays below in 99 of \
         100 drives like those of the calibration (statistic {estimate_factor:.3}).</p>\n"
    );
    for sentence in sentences {
        let _infallible = writeln!(text, "<p>{}</p>", escaped(sentence));
    }
    text
}

/// The items of `state`.
fn states() -> String {
    let items = DetectorState::TYPE.items.iter().zip(1..);
    let lines = items.map(|(item, value)| {
        format!("<li>{value} <code>{}</code>: {}</li>\n", item.name, escaped(item.description))
    });
    format!("<h2>Conditions</h2>\n<ul>\n{}</ul>\n", lines.collect::<String>())
}

/// The page of an FMU: `about` it, then all variables with their values in a fresh instance.
pub fn page<'a, V: VariableSet>(
    info: &ModelInfo,
    about: &str,
    value: impl Fn(V) -> Value<'a>,
) -> String {
    let (name, description) = (escaped(info.name), escaped(info.description));
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{name}</title>\n\
         <style>{STYLE}</style>\n</head>\n<body>\n<h1>{name}</h1>\n<p>{description}</p>\n{about}"
    );
    for (title, holds) in [
        ("Inputs", &(|role: Role| role.causality == Causality::Input) as &dyn Fn(Role) -> bool),
        ("Outputs", &|role| role.causality == Causality::Output),
        ("Parameters", &|role| role.causality == Causality::Parameter),
        ("Internal", &|role| role.causality == Causality::Local && role != Role::CONSTANT),
        ("Constants", &|role| role == Role::CONSTANT),
    ] {
        let variables = V::ALL.iter().zip(V::TABLE).filter(|(_, row)| holds(row.role));
        let rows: String = variables.map(|(variable, row)| line(row, value(*variable))).collect();
        if !rows.is_empty() {
            page += &format!("<h2>{title}</h2>\n<table>\n{HEAD}{rows}</table>\n");
        }
    }
    page += &format!(
        "<h2>Files</h2>\n<p><code>extra/{name}_in.csv</code> holds inputs to apply at the communication \
         points, <code>extra/{name}_ref.csv</code> the outputs that are found there before: run the FMU on \
         the one with parameters as they are and compare with the other to see that it is wired and \
         stepped as meant.</p>\n\
         <p>Licences of this FMU and of what is linked into it are in <code>licenses/</code>.</p>\n\
         </body>\n</html>\n"
    );
    page
}

fn line(variable: &Variable, value: Value<'_>) -> String {
    let value = if variable.role.has_start() { text(&variable.kind, value) } else { String::new() };
    let cells =
        [kind(&variable.kind), value, limits(&variable.kind), variable.description.to_owned()];
    let cells: String = cells.iter().map(|cell| format!("<td>{}", escaped(cell))).collect();
    format!("<tr><td><code>{}</code>{cells}\n", escaped(variable.name))
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

fn summary(design: &BakedDesign) -> String {
    let configuration = &design.configuration;
    let (model, evaluation) = (&configuration.model, &configuration.evaluation);
    let interval = |i: Interval, unit: &str| format!("{} to {} {unit}", i.min, i.max);
    let mut text = String::from("<h2>Design</h2>\n<table>\n");
    for (name, value) in [
        ("design file, SHA-256", String::from_utf8_lossy(&design.hash).into_owned()),
        (
            "status",
            match design.certified {
                true => "certified: the figures below are proven for these gains",
                false => "NOT CERTIFIED: there is no proof of what these gains are worth",
            }
            .to_owned()
                + if design.blind {
                    "; BLIND: its drives miss the smallest fault of interest"
                } else {
                    ""
                },
        ),
        ("sampling period T_s", format!("{} s", model.sampling_period_s)),
        ("range of v_x", interval(model.range.v_x, "m/s")),
        ("range of v_y", interval(model.range.v_y, "m/s")),
        ("range of r", interval(model.range.r, "rad/s")),
        ("certified fault sensitivity beta", format!("{:.6}", design.beta)),
        ("certified disturbance gain gamma", format!("{:.6}", design.gamma)),
        (
            "J_th after the start-up, where nothing is uncertain",
            format!("{:.6}", evaluation.threshold),
        ),
        (
            "share of the uncertainties' bound in J_th",
            format!("{:.3}", evaluation.uncertainty_share),
        ),
        ("window of J_rms", format!("{} samples", evaluation.window)),
        ("weights of v_x and r in J_rms", format!("{:?}", evaluation.weights)),
    ] {
        let _infallible = writeln!(text, "<tr><th>{name}<td>{}", escaped(&value));
    }
    text + "</table>\n"
}

/// What J can be without a fault, by its causes, and the threshold in steady driving.
fn threshold(causes: &[Cause], configuration: &Configuration) -> String {
    let mut text = String::from(
        "<h2>Threshold</h2>\n<p>The threshold after the start-up is the sum of what <code>J_rms</code> can \
         be without a fault, times a margin.</p>\n<table>\n<tr><th>Cause<th>J_rms, at most\n",
    );
    for Cause { cause, j } in causes {
        let j = j.map_or("by the sample".into(), |j| format!("{j:.6}"));
        let _infallible = writeln!(text, "<tr><td>{}<td>{j}", escaped(cause));
    }
    text += "</table>\n<p>J_th in steady driving, and the J that the smallest fault of interest makes \
             alone, in thousandths. In manoeuvres J_th follows the signals; <code>detectability</code> \
             is that J over J_th at every sample.</p>\n<table class=\"figures\">\n";
    text += &table_rows(&cause_rows(&by_cause(configuration)));
    text + "</table>\n"
}

/// What simulated drives with faults show.
fn what_it_sees(sight: &Sight) -> String {
    let mut text = format!(
        "<h2>Sight</h2>\n<p>{}. Recorded when the design was made, not proven: the vehicle as specified \
         under the stated noise, a bias of the road wheel to either side that begins after {} s and stays \
         to the end, at {} s; delays are those of the later side.</p>\n<table class=\"figures\">\n",
        escaped(sight::HEADING),
        number(sight.onset_s),
        number(sight.end_s),
    );
    text += &table_rows(&sight::rows(sight));
    text += "</table>\n";
    for remark in sight::remarks(sight) {
        let _infallible = writeln!(text, "<p>{}</p>", escaped(&remark));
    }
    text
}

/// The first row is the head.
fn table_rows(rows: &[Vec<String>]) -> String {
    let row = |(number, cells): (usize, &Vec<String>)| {
        let tag = if number == 0 { "th" } else { "td" };
        let cells: String = cells.iter().map(|x| format!("<{tag}>{}", escaped(x))).collect();
        format!("<tr>{cells}\n")
    };
    rows.iter().enumerate().map(row).collect()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
