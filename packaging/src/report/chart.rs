//! Charts for the page: lines, stacked areas, shaded spans.
//!
//! # Conventions
//! - Colours are those of the page's style sheet, light or dark; dashes and letters tell series apart as well.
//! - The legend stands below as text, so that it grows with the reader's type.

use std::fmt::Write as _;
use std::ops::Range;

use plotters::prelude::*;

use super::html::escaped;
use crate::drive::figure::{Area, PlotError, SCALE, decimal, document, font, line, power_of_ten};

/// Size of a chart, figure pixels.
const SIZE: (u32, u32) = (460, 280);
/// What lies around the plot: margins, and room for labels, figure pixels.
const LEFT: [u32; 2] = [6, 66];
const RIGHT: u32 = 14;
const TOP: u32 = 10;
const BOTTOM: [u32; 2] = [6, 44];
/// Strips of a chart that tell their values.
const STRIPS: u32 = 50;

/// Stand-ins for the variables of the style sheet, by place.
const STAND_INS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(148, 103, 189),
    RGBColor(140, 140, 141),
];
const GRID: RGBColor = RGBColor(225, 225, 226);
const AXIS: RGBColor = RGBColor(90, 90, 91);
const SHADE: RGBColor = RGBColor(253, 224, 221);

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dash {
    Solid,
    Dashed,
    Dotted,
}

/// A line.
pub(super) struct Line {
    /// In the legend; empty for a line that belongs to another.
    pub name: String,
    pub points: Vec<(f64, f64)>,
    /// Place among the colours.
    pub color: usize,
    pub dash: Dash,
}

/// An axis.
pub(super) struct Scale {
    pub label: &'static str,
    /// Of a logarithmic one, of the logarithm.
    pub range: Range<f64>,
    pub logarithmic: bool,
    pub ticks: usize,
}

impl Scale {
    pub(super) fn linear(label: &'static str, range: Range<f64>) -> Self {
        Self { label, range, logarithmic: false, ticks: 6 }
    }

    /// From whole decades to whole decades around `values`.
    pub(super) fn decades(label: &'static str, values: impl Iterator<Item = f64> + Clone) -> Self {
        let positive = values.filter(|x| *x > 0.0 && x.is_finite());
        let least = positive.clone().fold(f64::INFINITY, f64::min);
        let most = positive.fold(0.0, f64::max);
        let (from, to) =
            if most > 0.0 { (least.log10().floor(), most.log10().ceil()) } else { (-1.0, 1.0) };
        let range = from..to.max(from + 1.0);
        Self { label, range, logarithmic: true, ticks: 6 }
    }

    fn place(&self, x: f64) -> f64 {
        let x = if self.logarithmic { x.max(f64::MIN_POSITIVE).log10() } else { x };
        x.clamp(self.range.start, self.range.end)
    }

    fn text(&self) -> fn(&f64) -> String {
        if self.logarithmic { power_of_ten } else { decimal }
    }
}

/// A chart.
pub(super) struct Chart {
    pub title: String,
    /// What it shows, for those who do not see it.
    pub alt: String,
    pub x: Scale,
    pub y: Scale,
    /// Stacked from below, over the same x.
    pub areas: Vec<Line>,
    pub lines: Vec<Line>,
    /// Spans of x that are shaded, and what they are called.
    pub shades: Option<(String, Vec<Range<f64>>)>,
}

impl Chart {
    /// The chart as a figure of the page.
    ///
    /// # Errors
    /// [`PlotError`] if the drawing library refuses.
    pub(super) fn figure(&self) -> Result<String, PlotError> {
        let svg = themed(&document(SIZE, |root| self.draw(root))?);
        let svg = svg.replacen(
            "<svg ",
            &format!("<svg role=\"img\" aria-label=\"{}\" ", escaped(&self.alt)),
            1,
        );
        let svg = svg.replacen("</svg>", &format!("{}</svg>", self.values()), 1);
        let title = escaped(&self.title);
        Ok(format!(
            "<figure>\n<figcaption>{title}</figcaption>\n{svg}\n{}</figure>\n",
            self.legend()
        ))
    }

    fn draw(&self, root: &Area<'_>) -> Result<(), PlotError> {
        let mut builder = ChartBuilder::on(root);
        builder
            .margin_left(LEFT[0] * SCALE)
            .margin_right(RIGHT * SCALE)
            .margin_top(TOP * SCALE)
            .margin_bottom(BOTTOM[0] * SCALE)
            .set_label_area_size(LabelAreaPosition::Bottom, BOTTOM[1] * SCALE)
            .set_label_area_size(LabelAreaPosition::Left, LEFT[1] * SCALE);
        let mut chart = builder.build_cartesian_2d(self.x.range.clone(), self.y.range.clone())?;
        if let Some((_, spans)) = &self.shades {
            let Range { start, end } = self.y.range;
            let corners = spans
                .iter()
                .map(|span| [(self.x.place(span.start), start), (self.x.place(span.end), end)]);
            chart.draw_series(corners.map(|corners| Rectangle::new(corners, SHADE.filled())))?;
        }
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(line(GRID, 7))
            .axis_style(line(AXIS, 8))
            .label_style(font(15))
            .axis_desc_style(font(15))
            .x_desc(self.x.label)
            .y_desc(self.y.label)
            .x_labels(self.x.ticks)
            .y_labels(self.y.ticks)
            .x_label_formatter(&self.x.text())
            .y_label_formatter(&self.y.text())
            .draw()?;
        let place = |&(x, y): &(f64, f64)| (self.x.place(x), self.y.place(y));
        let mut below: Vec<(f64, f64)> = Vec::new();
        for (number, area) in self.areas.iter().enumerate() {
            let at = |k: usize| below.get(k).map_or(0.0, |(_, y)| *y);
            let top: Vec<(f64, f64)> =
                area.points.iter().enumerate().map(|(k, (x, y))| (*x, y + at(k))).collect();
            let floor = area.points.iter().enumerate().rev().map(|(k, (x, _))| (*x, at(k)));
            let outline: Vec<(f64, f64)> =
                top.iter().copied().chain(floor).map(|p| place(&p)).collect();
            let color = stand_in(area.color);
            chart.draw_series(Some(Polygon::new(outline, color.mix(0.55).filled())))?;
            let edge = top.iter().map(place);
            chart.draw_series(LineSeries::new(edge, line(color, 10)))?;
            // Its letter where it is thickest, if it fits.
            let thickest = (0..area.points.len())
                .filter(|k| (1..area.points.len().saturating_sub(1)).contains(k))
                .max_by(|a, b| area.points[*a].1.total_cmp(&area.points[*b].1));
            let high = 0.05 * (self.y.range.end - self.y.range.start);
            if let Some(k) = thickest.filter(|&k| area.points[k].1 > high) {
                let middle = (area.points[k].0, at(k) + 0.5 * area.points[k].1 + 0.4 * high);
                let text = Text::new(letter(number).to_string(), place(&middle), font(14));
                chart.draw_series(Some(text))?;
            }
            below = top;
        }
        for series in &self.lines {
            let points = series.points.iter().map(place);
            let style = line(stand_in(series.color), 18);
            match series.dash {
                Dash::Solid => chart.draw_series(LineSeries::new(points, style))?,
                Dash::Dashed => {
                    chart.draw_series(DashedLineSeries::new(points, 6 * SCALE, 4 * SCALE, style))?
                }
                Dash::Dotted => {
                    chart.draw_series(DashedLineSeries::new(points, 2 * SCALE, 4 * SCALE, style))?
                }
            };
        }
        Ok(())
    }

    /// Invisible strips that tell what the lines are there, where a pointer rests on them; none over a logarithm.
    fn values(&self) -> String {
        let named =
            || self.lines.iter().filter(|line| !line.name.is_empty() && line.points.len() > 2);
        if self.x.logarithmic || named().next().is_none() {
            return String::new();
        }
        let left = LEFT[0] + LEFT[1];
        let width = f64::from((SIZE.0 - left - RIGHT) * SCALE) / f64::from(STRIPS);
        let height = (SIZE.1 - TOP - BOTTOM[0] - BOTTOM[1]) * SCALE;
        let mut strips = String::from("<g class=\"values\" fill=\"transparent\">\n");
        for strip in 0..STRIPS {
            let share = (f64::from(strip) + 0.5) / f64::from(STRIPS);
            let x = self.x.range.start + share * (self.x.range.end - self.x.range.start);
            let told = named().filter_map(|line| {
                Some(format!("\n{} {}", escaped(&line.name), brief(at(&line.points, x)?)))
            });
            let told: String = told.collect();
            if !told.is_empty() {
                let from = f64::from(left * SCALE) + f64::from(strip) * width;
                let _infallible = writeln!(
                    strips,
                    "<rect x=\"{from:.1}\" y=\"{}\" width=\"{width:.1}\" height=\"{height}\">\
                     <title>{} {}{told}</title></rect>",
                    TOP * SCALE,
                    escaped(self.x.label),
                    brief(x),
                );
            }
        }
        strips + "</g>\n"
    }

    fn legend(&self) -> String {
        let mut items = String::new();
        // As they lie on each other.
        for (number, area) in self.areas.iter().enumerate().rev() {
            let (color, name) = (area.color % STAND_INS.len() + 1, escaped(&area.name));
            let letter = letter(number);
            let _infallible = writeln!(
                items,
                "<li><span class=\"key area s{color}\">{letter}</span> {name}</li>"
            );
        }
        for series in self.lines.iter().filter(|series| !series.name.is_empty()) {
            let (color, name) = (series.color % STAND_INS.len() + 1, escaped(&series.name));
            let dash = match series.dash {
                Dash::Solid => "solid",
                Dash::Dashed => "dashed",
                Dash::Dotted => "dotted",
            };
            let _infallible = writeln!(
                items,
                "<li><span class=\"key {dash} s{color}\" aria-hidden=\"true\"></span> {name}</li>"
            );
        }
        if let Some((name, _)) = &self.shades {
            let name = escaped(name);
            let _infallible = writeln!(
                items,
                "<li><span class=\"key shade\" aria-hidden=\"true\"></span> {name}</li>"
            );
        }
        format!("<ul class=\"legend\">\n{items}</ul>\n")
    }
}

/// Where a line is at `x`, straight between its points; `None` beside it.
fn at(points: &[(f64, f64)], x: f64) -> Option<f64> {
    let pair =
        points.windows(2).find(|pair| pair[0].0 <= x && x <= pair[1].0 && pair[0].0 < pair[1].0)?;
    let share = (x - pair[0].0) / (pair[1].0 - pair[0].0);
    Some(pair[0].1 + share * (pair[1].1 - pair[0].1))
}

/// Three digits of a number.
fn brief(x: f64) -> String {
    let magnitude = if x == 0.0 { 0.0 } else { x.abs().log10().floor() };
    let digits = (2.0 - magnitude).clamp(0.0, 8.0) as usize;
    format!("{x:.digits$}")
}

fn stand_in(place: usize) -> RGBColor {
    STAND_INS[place % STAND_INS.len()]
}

fn letter(number: usize) -> char {
    (b'a'..=b'z').nth(number).map_or('?', char::from)
}

/// The drawing in the colours of the style sheet, as wide as its place.
fn themed(svg: &str) -> String {
    let hex = |RGBColor(r, g, b): RGBColor| format!("\"#{r:02X}{g:02X}{b:02X}\"");
    let mut svg = svg.replace(&hex(BLACK), "\"currentColor\"").replace(&hex(WHITE), "\"none\"");
    for (number, color) in STAND_INS.into_iter().enumerate() {
        svg = svg.replace(&hex(color), &format!("\"var(--s{})\"", number + 1));
    }
    for (color, name) in [(GRID, "grid"), (AXIS, "axis"), (SHADE, "shade")] {
        svg = svg.replace(&hex(color), &format!("\"var(--{name})\""));
    }
    let (width, height) = SIZE;
    // Inside HTML the name space goes without saying.
    svg.replacen(&format!("width=\"{width}\" height=\"{height}\" "), "", 1).replacen(
        " xmlns=\"http://www.w3.org/2000/svg\"",
        "",
        1,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_tell_what_the_lines_are() {
        let line = |name: &str, slope: f64| Line {
            name: name.into(),
            points: (0..=10).map(|k| (f64::from(k), slope * f64::from(k))).collect(),
            color: 0,
            dash: Dash::Solid,
        };
        let mut chart = Chart {
            title: "t".into(),
            alt: "a".into(),
            x: Scale::linear("time [s]", 0.0..20.0),
            y: Scale::linear("J", 0.0..1.0),
            areas: Vec::new(),
            lines: vec![line("J & more", 0.001), line("", 1.0)],
            shades: None,
        };
        let figure = chart.figure().unwrap();
        // The middle of the strip, whose width is 0.4 s; the lines end at 10 s.
        assert!(figure.contains("<title>time [s] 2.20\nJ &amp; more 0.00220</title>"), "{figure}");
        assert_eq!(figure.matches("<title>").count(), 25);
        chart.x.logarithmic = true;
        assert_eq!(chart.values(), "");
    }
}
