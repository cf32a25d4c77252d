//! The fit: measured and fitted yaw rate of each piece of the drives, one below the other. What is not
//! compared is grey.

use plotters::prelude::*;
use steerguard_identification::{Identified, Trace};

use crate::drive::figure::{Area, Axis, PlotError, SCALE, axes, decimal, document, font, line};

/// Size of a piece's panel, figure pixels.
const PANEL: (u32, u32) = (900, 240);
/// Pieces that are drawn: the longest.
const PIECES: usize = 6;
/// Points of a line at most.
const POINTS: usize = 4000;

const MEASURED: RGBColor = RGBColor(150, 150, 150);
const FITTED: RGBColor = RGBColor(0, 114, 178);
const LEFT_OUT: RGBColor = RGBColor(238, 238, 238);

/// Draws the fit as an SVG document.
///
/// # Errors
/// [`PlotError`] if the drawing library refuses.
pub fn svg(identified: &Identified) -> Result<String, PlotError> {
    let mut traces: Vec<&Trace> = identified.traces.iter().collect();
    traces.sort_by_key(|trace| std::cmp::Reverse(trace.yaw_rate.len()));
    traces.truncate(PIECES);
    let rows = traces.len().max(1);
    document((PANEL.0, PANEL.1 * rows as u32), |root| {
        for (panel, trace) in root.split_evenly((rows, 1)).iter().zip(traces) {
            draw(panel, trace)?;
        }
        Ok(())
    })
}

fn draw(panel: &Area<'_>, trace: &Trace) -> Result<(), PlotError> {
    let time = |k: usize| k as f64 * trace.period_s;
    let samples = trace.yaw_rate.len();
    let all = || trace.yaw_rate.iter().chain(&trace.fitted).map(|r| r.to_degrees());
    let (low, high) = (1.1 * all().fold(-1.0, f64::min), 1.3 * all().fold(1.0, f64::max));
    let axis = Axis { label: "yaw rate [deg/s]", range: low..high, ticks: 5, text: decimal };
    let label = format!("time [s] from {}", decimal(&trace.start_s));
    let mut chart = axes(panel, "", time(samples), &axis, Some(&label))?;

    let runs = trace.compared.chunk_by(|a, b| a == b).scan(0, |at, run| {
        let from = *at;
        *at += run.len();
        Some((from, *at, run.first() == Some(&true)))
    });
    chart.draw_series(runs.filter(|&(.., compared)| !compared).map(|(from, to, _)| {
        Rectangle::new([(time(from), low), (time(to), high)], LEFT_OUT.filled())
    }))?;
    let step = samples.div_ceil(POINTS).max(1);
    let points = |values: &[f64]| -> Vec<(f64, f64)> {
        let drawn = values.iter().enumerate().step_by(step);
        drawn.map(|(k, r)| (time(k), r.to_degrees())).collect()
    };
    chart.draw_series(LineSeries::new(points(&trace.yaw_rate), line(MEASURED, 20)))?;
    chart.draw_series(LineSeries::new(points(&trace.fitted), line(FITTED, 10)))?;

    let pixel = |x: u32, y: u32| ((x * SCALE) as i32, (y * SCALE) as i32);
    for (x, name, style) in
        [(80, "measured", line(MEASURED, 30)), (180, "fitted", line(FITTED, 18))]
    {
        panel.draw(&PathElement::new(vec![pixel(x, 18), pixel(x + 24, 18)], style))?;
        panel.draw(&Text::new(name, pixel(x + 30, 11), font(12)))?;
    }
    Ok(())
}
