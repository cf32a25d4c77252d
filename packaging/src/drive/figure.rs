//! What the figures of drives share: sizes, colours, axes over time.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

/// Pixels of the drawing per pixel of the figure: lines are drawn to whole pixels.
pub(crate) const SCALE: u32 = 4;

/// Colour of J.
pub(crate) const J_RMS: RGBColor = RGBColor(0, 114, 178);
/// Colour of J_th.
pub(crate) const J_TH: RGBColor = RGBColor(213, 94, 0);
/// Colour of faults.
pub(crate) const FAULT: RGBColor = RGBColor(60, 60, 60);
/// Colour behind an alarm.
pub(crate) const ALARM: RGBColor = RGBColor(253, 224, 221);
const GRID: RGBColor = RGBColor(225, 225, 225);
const AXIS: RGBColor = RGBColor(90, 90, 90);

/// A figure that could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("cannot draw the plot: {0}")]
pub struct PlotError(String);

impl<E: std::error::Error + Send + Sync> From<DrawingAreaErrorKind<E>> for PlotError {
    fn from(error: DrawingAreaErrorKind<E>) -> Self {
        Self(error.to_string())
    }
}

pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(crate) type Chart<'a, 'b> =
    ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// An SVG document of a `size` in figure pixels that `draw` fills.
///
/// # Errors
/// [`PlotError`] if the drawing library refuses.
pub(crate) fn document(
    size: (u32, u32),
    draw: impl FnOnce(&Area<'_>) -> Result<(), PlotError>,
) -> Result<String, PlotError> {
    let drawn = (size.0 * SCALE, size.1 * SCALE);
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, drawn).into_drawing_area();
        root.fill(&WHITE)?;
        draw(&root)?;
        root.present()?;
    }
    let header = |(width, height): (u32, u32)| format!("width=\"{width}\" height=\"{height}\"");
    Ok(text.replacen(&header(drawn), &header(size), 1))
}

/// Text of a size in figure pixels.
pub(crate) fn font(size: u32) -> TextStyle<'static> {
    ("Helvetica, Arial, sans-serif", size * SCALE).into_font().color(&BLACK)
}

/// A line as wide as so many tenths of a figure pixel.
pub(crate) fn line(color: RGBColor, tenths: u32) -> ShapeStyle {
    color.stroke_width((tenths * SCALE / 10).max(1))
}

/// A vertical axis.
pub(crate) struct Axis {
    pub label: &'static str,
    pub range: Range<f64>,
    pub ticks: usize,
    pub text: fn(&f64) -> String,
}

/// A number with at most six decimals.
pub(crate) fn decimal(y: &f64) -> String {
    format!("{}", (y * 1e6).round() / 1e6)
}

/// `10^y` for whole y.
pub(crate) fn power_of_ten(y: &f64) -> String {
    if (y - y.round()).abs() > 1e-6 {
        return String::new();
    }
    let digits = "⁰¹²³⁴⁵⁶⁷⁸⁹";
    let superscript = |c: char| match c.to_digit(10) {
        Some(digit) => digits.chars().nth(digit as usize).unwrap_or(c),
        None => '⁻',
    };
    let exponent: String = format!("{:.0}", y.round()).chars().map(superscript).collect();
    format!("10{exponent}")
}

/// Axes over time up to `end` in s.
pub(crate) fn axes<'a, 'b>(
    area: &'a Area<'b>,
    title: &str,
    end: f64,
    axis: &Axis,
    x_label: Option<&str>,
) -> Result<Chart<'a, 'b>, PlotError> {
    let mut builder = ChartBuilder::on(area);
    builder.margin_left(8 * SCALE).margin_right(16 * SCALE).margin_top(4 * SCALE);
    let below = if x_label.is_some() { (14, 34) } else { (0, 6) };
    builder.margin_bottom(below.0 * SCALE);
    builder.set_label_area_size(LabelAreaPosition::Bottom, below.1 * SCALE);
    builder.set_label_area_size(LabelAreaPosition::Left, 56 * SCALE);
    if !title.is_empty() {
        builder.caption(title, font(13));
    }
    let mut chart = builder.build_cartesian_2d(0.0..end, axis.range.clone())?;
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(TRANSPARENT)
        .bold_line_style(line(GRID, 7))
        .axis_style(line(AXIS, 8))
        .label_style(font(11))
        .axis_desc_style(font(12))
        .y_desc(axis.label)
        .y_labels(axis.ticks)
        .y_label_formatter(&axis.text)
        .x_labels(if x_label.is_some() { 6 } else { 0 })
        .x_label_formatter(&decimal);
    if let Some(label) = x_label {
        mesh.x_desc(label);
    }
    mesh.draw()?;
    Ok(chart)
}
