//! What acts on the error: the faults, and disturbances with bounded sensor noise by their bands.

use crate::band::{Band, pi};
use crate::exact::{Matrix, Rational, exact, whole};
use crate::read::{Design, Disturbance, Fault};
use crate::refusal::Refusal;

/// Names of the sensors in y.
const SENSORS: [&str; 2] = ["v_x", "r"];

/// Inputs of the error that are certified together.
#[derive(Clone)]
pub struct Channel {
    /// What they are, with their bounds.
    pub names: Vec<String>,
    /// Columns of D or F.
    pub direction: Matrix,
    /// Columns of D_y, which follow those of D.
    pub noise: Matrix,
    /// Their frequency range.
    pub band: Band,
}

impl Channel {
    fn empty(band: Band) -> Self {
        let [direction, noise] = [3, 2].map(|rows| Matrix::zeros(rows, 0));
        Self { names: Vec::new(), direction, noise, band }
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.direction.width() + self.noise.width()
    }

    /// All inputs of `channels`: the directions of every one, then their noise; at all frequencies.
    pub fn stacked(channels: &[Self]) -> Self {
        let mut all = Self::empty(Band::Full);
        for channel in channels {
            all.names.extend_from_slice(&channel.names);
            all.direction = all.direction.beside(&channel.direction);
            all.noise = all.noise.beside(&channel.noise);
        }
        all
    }
}

/// The inputs as the figures count them.
pub struct Channels {
    /// The fault that beta is about, per rad or N m.
    pub fault: Channel,
    /// Disturbances and bounded noise, a block for each band in the order in which bands occur;
    /// each column in proportion to its bound, per unit of the first disturbance.
    pub disturbances: Vec<Channel>,
    /// At most the smallest fault of interest, rad or N m.
    pub smallest_fault: Rational,
    /// Bound of the first disturbance.
    pub bound: Rational,
}

impl Channels {
    /// From the specification inside the file.
    pub fn new(design: &Design) -> Result<Self, Refusal> {
        let d = design.d()?;
        let period = design.detector.model.sampling_period_s;
        let (smallest, unit) = match design.spec.fault[0] {
            Fault::Steering { smallest_deg, .. } => {
                let [pi, _] = pi();
                (smallest_deg, pi / whole(180))
            }
            Fault::Torque { smallest_n_m, .. } => (smallest_n_m, whole(1)),
        };

        let mut disturbances = Vec::new();
        let first = positive("spec.disturbance[0]: bound", design.spec.disturbance[0].bound())?;
        for (index, disturbance) in design.spec.disturbance.iter().enumerate() {
            let key = format!("spec.disturbance[{index}]: bound");
            let relative = positive(&key, disturbance.bound())? / &first;
            let band = Band::new(disturbance.band_hz(), period)?;
            let block = of_band(&mut disturbances, band);
            block.direction = block.direction.beside(&d.column(index).times(&relative));
            block.names.push(format!("{} ({})", disturbance.name(), disturbance.bound()));
        }
        for (signal, bound, band_hz) in design.spec.noise.bounded() {
            let sensor = SENSORS[signal];
            let relative = positive(&format!("spec.noise.{sensor}: bound"), bound)? / &first;
            let band = band_hz.map_or(Ok(Band::Full), |band_hz| Band::new(band_hz, period))?;
            let block = of_band(&mut disturbances, band);
            block.noise = block.noise.beside(&unit_column(signal).times(&relative));
            block.names.push(format!("noise of {sensor} ({bound})"));
        }
        Ok(Self {
            fault: Self::fault(design, 0)?,
            disturbances,
            smallest_fault: positive("spec.fault[0]: smallest", smallest)? * unit,
            bound: first,
        })
    }

    /// A fault by itself, per rad or N m.
    pub fn fault(design: &Design, index: usize) -> Result<Channel, Refusal> {
        let period = design.detector.model.sampling_period_s;
        let band = Band::new(design.spec.fault[index].band_hz(), period)?;
        Ok(Channel { direction: design.f()?.column(index), ..Channel::empty(band) })
    }
}

/// Every disturbance, then every bounded noise, by itself and in units of its bound.
///
/// # Errors
/// [`Refusal`]: a bound that is not positive, or noise without one.
pub fn bounded_inputs(design: &Design) -> Result<Vec<BoundedInput>, Refusal> {
    let noise = &design.spec.noise;
    for (sensor, white_std, bound) in [
        (SENSORS[0], noise.v_x.white_std_m_per_s, noise.v_x.bound_m_per_s),
        (SENSORS[1], noise.r.white_std_rad_per_s, noise.r.bound_rad_per_s),
    ] {
        if white_std != 0.0 && bound.is_none() {
            return Err(Refusal::UnboundedNoise { sensor });
        }
    }
    let d = design.d()?;
    let mut inputs = Vec::new();
    for (index, disturbance) in design.spec.disturbance.iter().enumerate() {
        let bound = disturbance.bound();
        let exact = positive(&format!("spec.disturbance[{index}]: bound"), bound)?;
        let mut channel = Channel::empty(Band::Full);
        channel.direction = d.column(index).times(&exact);
        inputs.push(BoundedInput { name: disturbance.name().into(), bound, channel });
    }
    for (signal, bound, _) in noise.bounded() {
        let sensor = SENSORS[signal];
        let exact = positive(&format!("spec.noise.{sensor}: bound"), bound)?;
        let mut channel = Channel::empty(Band::Full);
        channel.noise = unit_column(signal).times(&exact);
        inputs.push(BoundedInput { name: format!("noise of {sensor}"), bound, channel });
    }
    Ok(inputs)
}

/// An input by itself.
pub struct BoundedInput {
    /// Its name.
    pub name: String,
    /// Its bound, in its unit.
    pub bound: f64,
    /// Its column, in units of the bound.
    pub channel: Channel,
}

/// D_y, 2 x n_y, as the specification gives it.
pub fn d_y(design: &Design) -> Matrix {
    let signals = design.spec.noise.bounded();
    signals.fold(Matrix::zeros(2, 0), |d_y, (signal, ..)| d_y.beside(&unit_column(signal)))
}

fn unit_column(signal: usize) -> Matrix {
    Matrix::identity(2).column(signal)
}

/// The block of `band`, a new one if there is none.
fn of_band(blocks: &mut Vec<Channel>, band: Band) -> &mut Channel {
    let index = blocks.iter().position(|block| block.band == band).unwrap_or_else(|| {
        blocks.push(Channel::empty(band));
        blocks.len() - 1
    });
    &mut blocks[index]
}

/// The exact value of a positive number.
///
/// # Errors
/// [`Refusal::NotPositive`].
pub fn positive(key: &str, value: f64) -> Result<Rational, Refusal> {
    match value > 0.0 {
        true => Ok(exact(value)),
        false => Err(Refusal::NotPositive { key: key.into(), value }),
    }
}

impl Fault {
    /// Frequency range.
    pub fn band_hz(&self) -> [f64; 2] {
        match *self {
            Self::Steering { band_hz, .. } | Self::Torque { band_hz, .. } => band_hz,
        }
    }

    /// Column of B.
    pub fn column(&self) -> usize {
        match self {
            Self::Torque { .. } => 0,
            Self::Steering { .. } => 1,
        }
    }
}

impl Disturbance {
    /// Name in reports.
    pub fn name(&self) -> &str {
        match self {
            Self::SideWind { name, .. }
            | Self::Bank { name, .. }
            | Self::YawMoment { name, .. }
            | Self::Direction { name, .. } => name,
        }
    }

    /// Largest magnitude, in its unit.
    pub fn bound(&self) -> f64 {
        match *self {
            Self::SideWind { bound_m_per_s2: bound, .. }
            | Self::Bank { bound_deg: bound, .. }
            | Self::YawMoment { bound_n_m: bound, .. }
            | Self::Direction { bound, .. } => bound,
        }
    }

    fn band_hz(&self) -> [f64; 2] {
        match *self {
            Self::SideWind { band_hz, .. }
            | Self::Bank { band_hz, .. }
            | Self::YawMoment { band_hz, .. }
            | Self::Direction { band_hz, .. } => band_hz,
        }
    }
}

impl crate::read::Noise {
    /// Place in y, bound and band of each bounded noise.
    fn bounded(&self) -> impl Iterator<Item = (usize, f64, Option<[f64; 2]>)> {
        let signals = [
            (0, self.v_x.bound_m_per_s, self.v_x.band_hz),
            (1, self.r.bound_rad_per_s, self.r.band_hz),
        ];
        signals.into_iter().filter_map(|(signal, bound, band_hz)| Some((signal, bound?, band_hz)))
    }
}
