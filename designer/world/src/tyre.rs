//! Tyres: axle forces from slip angles and axle loads.

/// How axle forces grow with slip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tyres {
    /// In proportion, without end.
    Linear,
    /// Up to what friction holds: `mu F_z tanh(F / (mu F_z))`, F the linear tyre's force and F_z the
    /// axle load.
    Saturating {
        /// mu, positive.
        friction: f64,
    },
}

impl Tyres {
    /// Lateral force in N where a linear tyre would give `force_n`, under the axle load `load_n`, not
    /// negative.
    pub fn force_n(self, force_n: f64, load_n: f64) -> f64 {
        match self {
            Self::Linear => force_n,
            Self::Saturating { friction } => {
                let limit = friction * load_n;
                if limit > 0.0 { limit * libm::tanh(force_n / limit) } else { 0.0 }
            }
        }
    }
}
