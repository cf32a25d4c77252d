//! J and J_th of a run over time, and its speed; long runs are thinned to what a figure can show.

use plotters::prelude::*;

use super::trace::TraceRow;
use crate::drive::detection::MONITORING;
use crate::drive::figure::{
    ALARM, Area, Axis, Chart, FAULT, J_RMS, J_TH, PlotError, SCALE, axes, decimal, document, font,
    line, power_of_ten,
};

/// Size of the panels, figure pixels.
const PANEL: (u32, u32) = (900, 420);
/// Height of the legend, figure pixels.
const LEGEND: u32 = 34;
/// Colour behind what is not monitored.
const IDLE: RGBColor = RGBColor(236, 236, 236);
/// Most bins that a run is thinned to.
const BINS: usize = 2000;

/// Neighbouring samples.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bin {
    from_s: f64,
    to_s: f64,
    piece: u64,
    /// Smallest and largest of each.
    j: [f64; 2],
    j_th: [f64; 2],
    v_x: [f64; 2],
    alarm: bool,
    monitored: bool,
}

impl Bin {
    fn with(&self, next: &Self) -> Self {
        let joined = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        Self {
            from_s: self.from_s,
            to_s: next.to_s,
            piece: self.piece,
            j: joined(self.j, next.j),
            j_th: joined(self.j_th, next.j_th),
            v_x: joined(self.v_x, next.v_x),
            alarm: self.alarm || next.alarm,
            monitored: self.monitored && next.monitored,
        }
    }
}

/// A run as it is drawn: the extremes of more samples a bin, the longer it is.
#[derive(Clone, Debug)]
pub(super) struct Thinned {
    period_s: f64,
    bins: Vec<Bin>,
    /// Samples of a bin.
    width: u32,
    /// Samples in the last one.
    filled: u32,
}

impl Thinned {
    /// Of a run with a sample every `period_s`.
    pub fn new(period_s: f64) -> Self {
        Self { period_s, bins: Vec::new(), width: 1, filled: 0 }
    }

    /// Takes the next sample.
    pub fn add(&mut self, row: &TraceRow) {
        let bin = Bin {
            from_s: row.time,
            to_s: row.time + self.period_s,
            piece: row.piece,
            j: [row.j_rms; 2],
            j_th: [row.j_th; 2],
            v_x: [row.v_x; 2],
            alarm: row.alarm,
            monitored: row.state == MONITORING,
        };
        match self.bins.last_mut() {
            Some(last) if self.filled < self.width && last.piece == bin.piece => {
                *last = last.with(&bin);
                self.filled += 1;
            }
            _ => {
                if self.bins.len() == BINS {
                    let pairs = self.bins.chunks(2).map(|pair| match pair {
                        [a, b] => a.with(b),
                        _ => pair[0],
                    });
                    self.bins = pairs.collect();
                    self.width *= 2;
                }
                self.bins.push(bin);
                self.filled = 1;
            }
        }
    }

    /// Draws it as an SVG document.
    ///
    /// # Errors
    /// [`PlotError`] if the drawing library refuses.
    pub fn svg(&self, title: &str) -> Result<String, PlotError> {
        document((PANEL.0, PANEL.1 + LEGEND), |root| {
            let (legend, panel) = root.split_vertically(LEGEND * SCALE);
            draw_legend(&legend)?;
            self.draw(&panel, title)
        })
    }

    fn draw(&self, panel: &Area<'_>, title: &str) -> Result<(), PlotError> {
        let (upper, lower) = panel.split_vertically(PANEL.1 * SCALE * 64 / 100);
        let end = self.bins.last().map_or(1.0, |bin| bin.to_s);
        let lowest = self.bins.iter().map(|bin| bin.j_th[0]).filter(|&j| j > 0.0);
        let lowest = lowest.fold(1.0, f64::min).max(1e-30);
        let highest = self.bins.iter().map(|bin| bin.j[1].max(bin.j_th[1])).fold(lowest, f64::max);
        let decades = (lowest.log10() - 2.0).floor()..(1.2 * highest).log10();
        let decade = |j: f64| j.log10().max(decades.start);

        let axis = Axis { label: "J", range: decades.clone(), ticks: 5, text: power_of_ten };
        let mut chart = axes(&upper, title, end, &axis, None)?;
        self.shade(&mut chart, &axis)?;
        for piece in self.bins.chunk_by(|a, b| a.piece == b.piece) {
            let j_th = piece.iter().map(|bin| (bin.from_s, decade(bin.j_th[0])));
            chart.draw_series(LineSeries::new(j_th, line(J_TH, 14)))?;
            let j = extremes(piece, |bin| bin.j.map(decade));
            chart.draw_series(LineSeries::new(j, line(J_RMS, 14)))?;
        }

        let fastest = self.bins.iter().map(|bin| bin.v_x[1]).fold(1.0, f64::max);
        let slowest = self.bins.iter().map(|bin| bin.v_x[0]).fold(0.0, f64::min);
        let range = slowest..1.1 * fastest;
        let axis = Axis { label: "v_x [m/s]", range, ticks: 3, text: decimal };
        let mut chart = axes(&lower, "", end, &axis, Some("time [s]"))?;
        self.shade(&mut chart, &axis)?;
        for piece in self.bins.chunk_by(|a, b| a.piece == b.piece) {
            let v_x = extremes(piece, |bin| bin.v_x);
            chart.draw_series(LineSeries::new(v_x, line(FAULT, 14)))?;
        }
        Ok(())
    }

    /// Fills what is not monitored, and the alarms.
    fn shade(&self, chart: &mut Chart<'_, '_>, axis: &Axis) -> Result<(), PlotError> {
        for (colour, of) in
            [(IDLE, (|bin| !bin.monitored) as fn(&Bin) -> bool), (ALARM, |bin| bin.alarm)]
        {
            let same = |a: &Bin, b: &Bin| of(a) == of(b) && a.piece == b.piece;
            let boxes = self.bins.chunk_by(same).filter_map(|bins| {
                let (first, last) = (bins.first()?, bins.last()?);
                let corners = [(first.from_s, axis.range.start), (last.to_s, axis.range.end)];
                of(first).then(|| Rectangle::new(corners, colour.filled()))
            });
            chart.draw_series(boxes)?;
        }
        Ok(())
    }
}

/// Smallest and largest of each bin, one after the other.
fn extremes(piece: &[Bin], of: impl Fn(&Bin) -> [f64; 2]) -> Vec<(f64, f64)> {
    let both = piece.iter().flat_map(|bin| of(bin).map(|value| (bin.from_s, value)));
    let mut points: Vec<_> = both.collect();
    points.dedup();
    points
}

fn draw_legend(area: &Area<'_>) -> Result<(), PlotError> {
    let pixel = |x: u32, y: u32| ((x * SCALE) as i32, (y * SCALE) as i32);
    for (x, colour, text) in
        [(70, J_RMS, "J_rms"), (180, J_TH, "threshold J_th"), (340, FAULT, "speed")]
    {
        let stroke = vec![pixel(x, 20), pixel(x + 28, 20)];
        area.draw(&PathElement::new(stroke, line(colour, 18)))?;
        area.draw(&Text::new(text, pixel(x + 34, 13), font(13)))?;
    }
    for (x, colour, text) in [(450, ALARM, "alarm"), (550, IDLE, "not monitored")] {
        area.draw(&Rectangle::new([pixel(x, 13), pixel(x + 28, 27)], colour.filled()))?;
        area.draw(&Text::new(text, pixel(x + 34, 13), font(13)))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_extremes_times_and_gaps() {
        let mut thinned = Thinned::new(0.01);
        for k in 0..100_000_u32 {
            let time = f64::from(k) * 0.01;
            let j_rms = if k == 77_777 { 9.0 } else { 1.0 };
            let piece = u64::from(k >= 50_001);
            thinned.add(&TraceRow { time, piece, j_rms, j_th: 2.0, ..TraceRow::default() });
        }
        let bins = &thinned.bins;
        assert!((BINS / 2..=BINS).contains(&bins.len()), "{}", bins.len());
        assert!(bins.windows(2).all(|pair| (pair[0].to_s - pair[1].from_s).abs() < 1e-9));
        assert_eq!(bins.last().unwrap().to_s, 1000.0);
        let peak = bins.iter().find(|bin| bin.j[1] == 9.0).unwrap();
        assert!(peak.from_s <= 777.77 && 777.77 < peak.to_s);
        assert_eq!(bins.chunk_by(|a, b| a.piece == b.piece).count(), 2);
        assert!(thinned.svg("a drive").unwrap().starts_with("<svg"));
    }
}
