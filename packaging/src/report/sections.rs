//! The sections that any page of a design has, the verdict first.

use std::fmt::Write as _;
use std::ops::Range;

use steerguard_designer::sight::{CourseSight, FaultSight, Moment, Sight};
use steerguard_designer::threshold::{SteadyThreshold, by_cause, cause_names};
use steerguard_detector::{Configuration, Estimator, Gains, Interval};
use steerguard_fmu::BakedDesign;

use super::chart::{Chart, Dash, Line, Scale};
use super::design_summary::{Cause, Record, cause_rows};
use super::html::{Cells, Section, command, details, escaped, pairs, paragraph, table};
use super::pictures::{FaultDrive, Pictures, Residuals};
use super::sight;
use crate::drive::figure::PlotError;

/// Decades of J that are drawn below the lowest threshold.
const BELOW: f64 = 1.0;
/// What is drawn of residuals over frequency, below the largest.
const FOUR_DECADES: f64 = 1e-4;
/// J in the tables and charts of causes.
const THOUSANDTHS: f64 = 1e3;

/// What is seen, from which size, how fast; what cannot be.
pub(super) fn verdict(design: &BakedDesign, record: &Record) -> Section {
    let mut html = String::new();
    let class = if design.certified && !design.blind { "verdict" } else { "verdict no" };
    let proof = match design.certified {
        true => "The gains are proven",
        false => "The gains are NOT proven",
    };
    let sees = match (&record.sight, design.blind) {
        (_, true) => "and the design is BLIND: its drives miss the smallest fault of interest.",
        (Some(_), false) => "and the design sees its smallest fault of interest.",
        (None, false) => "and nothing was driven.",
    };
    let _infallible =
        write!(html, "<div class=\"{class}\">\n<p><strong>{proof}, {sees}</strong></p>\n");
    for sentence in record.sight.as_ref().map_or(Vec::new(), headlines) {
        html += &paragraph(&sentence);
    }
    html += "</div>\n";
    for sentence in &record.fault_free {
        html += &paragraph(sentence);
    }
    if let Some(sight) = &record.sight {
        html += &sight_table(sight);
    }
    html += "<p>Not to be seen by any detector: a wheel that sticks where it is commanded straight, a fault while the \
             detector does not monitor (slow, reversing, disabled), and what hides below the uncertainty that is \
             stated.</p>\n";
    html += &second(design.configuration.estimator.as_ref(), &record.second);
    Section { id: "verdict", title: "Verdict", html }
}

/// What is seen straight ahead and in the turn, in a sentence each.
fn headlines(sight: &Sight) -> Vec<String> {
    let of = |judged: bool| sight.courses.iter().filter(move |x| x.is_judged() == judged);
    let seen_from = |judged: bool| {
        of(judged).try_fold(0.0, |most: f64, x: &CourseSight| Some(most.max(x.seen_from_deg?)))
    };
    let mut sentences = Vec::new();
    if let Some(deg) = seen_from(true) {
        let smallest = |x: &CourseSight| x.faults.first().filter(|fault| fault.seen).copied();
        let faults: Vec<FaultSight> = of(true).filter_map(smallest).collect();
        let within = faults.iter().filter_map(|x| x.delay_s).fold(0.0, f64::max);
        let mut sentence = format!(
            "Straight ahead a wheel that is off by {:.2} degrees or more is seen at every speed that was driven",
            rounded_up(deg)
        );
        if let Some(first) = faults.first() {
            let _infallible =
                write!(sentence, "; one off by {} degrees within {within:.2} s", first.fault_deg);
        }
        sentences.push(sentence + ".");
    }
    let turn = of(false).map(|x| x.lateral_acceleration_m_per_s2).fold(0.0, f64::max);
    match seen_from(false) {
        Some(deg) => sentences.push(format!(
            "In a turn of up to {turn:.1} m/s² it is seen from {:.2} degrees.",
            rounded_up(deg)
        )),
        None => sentences.push(format!("In a turn of {turn:.1} m/s² not every fault is seen.")),
    }
    sentences
}

/// To hundredths: what is said to be seen is.
fn rounded_up(deg: f64) -> f64 {
    (100.0 * deg).ceil() / 100.0
}

fn sight_table(sight: &Sight) -> String {
    let mut html = format!("<h3>{}</h3>\n", "Faults that begin during the drive");
    html += &paragraph(&format!(
        "Recorded when the design was made, not proven: the vehicle as specified under the stated noise, a bias of the \
         road wheel to either side that begins after {} s and stays to the end, at {} s. Cells are seconds until the \
         alarm that stays, of the later side.",
        sight.onset_s, sight.end_s
    ));
    html += &table(sight::HEADING, Cells::Figures, &sight::rows(sight));
    for remark in sight::remarks(sight) {
        html += &paragraph(&remark);
    }
    html
}

/// Whether there is a second test, and what its threshold rests on.
fn second(estimator: Option<&Estimator>, sentences: &[String]) -> String {
    let mut html = String::from("<h3>Second test</h3>\n");
    match estimator {
        None => {
            html +=
                "<p>None: <code>second_ratio</code> and <code>fault_estimate</code> stay 0.</p>\n"
        }
        Some(Estimator { threshold, estimate_factor, .. }) => {
            let _infallible = writeln!(
                html,
                "<p>Beside the residual a Kalman filter that is told what is uncertain looks for a constant angle that \
                 the road wheel is off by since some sample. <code>second_ratio</code> is the statistic of the likeliest \
                 over its threshold, {threshold:.3}; from 1 on the alarm is raised, <code>alarm_cause</code> SecondTest, \
                 and <code>fault_estimate</code> is the angle, which acts from <code>fault_onset_time</code> on. \
                 <code>fault_estimate_bound</code> is what its error stays below in 99 of 100 seconds of drives like those \
                 of the calibration (statistic {estimate_factor:.3}).</p>"
            );
        }
    }
    html + &sentences.iter().map(|x| paragraph(x)).collect::<String>()
}

/// J and J_th second by second.
pub(super) fn drives(pictures: &Pictures) -> Result<Option<Section>, PlotError> {
    let Some(first) = pictures.drives.first() else {
        return Ok(None);
    };
    let mut html = paragraph(&format!(
        "Straight ahead under the stated noise; after {} s the road wheel stands {} deg to the left of where it is \
         commanded to be, twice the smallest fault of interest. The alarm is J reaching J_th.",
        first.onset_s, first.fault_deg
    ));
    html += "<div class=\"charts\">\n";
    let range = decades(&pictures.drives);
    for drive in &pictures.drives {
        html += &of_drive(drive, range.clone()).figure()?;
    }
    html += "</div>\n";
    Ok(Some(Section { id: "drives", title: "A fault, second by second", html }))
}

/// J that all drives are drawn over, in decades.
fn decades(drives: &[FaultDrive]) -> Range<f64> {
    let moments = || drives.iter().flat_map(|drive| &drive.moments);
    let lowest = moments().map(|x| x.j_th).fold(f64::INFINITY, f64::min);
    let highest = moments().map(|x| x.j_rms.max(x.j_th)).fold(0.0, f64::max);
    match lowest > 0.0 && highest.is_finite() {
        true => (lowest.log10() - BELOW).floor()..(1.3 * highest).log10(),
        false => -3.0..0.0,
    }
}

fn of_drive(drive: &FaultDrive, range: Range<f64>) -> Chart {
    let FaultDrive { v_x_m_per_s, fault_deg, onset_s, moments } = drive;
    let end = moments.last().map_or(1.0, |moment| moment.time_s);
    let raised = moments.iter().find(|x| x.alarm && x.time_s > *onset_s);
    let told = match raised {
        Some(moment) => format!("alarm {:.2} s after the fault", moment.time_s - onset_s),
        None => "no alarm".into(),
    };
    let [bottom, top] = [range.start, range.end].map(|decade| 10_f64.powf(decade));
    let line = |name: &str, color, dash, value: fn(&_) -> f64| Line {
        name: name.into(),
        points: moments.iter().map(|x| (x.time_s, value(x))).collect(),
        color,
        dash,
    };
    let spans = moments.chunk_by(|a, b| a.alarm == b.alarm).filter_map(|episode| {
        let (first, last) = (episode.first()?, episode.last()?);
        first.alarm.then_some(first.time_s..last.time_s)
    });
    Chart {
        title: format!("{v_x_m_per_s:.1} m/s: {told}"),
        alt: format!(
            "J and its threshold over {end:.0} s at {v_x_m_per_s:.1} m/s; a fault of {fault_deg} degrees at {onset_s} s: \
             {told}"
        ),
        x: Scale::linear("time [s]", 0.0..end),
        y: Scale { label: "J", range, logarithmic: true, ticks: 5 },
        areas: Vec::new(),
        lines: vec![
            line("J_rms", 0, Dash::Solid, |x: &Moment| x.j_rms),
            line("threshold J_th", 1, Dash::Dashed, |x| x.j_th),
            Line {
                name: "fault begins".into(),
                points: vec![(*onset_s, bottom), (*onset_s, top)],
                color: 7,
                dash: Dash::Dotted,
            },
        ],
        shades: Some(("alarm".into(), spans.collect())),
    }
}

/// What J can be without a fault, by its causes, and the threshold in steady driving.
pub(super) fn threshold(
    record: &Record,
    configuration: &Configuration,
) -> Result<Section, PlotError> {
    let mut html = String::from(
        "<p>The threshold after the start-up is the sum of what <code>J_rms</code> can be without a fault, times a \
         margin. In manoeuvres it follows the signals; <code>detectability</code> is the J of the smallest fault of \
         interest over J_th at every sample.</p>\n",
    );
    if let Some(pictures) = &record.pictures {
        html += "<div class=\"charts\">\n";
        for thresholds in &pictures.thresholds {
            html += &by_speed(thresholds).figure()?;
        }
        html += "</div>\n";
    }
    let mut rows = vec![["Cause", "J_rms, at most"].map(String::from).to_vec()];
    rows.extend(record.causes.iter().map(|Cause { cause, j }| {
        vec![cause.clone(), j.map_or("by the sample".into(), |j| format!("{j:.6}"))]
    }));
    html += &table("What J can be without a fault", Cells::Words, &rows);
    html += &table(
        "J_th in steady driving by cause, and the J of the smallest fault of interest; thousandths",
        Cells::Figures,
        &cause_rows(&by_cause(configuration)),
    );
    Ok(Section { id: "threshold", title: "Where the threshold comes from", html })
}

fn by_speed(thresholds: &[SteadyThreshold]) -> Chart {
    let a_y = thresholds.iter().map(|x| x.lateral_acceleration_m_per_s2).fold(0.0, f64::max);
    let points = |of: &dyn Fn(&SteadyThreshold) -> f64| -> Vec<(f64, f64)> {
        thresholds.iter().map(|x| (x.v_x_m_per_s, THOUSANDTHS * of(x))).collect()
    };
    let mut areas = vec![Line {
        name: "noise, disturbances".into(),
        points: points(&|x| x.level),
        color: 7,
        dash: Dash::Solid,
    }];
    for (k, name) in cause_names().into_iter().enumerate() {
        if thresholds.iter().any(|x| x.uncertainties[k] > 0.0) {
            let color = areas.len() - 1;
            let points = points(&|x| x.uncertainties[k]);
            areas.push(Line { name: name.into(), points, color, dash: Dash::Solid });
        }
    }
    let smallest = points(&|x| x.smallest_fault_j);
    let most = |values: &[(f64, f64)]| values.iter().map(|(_, y)| *y).fold(0.0, f64::max);
    let highest = most(&points(&|x| x.j_th));
    // A fault far above the threshold leaves the picture.
    let range = 0.0..(1.1 * highest.max(most(&smallest).min(2.0 * highest))).max(1e-9);
    let Range { start: slow, end: fast } = ends(thresholds.iter().map(|x| x.v_x_m_per_s));
    let course = match a_y > 0.0 {
        true => format!("in a turn of {a_y:.1} m/s²"),
        false => "straight ahead".into(),
    };
    Chart {
        title: format!("J_th by cause, {course}"),
        alt: format!(
            "The causes of the threshold, stacked, over speeds of {slow:.1} to {fast:.1} m/s, {course}; the table below \
             has the figures"
        ),
        x: Scale::linear("v_x [m/s]", slow..fast),
        y: Scale::linear("J x 1000", range),
        areas,
        lines: vec![Line {
            name: "J of the smallest fault".into(),
            points: smallest,
            color: 0,
            dash: Dash::Dashed,
        }],
        shades: None,
    }
}

/// From the first of rising `speeds` to the last, in m/s; no axis is empty.
fn ends(mut speeds: impl DoubleEndedIterator<Item = f64>) -> Range<f64> {
    let slow = speeds.next().unwrap_or(0.0);
    slow..speeds.next_back().unwrap_or(slow).max(slow + 1e-6)
}

/// Residuals over frequency, and poles over speed.
pub(super) fn frequency(pictures: &Pictures) -> Result<Section, PlotError> {
    let mut html = String::from(
        "<p>First the weighted residual that the smallest fault of interest makes at least, and disturbances at their \
         bounds at most, the worst of the operating points; what the certificate proves in the bands, whatever the \
         premise does, is dotted. Then the poles of the error straight ahead, whose magnitude below 1 is how fast it \
         forgets.</p>\n<div class=\"charts\">\n",
    );
    html += &over_frequency(pictures).figure()?;
    html += &poles(pictures).figure()?;
    html += "</div>\n";
    Ok(Section { id: "frequency", title: "Over frequency and speed", html })
}

fn over_frequency(pictures: &Pictures) -> Chart {
    let points = |of: fn(&Residuals) -> f64| -> Vec<(f64, f64)> {
        let points = pictures.frequencies.iter().map(|x| (x.hz, of(x)));
        points.filter(|(_, y)| *y > 0.0).collect()
    };
    let (fault, disturbances) = (points(|x| x.fault), points(|x| x.disturbances));
    let drawn = fault.iter().chain(&disturbances).map(|(_, y)| *y);
    let certified = pictures.certified.into_iter().flatten();
    let values: Vec<f64> = drawn.chain(certified).collect();
    let largest = values.iter().copied().fold(0.0, f64::max);
    let visible = values.iter().copied().filter(|y| *y >= FOUR_DECADES * largest);
    let y = Scale::decades("W_r r", visible);
    let x = Scale::decades("frequency [Hz]", pictures.frequencies.iter().map(|x| x.hz));
    let lowest = 10_f64.powf(x.range.start);
    let mut lines = vec![
        Line {
            name: "smallest fault, at least".into(),
            points: fault,
            color: 0,
            dash: Dash::Solid,
        },
        Line {
            name: "disturbances at their bounds, at most".into(),
            points: disturbances,
            color: 1,
            dash: Dash::Dashed,
        },
    ];
    let span = |[from, to]: [f64; 2], level| vec![(from.max(lowest), level), (to, level)];
    if let Some([beta, gamma]) = pictures.certified {
        for (number, (name, band)) in pictures.bands_hz.iter().enumerate() {
            let (color, level, figure) =
                if number == 0 { (0, beta, "beta") } else { (1, gamma, "gamma") };
            let points = span(*band, level);
            let name = format!("certified {figure}, {name}'s band");
            lines.push(Line { name, points, color, dash: Dash::Dotted });
        }
    }
    let band = pictures.bands_hz.first().map(|(_, [from, to])| from.max(lowest)..*to);
    let spans: Vec<Range<f64>> = band.into_iter().collect();
    Chart {
        title: "Residual of fault and disturbance".into(),
        alt: format!(
            "Singular values over frequency: the least residual of the smallest fault and the largest of disturbances{}",
            pictures.certified.map_or(String::new(), |[beta, gamma]| format!(
                "; certified at least {beta:.4} and at most {gamma:.4} in their bands"
            ))
        ),
        x,
        y,
        areas: Vec::new(),
        lines,
        shades: Some(("the fault's band".into(), spans)),
    }
}

fn poles(pictures: &Pictures) -> Chart {
    let Range { start: slow, end: fast } = ends(pictures.poles.iter().map(|(v_x, _)| *v_x));
    let of = |k: usize| pictures.poles.iter().map(move |(v_x, magnitudes)| (*v_x, magnitudes[k]));
    let largest = of(0).map(|(_, z)| z).fold(0.0, f64::max);
    let line = |(k, dash): (usize, Dash)| Line {
        name: ["slowest pole", "second", "fastest"][k].into(),
        points: of(k).collect(),
        color: k,
        dash,
    };
    let lines = [Dash::Solid, Dash::Dashed, Dash::Dotted].into_iter().enumerate().map(line);
    Chart {
        title: "Poles of the error".into(),
        alt: format!(
            "Magnitudes of the three poles of the error over speeds of {slow:.1} to {fast:.1} m/s; the largest is \
             {largest:.4}"
        ),
        x: Scale::linear("v_x [m/s]", slow..fast),
        y: Scale::linear("magnitude", 0.0..largest.max(1.0)),
        areas: Vec::new(),
        lines: lines.collect(),
        shades: None,
    }
}

/// What is proven, in the verifier's sentences.
pub(super) fn proof(record: &Record) -> Section {
    let list = |sentences: &[String]| {
        let items: String =
            sentences.iter().map(|x| format!("<li>{}</li>\n", escaped(x))).collect();
        format!("<ul>\n{items}</ul>\n")
    };
    let mut html = match record.statements.is_empty() {
        true => "<p>Nothing.</p>\n".to_owned(),
        false => list(&record.statements),
    };
    if !record.unchecked.is_empty() {
        html += &details("Neither proven nor recomputed", &list(&record.unchecked));
    }
    html += "<p>A certificate is about gains and linear algebra, not about sight: what is seen is in the verdict. To \
             check it again, without the solver, in exact arithmetic:</p>\n";
    html += &command("steerguard verify design.json");
    Section { id: "proof", title: "What is proven", html }
}

/// The vehicle and what was asked.
pub(super) fn specification(record: &Record) -> Option<Section> {
    let spec = record.spec.as_ref()?;
    let v = &spec.vehicle;
    let wheelbase = v.front_axle_distance_m + v.rear_axle_distance_m;
    let load = v.front_cornering_stiffness_n_per_rad * v.front_axle_distance_m;
    let against = v.rear_cornering_stiffness_n_per_rad * v.rear_axle_distance_m;
    let steers = match against / load {
        x if x > 1.02 => "understeers",
        x if x < 0.98 => "oversteers",
        _ => "steers neutrally",
    };
    let range = &spec.operating_range;
    let [slow, fast] = range.v_x_m_per_s;
    let html = paragraph(&format!(
        "A vehicle of {} kg with a wheelbase of {wheelbase:.3} m, which {steers}, watched from {slow} to {fast} m/s every \
         {} s. Not known better than stated are mass and yaw inertia within {:?} and {:?} %, the stiffnesses in front and \
         behind within {:?} and {:?} %, a road bank up to {} degrees and gusts up to {} m/s.",
        v.mass_kg,
        spec.sampling.period_s,
        spec.uncertainty.mass_percent,
        spec.uncertainty.yaw_inertia_percent,
        spec.uncertainty.front_cornering_stiffness_percent,
        spec.uncertainty.rear_cornering_stiffness_percent,
        spec.uncertainty.bank_deg,
        spec.uncertainty.gust_m_per_s,
    ));
    let toml = toml::to_string(spec).unwrap_or_default();
    let whole = format!(
        "<pre tabindex=\"0\" aria-label=\"specification\"><code>{}</code></pre>\n",
        escaped(&toml)
    );
    let html = html + &details("The specification, every key", &whole);
    Some(Section { id: "specification", title: "Vehicle and specification", html })
}

/// The numbers that the detector runs on.
pub(super) fn numbers(design: &BakedDesign) -> Section {
    let configuration = &design.configuration;
    let (model, evaluation) = (&configuration.model, &configuration.evaluation);
    let interval = |i: Interval, unit: &str| format!("{} to {} {unit}", i.min, i.max);
    let rows = [
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
    ];
    let rows: Vec<(String, String)> =
        rows.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
    let html = pairs("What is baked into the detector", &rows)
        + &details("Gains of the observer", &gains(&configuration.gains));
    Section { id: "design", title: "Design", html }
}

/// M, E, and N, L and H of each rule.
fn gains(gains: &Gains) -> String {
    let mut html = matrix("M", &gains.m) + &matrix("E", &gains.e);
    for (number, (n, l)) in gains.n.iter().zip(&gains.l).enumerate() {
        html += &matrix(&format!("N of rule {}", number + 1), n);
        html += &matrix(&format!("L of rule {}", number + 1), l);
    }
    html
}

fn matrix<const K: usize>(name: &str, rows: &[[f64; K]; 3]) -> String {
    let columns = std::iter::once((1..=K).map(|k| k.to_string()).collect());
    let rows = rows.iter().map(|row| row.iter().map(|x| format!("{x:.9e}")).collect());
    table(name, Cells::Figures, &columns.chain(rows).collect::<Vec<Vec<String>>>())
}
