//! `documentation/index.html` of the FMUs: what they are, how to wire them, which design is inside.
//! One page, no scripts, nothing to fetch.

use std::fmt::Write as _;

use steerguard_detector::Interval;
use steerguard_fmu::BakedDesign;
use steerguard_model_description::{Causality, Kind, ModelInfo, Role, Variable};

const STYLE: &str = "body{font:16px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em;\
color:#222}table{border-collapse:collapse;width:100%}th,td{text-align:left;padding:.25em .75em;\
border-bottom:1px solid #ddd;vertical-align:top}code{background:#f3f3f3;padding:0 .2em}";

const DETECTOR: &str = "\
<h2>Wiring</h2>
<ul>
<li>Axes are those of ISO 8855: x forward, y left, yaw rate counter-clockwise. SI units throughout.</li>
<li><code>v_x</code> and <code>r</code>: measured speed and yaw rate.</li>
<li><code>u.T_eng</code>: drive torque at the wheels. <code>u.delta</code>: commanded angle <em>at the
road wheel</em>, after the steering ratio. Both as they act from the communication point on.</li>
<li><code>alarm</code> is <code>J_rms &ge; J_th</code>; <code>alarm_latched</code> and
<code>first_alarm_time</code> remember it.</li>
<li><code>state</code> says which condition holds: Starting, Monitoring, OutOfRange (outside the range
of the design, the alarm is withheld), InvalidInput (an input is no number, the last results are
held).</li>
<li>The detector samples on its own grid. Communication steps of any length are legal; outputs after a
step are those of the last sample run.</li>
</ul>
";

const PLANT: &str = "\
<h2>Use</h2>
<p>The plant integrates with steps of 1 ms and holds its inputs over each of them. Parameters are set
before initialisation ends; <code>vehicle.*</code> carry the names that the detector gives the vehicle it
was designed for. <code>fault</code> is added to the angle of the steering actuator.</p>
";

/// The page of `SteeringFaultDetector.fmu`.
pub fn detector(info: &ModelInfo, variables: &[Variable], design: &BakedDesign) -> String {
    page(info, variables, &format!("{DETECTOR}{}", summary(design)))
}

/// The page of `VehiclePlant.fmu`.
pub fn plant(info: &ModelInfo, variables: &[Variable]) -> String {
    page(info, variables, PLANT)
}

fn page(info: &ModelInfo, variables: &[Variable], body: &str) -> String {
    let (name, description) = (escaped(info.name), escaped(info.description));
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{name}</title>\n\
         <style>{STYLE}</style>\n</head>\n<body>\n<h1>{name}</h1>\n<p>{description}</p>\n{body}"
    );
    for (title, holds) in [
        ("Inputs", &(|role: Role| role.causality == Causality::Input) as &dyn Fn(Role) -> bool),
        ("Outputs", &|role| role.causality == Causality::Output),
        ("Parameters", &|role| role.causality == Causality::Parameter),
        ("Internal", &|role| role.causality == Causality::Local && role != Role::CONSTANT),
        ("Constants", &|role| role == Role::CONSTANT),
    ] {
        let rows: String = variables.iter().filter(|v| holds(v.role)).map(row).collect();
        if !rows.is_empty() {
            page += &format!("<h2>{title}</h2>\n<table>\n<tr><th>Name<th>Type<th>Meaning\n{rows}");
            page += "</table>\n";
        }
    }
    page += "<p>Licences of this FMU and of what is linked into it are in <code>licenses/</code>.</p>\n\
             </body>\n</html>\n";
    page
}

fn row(variable: &Variable) -> String {
    let kind = match &variable.kind {
        Kind::Real(real) if real.unit.name != "1" => real.unit.name.to_owned(),
        Kind::Enumeration(enumeration) => {
            let items = enumeration.items.iter().zip(1..);
            items
                .map(|(item, value)| format!("{value} {}", item.name))
                .collect::<Vec<_>>()
                .join(", ")
        }
        other => other.name().to_owned(),
    };
    format!(
        "<tr><td><code>{}</code><td>{}<td>{}\n",
        escaped(variable.name),
        escaped(&kind),
        escaped(variable.description)
    )
}

fn summary(design: &BakedDesign) -> String {
    let configuration = &design.configuration;
    let (model, evaluation) = (&configuration.model, &configuration.evaluation);
    let interval = |i: Interval, unit: &str| format!("{} to {} {unit}", i.min, i.max);
    let mut text = String::from("<h2>Design</h2>\n<table>\n");
    for (name, value) in [
        ("design file, SHA-256", String::from_utf8_lossy(&design.hash).into_owned()),
        ("sampling period T_s", format!("{} s", model.sampling_period_s)),
        ("range of v_x", interval(model.range.v_x, "m/s")),
        ("range of v_y", interval(model.range.v_y, "m/s")),
        ("range of r", interval(model.range.r, "rad/s")),
        ("fault sensitivity beta", format!("{:.6}", design.beta)),
        ("disturbance gain gamma", format!("{:.6}", design.gamma)),
        ("threshold J_th after the start-up", format!("{:.6}", evaluation.threshold)),
        ("window of J_rms", format!("{} samples", evaluation.window)),
        ("weights of v_x and r in J_rms", format!("{:?}", evaluation.weights)),
    ] {
        let _infallible = writeln!(text, "<tr><th>{name}<td>{}", escaped(&value));
    }
    text + "</table>\n"
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
