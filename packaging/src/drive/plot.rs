//! The paper's Fig. 1 for each run: J against its threshold on a logarithmic axis, the fault below, the
//! alarm behind both. All runs share their axes.

use std::ops::Range;

use plotters::prelude::*;

use crate::drive::cosimulation::{Run, Sample};
use crate::drive::detection::Detection;
use crate::drive::figure::{
    ALARM, Area, Axis, Chart, FAULT, J_RMS, J_TH, SCALE, axes, decimal, document, font, line,
    power_of_ten,
};

pub use crate::drive::figure::PlotError;

/// Size of one run's panel, figure pixels.
const PANEL: (u32, u32) = (560, 350);
/// Height of the legend, figure pixels.
const LEGEND: u32 = 34;

/// Draws `runs` with their figures as an SVG document.
///
/// # Errors
/// [`PlotError`] if the drawing library refuses.
pub fn svg(runs: &[(Run, Detection)]) -> Result<String, PlotError> {
    let columns = if runs.len() > 1 { 2 } else { 1 };
    let rows = runs.len().div_ceil(columns).max(1);
    let size = (PANEL.0 * columns as u32, PANEL.1 * rows as u32 + LEGEND);
    let (decades, degrees) = (decades(runs), degrees(runs));
    document(size, |root| {
        let (legend, panels) = root.split_vertically(LEGEND * SCALE);
        draw_legend(&legend)?;
        for (panel, (run, detection)) in panels.split_evenly((rows, columns)).iter().zip(runs) {
            draw_run(panel, run, detection, &decades, &degrees)?;
        }
        Ok(())
    })
}

fn draw_legend(area: &Area<'_>) -> Result<(), PlotError> {
    let pixel = |x: u32, y: u32| ((x * SCALE) as i32, (y * SCALE) as i32);
    let stroke = |x: u32| vec![pixel(x, 20), pixel(x + 28, 20)];
    area.draw(&PathElement::new(stroke(70), line(J_RMS, 18)))?;
    area.draw(&Text::new("J_rms", pixel(104, 13), font(13)))?;
    for dash in 0..4 {
        let x = 180 + 8 * dash;
        area.draw(&PathElement::new(vec![pixel(x, 20), pixel(x + 5, 20)], line(J_TH, 18)))?;
    }
    area.draw(&Text::new("threshold J_th", pixel(217, 13), font(13)))?;
    area.draw(&PathElement::new(stroke(340), line(FAULT, 18)))?;
    area.draw(&Text::new("steering fault", pixel(374, 13), font(13)))?;
    area.draw(&Rectangle::new([pixel(490, 13), pixel(518, 27)], ALARM.filled()))?;
    area.draw(&Text::new("alarm", pixel(524, 13), font(13)))?;
    Ok(())
}

fn draw_run(
    panel: &Area<'_>,
    run: &Run,
    detection: &Detection,
    decades: &Range<f64>,
    degrees: &Range<f64>,
) -> Result<(), PlotError> {
    let (upper, lower) = panel.split_vertically(PANEL.1 * SCALE * 64 / 100);
    let end = run.samples.len() as f64 * run.step_s;
    let series = |value: &dyn Fn(&Sample) -> f64| -> Vec<(f64, f64)> {
        run.samples.iter().map(|sample| (sample.time, value(sample))).collect()
    };
    let decade = |j: f64| j.log10().max(decades.start);

    let axis = Axis { label: "J", range: decades.clone(), ticks: 5, text: power_of_ten };
    let mut chart = axes(&upper, &title(detection), end, &axis, None)?;
    shade_alarm(&mut chart, run, decades)?;
    let (dash, gap) = (5 * SCALE, 3 * SCALE);
    let j_th = series(&|sample| decade(sample.j_th));
    chart.draw_series(DashedLineSeries::new(j_th, dash, gap, line(J_TH, 14)))?;
    chart.draw_series(LineSeries::new(series(&|sample| decade(sample.j_rms)), line(J_RMS, 14)))?;

    let axis = Axis { label: "fault [deg]", range: degrees.clone(), ticks: 3, text: decimal };
    let mut chart = axes(&lower, "", end, &axis, Some("time [s]"))?;
    shade_alarm(&mut chart, run, degrees)?;
    chart.draw_series(LineSeries::new(series(&|s| s.fault.to_degrees()), line(FAULT, 14)))?;
    Ok(())
}

/// Decades of J that all runs are drawn over: from a hundredth of the lowest threshold.
fn decades(runs: &[(Run, Detection)]) -> Range<f64> {
    let samples = || runs.iter().flat_map(|(run, _)| &run.samples);
    let lowest = samples().map(|sample| sample.j_th).fold(1.0, f64::min).max(1e-30);
    let highest = samples().map(|s| s.j_rms.max(s.j_th)).fold(lowest, f64::max);
    (lowest.log10() - 2.0).floor()..(1.2 * highest).log10()
}

/// Degrees of fault that all runs are drawn over.
fn degrees(runs: &[(Run, Detection)]) -> Range<f64> {
    let faults = || {
        let samples = runs.iter().flat_map(|(run, _)| &run.samples);
        samples.map(|sample| sample.fault.to_degrees())
    };
    let (lowest, highest) = (faults().fold(0.0, f64::min), faults().fold(0.0, f64::max));
    1.15 * lowest..(1.15 * highest).max(1e-3)
}

fn title(detection: &Detection) -> String {
    let speed = format!("v_x(0) = {} m/s", detection.initial_speed_m_per_s);
    match (detection.alarm_s, detection.delay_s) {
        (Some(alarm), Some(delay)) => {
            format!("{speed}: alarm at {alarm:.2} s, {delay:.2} s after the fault")
        }
        _ if detection.fault_onset_s.is_none() => speed,
        _ if detection.monitored_at_onset => format!("{speed}: no alarm"),
        _ => format!("{speed}: outside the range of the design, alarm withheld"),
    }
}

/// Fills the time in which the alarm is on.
fn shade_alarm(chart: &mut Chart<'_, '_>, run: &Run, range: &Range<f64>) -> Result<(), PlotError> {
    let boxes = run.samples.chunk_by(|a, b| a.alarm == b.alarm).filter_map(|episode| {
        let (first, last) = (episode.first()?, episode.last()?);
        let corners = [(first.time, range.start), (last.time + run.step_s, range.end)];
        first.alarm.then(|| Rectangle::new(corners, ALARM.filled()))
    });
    chart.draw_series(boxes)?;
    Ok(())
}
