//! How much likelier the innovations are with a fault from some sample on: generalised likelihood ratio
//! over onsets (method 9).
//!
//! # Conventions
//! - A hypothesis: since its onset the road wheel has been off by a constant angle f. That shifts the
//!   filter's innovations by `f s`, `s = H eps`, with `eps+ = Phi (I - K H) eps + B_f`.
//!   Willsky and Jones, IEEE Trans. Automatic Control 21 (1976).
//! - With innovations nu of covariance S, `a = sum s' S^-1 nu` and `c = sum s' S^-1 s`: the fault that
//!   explains most is `a / c`, of standard deviation `c^-1/2`; the statistic is `|a / c|` over `c^-1/2 + o`,
//!   o a share of what bank and gust at their bounds look like, which no time makes less.
//! - An estimate errs by less than a factor times `c^-1/2 + o` where that statistic stays below the factor
//!   without a fault, as what disturbs it is the same with a fault and without; and by what tyres that slide
//!   make less of the fault itself. It is that of the likeliest onset of all.
//! - What speaks for the steering may be a step of a sensor, which shifts the innovations by `s = d + H eps`,
//!   `eps+ = Phi (eps - K s)`. What explains more has the larger `a^2 / c`, twice the logarithm of its likelihood
//!   over that of no fault, and is named where the others explain clearly less. Threshold and estimate are those of
//!   the steering alone.
//! - A fault that is found is taken into the filter once it is [`SETTLED_S`] old, or has been clear for [`CLEAR_S`]:
//!   the filter goes on as if it had always known, and further steps are found on top.

use crate::algebra::{all_finite, magnitude};
use crate::axles::deficit;
use crate::filter::{Correction, STATES, Transition};
use crate::{Estimator, Filter, Gust, RELEASE, TsModel, Uncertainty};

/// Onsets that are looked at, at most: those up to [`OLDEST_S`], two thirds of [`SPACING_S`] apart or more; and, to
/// tell a fault of the steering from one of a sensor, those of the last [`YOUNG`] samples and what explains most.
pub const HYPOTHESES: usize = 7 + YOUNG as usize + EXPLANATIONS;
/// Explanations of a fault: the steering, the yaw-rate sensor, the speed sensor.
pub const EXPLANATIONS: usize = 3;

/// Onsets are looked at this far apart, s, or as many samples as come nearest to that.
const SPACING_S: f64 = 0.05;
/// Age up to which an onset is looked at, s: what lasts longer road and vehicle may explain.
const OLDEST_S: f64 = 0.2;
/// Samples at each of which an onset is looked at.
const YOUNG: u64 = 20;
/// Time that a fault that was taken in speaks for an alarm, s.
const KNOWN_FOR_S: f64 = 10.0;
/// Share of what bank and gust at their bounds look like that the statistic allows for.
const LOOKS: f64 = 0.3;
/// Age of the youngest estimate that is held, s: older ones take bank and parameters for the fault.
const SETTLED_S: f64 = 0.2;
/// A fault is taken in sooner at a statistic of this many thresholds, as what a large one does is not linear for long, ...
const CLEAR: f64 = 3.0;
/// ... for this long, s: the first samples tell little of its size.
const CLEAR_S: f64 = 0.1;
/// Steps of the iteration for the angle behind a force that friction limits.
const STEPS: u32 = 4;
/// No road wheel is off by more, rad: a filter that finds more is lost.
const LARGEST_FAULT_RAD: f64 = 1.6;
/// What is named explains more than any other by this, as `a^2 / c`, ...
const CLEARER: f64 = 12.0;
/// ... and by this share of what it explains: no model is exact.
const CLEARER_BY: f64 = 0.02;
/// A fault is over where less than this share of the largest is left.
const GONE: f64 = 0.2;

/// What a fault is, as far as that can be told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FaultHypothesis {
    /// More than one explanation is left.
    #[default]
    Undecided,
    /// The road wheel is off.
    Steering,
    /// The yaw-rate sensor has stepped.
    YawRateSensor,
    /// The speed sensor's scale has.
    SpeedSensor,
}

/// What a fault of one unit does to the filter, and what speaks for it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Signature {
    /// Error of the filter's state that it makes.
    pub error: [f64; STATES],
    /// a.
    pub correlation: f64,
    /// c, per square of the fault's unit.
    pub information: f64,
}

impl Signature {
    const NONE: Self = Self { error: [0.0; STATES], correlation: 0.0, information: 0.0 };

    /// `a^2 / c`.
    fn explained(&self) -> f64 {
        if self.information > 0.0 {
            self.correlation * self.correlation / self.information
        } else {
            0.0
        }
    }
}

/// An onset, and what speaks for it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hypothesis {
    /// The sample since the start from which on there is a fault; none for no hypothesis.
    pub onset: Option<u64>,
    /// Of 1 rad at the road wheel, of 1 rad/s more yaw rate shown, and of the speed shown twice as large.
    pub signatures: [Signature; EXPLANATIONS],
}

impl Hypothesis {
    const NONE: Self = Self { onset: None, signatures: [Signature::NONE; EXPLANATIONS] };

    const fn steering(&self) -> &Signature {
        &self.signatures[0]
    }
}

/// What is known of the fault.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FaultEstimate {
    /// The road wheel's angle less the commanded one, rad.
    pub fault_rad: f64,
    /// It errs by at most this, rad.
    pub bound_rad: f64,
    /// Index of the sample from which on it acts.
    pub onset: u64,
    /// What it is. Where it is a sensor's, fault and bound are those of the angle that would explain the same.
    pub hypothesis: FaultHypothesis,
}

/// The onsets before the sample to come, and the fault that the filter knows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Onsets {
    /// Samples since the start.
    pub samples: u64,
    /// Onsets.
    pub hypotheses: [Hypothesis; HYPOTHESES],
    /// The fault that the filter knows, rad.
    pub held_rad: f64,
    /// Its variance, rad^2.
    pub held_variance: f64,
    /// The largest that it has been, rad.
    pub largest_rad: f64,
    /// Its onset.
    pub held_onset: u64,
    /// The sample at which it was last taken in.
    pub held_since: u64,
    /// Samples in a row at which the statistic was clear.
    pub clear: u64,
    /// What the fault is that speaks, or that the filter knows.
    pub hypothesis: FaultHypothesis,
    /// Largest statistic at the last sample.
    pub statistic: f64,
    /// What the statistic allowed for at the last sample beside the standard deviation, rad.
    pub looks_rad: f64,
}

impl Onsets {
    /// Before the first sample after a start.
    pub const NONE: Self = Self {
        samples: 0,
        hypotheses: [Hypothesis::NONE; HYPOTHESES],
        held_rad: 0.0,
        held_variance: 0.0,
        largest_rad: 0.0,
        held_onset: 0,
        held_since: 0,
        clear: 0,
        hypothesis: FaultHypothesis::Undecided,
        statistic: 0.0,
        looks_rad: 0.0,
    };

    /// Whether a test can have led here.
    pub(crate) fn is_possible(&self) -> bool {
        let past = |sample: u64| sample <= self.samples;
        self.hypotheses.iter().all(|x| {
            x.onset.is_none_or(past)
                && x.signatures.iter().all(|x| {
                    all_finite(&x.error)
                        && all_finite(&[x.correlation, x.information])
                        && x.information >= 0.0
                })
        }) && all_finite(&[self.held_rad, self.held_variance, self.largest_rad])
            && all_finite(&[self.statistic, self.looks_rad])
            && self.held_variance >= 0.0
            && past(self.held_onset)
            && past(self.held_since)
            && past(self.clear)
    }

    /// Whether the filter knows a fault.
    pub(crate) const fn holds(&self) -> bool {
        self.largest_rad > 0.0
    }

    /// The most that each explanation explains, and since which onset.
    fn most_explained(&self) -> [(f64, u64); EXPLANATIONS] {
        let mut most = [(0.0, 0); EXPLANATIONS];
        for hypothesis in &self.hypotheses {
            let Some(onset) = hypothesis.onset else { continue };
            for (most, signature) in most.iter_mut().zip(&hypothesis.signatures) {
                let explained = signature.explained();
                if explained > most.0 {
                    *most = (explained, onset);
                }
            }
        }
        most
    }

    /// What explains the innovations since some onset clearly better than the others do since any.
    fn explanation(&self) -> FaultHypothesis {
        let [steering, yaw_rate, speed] = self.most_explained().map(|(explained, _)| explained);
        let named = [
            (FaultHypothesis::Steering, steering, yaw_rate.max(speed)),
            (FaultHypothesis::YawRateSensor, yaw_rate, speed.max(steering)),
            (FaultHypothesis::SpeedSensor, speed, steering.max(yaw_rate)),
        ];
        let clear = |(_, most, other): &&(FaultHypothesis, f64, f64)| {
            most - other >= CLEARER.max(CLEARER_BY * most)
        };
        named.iter().find(clear).map_or(FaultHypothesis::Undecided, |(name, ..)| *name)
    }
}

/// The test over onsets: what no sample changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OnsetTest {
    threshold: f64,
    estimate_factor: f64,
    /// Samples between onsets, and age of the oldest.
    spacing: u64,
    oldest: u64,
    /// The age of one that is taken in, and how long that speaks.
    settled: u64,
    known_for: u64,
    /// Samples for which a clear one is looked at first.
    clear: u64,
    /// Front axle force of 1 rad over what friction holds.
    front_over_held: f64,
    /// What the bank at its bound looks like, rad, and a side force, rad/N.
    bank_rad: f64,
    by_force_rad_per_n: f64,
    gust: Gust,
}

impl OnsetTest {
    pub(crate) fn new(model: &TsModel, uncertainty: &Uncertainty, estimator: &Estimator) -> Self {
        let Estimator { threshold, estimate_factor, .. } = *estimator;
        let TsModel { vehicle: v, sampling_period_s: period_s, .. } = *model;
        let gust = uncertainty.gust;
        let (l_f, l_r) = (v.front_axle_distance_m, v.rear_axle_distance_m);
        let axle = |per_tyre: f64| 2.0 * per_tyre * (l_f + l_r);
        // Straight and steady: axle forces that hold a side force acting so far ahead.
        let looks_rad_per_n = |ahead_m: f64| {
            magnitude(
                (l_r + ahead_m) / axle(v.front_cornering_stiffness_n_per_rad)
                    - (l_f - ahead_m) / axle(v.rear_cornering_stiffness_n_per_rad),
            )
        };
        let samples = |time_s: f64| (time_s / period_s) as u64;
        Self {
            threshold,
            estimate_factor,
            spacing: ((SPACING_S / period_s + 0.5) as u64).max(1),
            oldest: samples(OLDEST_S),
            settled: samples(SETTLED_S),
            known_for: samples(KNOWN_FOR_S),
            clear: samples(CLEAR_S).max(1),
            front_over_held: uncertainty
                .held_n(&v)
                .map_or(0.0, |[held, _]| 2.0 * v.front_cornering_stiffness_n_per_rad / held),
            bank_rad: v.mass_kg * looks_rad_per_n(0.0) * uncertainty.bank_m_per_s2,
            by_force_rad_per_n: looks_rad_per_n(gust.acting_ahead_m),
            gust,
        }
    }

    /// The hypothesis with the largest statistic, if one says anything yet, and that: of all that are looked at, or
    /// of those of which the statistic is.
    fn likeliest<'a>(&self, onsets: &'a Onsets, all: bool) -> Option<(&'a Hypothesis, f64)> {
        let mut likeliest = None;
        let mut largest = 0.0;
        for hypothesis in &onsets.hypotheses {
            let Signature { correlation: a, information: c, .. } = *hypothesis.steering();
            let per_statistic = libm::sqrt(c) + onsets.looks_rad * c;
            let counts =
                hypothesis.onset.is_some_and(|onset| all || onset.is_multiple_of(self.spacing));
            if counts && magnitude(a) > largest * per_statistic {
                largest = magnitude(a) / per_statistic;
                likeliest = Some((hypothesis, largest));
            }
        }
        likeliest
    }

    /// The likeliest hypothesis of all, where the statistic speaks for a fault that is not taken in yet.
    fn found<'a>(&self, onsets: &'a Onsets, factor: f64) -> Option<&'a Hypothesis> {
        if !self.exceeds(onsets, factor) {
            return None;
        }
        self.likeliest(onsets, true).map(|(found, _)| found)
    }

    /// The largest statistic over the threshold.
    pub(crate) fn ratio(&self, onsets: &Onsets) -> f64 {
        onsets.statistic / self.threshold
    }

    /// Whether the statistic speaks for a fault that is not taken in yet; `factor` on the threshold.
    fn exceeds(&self, onsets: &Onsets, factor: f64) -> bool {
        onsets.statistic >= factor * self.threshold
    }

    /// Whether something speaks for a fault: the statistic, or that the filter knows one. What is known for
    /// longer than onsets are looked at bank and parameters might explain.
    pub(crate) fn speaks(&self, onsets: &Onsets, factor: f64) -> bool {
        let age = onsets.samples.saturating_sub(onsets.held_since);
        let knows = onsets.holds() && age <= self.known_for;
        knows || self.exceeds(onsets, factor)
    }

    /// Whether nothing does, and by some distance.
    pub(crate) fn is_clear(&self, onsets: &Onsets, factor: f64) -> bool {
        !self.speaks(onsets, factor * RELEASE)
    }

    /// What is known at a sample of the fault where the test has found one.
    pub(crate) fn estimate(
        &self,
        onsets: &Onsets,
        factor: f64,
        sample: u64,
    ) -> Option<FaultEstimate> {
        let (fault_rad, variance, onset) = match self.found(onsets, factor) {
            Some(x) => (
                onsets.held_rad + x.steering().correlation / x.steering().information,
                onsets.held_variance + 1.0 / x.steering().information,
                if onsets.holds() { onsets.held_onset } else { x.onset.unwrap_or_default() },
            ),
            None if onsets.holds() => (onsets.held_rad, onsets.held_variance, onsets.held_onset),
            None => return None,
        };
        let disturbed = self.estimate_factor * (libm::sqrt(variance) + onsets.looks_rad);
        Some(FaultEstimate {
            fault_rad,
            bound_rad: disturbed + self.slid_rad(fault_rad),
            onset: sample.saturating_sub(onsets.samples.saturating_sub(onset)),
            hypothesis: onsets.hypothesis,
        })
    }

    /// By how much a fault may differ from `fault_rad` that it is taken for, rad: what tyres make less of that slide.
    fn slid_rad(&self, fault_rad: f64) -> f64 {
        let found = magnitude(fault_rad);
        let mut angle = found;
        for _ in 0..STEPS {
            let held = 1.0 - deficit(self.front_over_held * angle);
            angle = (found / held).min(LARGEST_FAULT_RAD);
        }
        angle - found
    }

    /// Takes in what a measurement has said. Returns whether a fault that the filter knew is over, or the
    /// filter lost: it starts anew then.
    pub(crate) fn correct(
        &self,
        onsets: &mut Onsets,
        filter: &mut Filter,
        correction: &Correction,
        factor: f64,
    ) -> bool {
        let [of_v_x, of_r] = correction.innovation;
        let directly = [[0.0, 0.0], [0.0, 1.0], [correction.speed(), 0.0]];
        for hypothesis in onsets.hypotheses.iter_mut().filter(|x| x.onset.is_some()) {
            for (signature, shown) in hypothesis.signatures.iter_mut().zip(directly) {
                let [v_x, r] = correction.shown(&signature.error, shown);
                signature.correlation += v_x * of_v_x + r * of_r;
                signature.information += v_x * v_x + r * r;
                correction.correct(&mut signature.error, [-v_x, -r]);
            }
        }
        onsets.looks_rad =
            LOOKS * (self.bank_rad + self.by_force_rad_per_n * self.gust.side_force(filter.x[0]));
        onsets.statistic = self.likeliest(onsets, false).map_or(0.0, |(_, statistic)| statistic);
        // What ends a fault that is known needs less than what begins one.
        let least = if onsets.holds() { factor * RELEASE } else { factor };
        let counts = |x: &Hypothesis| {
            self.exceeds(onsets, factor) || x.steering().correlation * onsets.held_rad < 0.0
        };
        let Some(found) = self.found(onsets, least).copied().filter(counts) else {
            onsets.clear = 0;
            if !onsets.holds() {
                onsets.hypothesis = FaultHypothesis::Undecided;
            }
            return false;
        };
        if !onsets.holds() && onsets.hypothesis == FaultHypothesis::Undecided {
            onsets.hypothesis = onsets.explanation();
        }
        let onset = found.onset;
        let Signature { correlation, information, .. } = *found.steering();
        if magnitude(onsets.held_rad + correlation / information) > LARGEST_FAULT_RAD {
            return true;
        }
        let age = onsets.samples.saturating_sub(onset.unwrap_or_default());
        let is_clear = self.exceeds(onsets, CLEAR * factor);
        onsets.clear = if is_clear { onsets.clear.saturating_add(1) } else { 0 };
        (age >= self.settled || onsets.clear >= self.clear)
            && self.take_in(onsets, filter, &found, factor)
    }

    /// Lets the filter know a fault. Returns whether this ends one that it knew.
    fn take_in(
        &self,
        onsets: &mut Onsets,
        filter: &mut Filter,
        found: &Hypothesis,
        factor: f64,
    ) -> bool {
        let onset = found.onset;
        let Signature { error, correlation, information } = found.steering();
        let step = correlation / information;
        for (x, error) in filter.x.iter_mut().zip(error) {
            *x += step * error;
        }
        for (row, i) in filter.p.iter_mut().zip(error) {
            for (p, j) in row.iter_mut().zip(error) {
                *p += i * j / information;
            }
        }
        let further = onsets.holds();
        if !further {
            onsets.held_onset = onset.unwrap_or_default();
        }
        onsets.held_since = onsets.samples;
        onsets.clear = 0;
        onsets.held_rad += step;
        onsets.held_variance += 1.0 / information;
        let held = magnitude(onsets.held_rad);
        onsets.largest_rad = onsets.largest_rad.max(held);
        onsets.hypotheses = Onsets::NONE.hypotheses;
        let uncertain = libm::sqrt(onsets.held_variance) + onsets.looks_rad;
        let bound = factor * self.threshold * uncertain;
        further && held <= bound.max(GONE * onsets.largest_rad)
    }

    /// Goes on to the next sample.
    pub(crate) fn advance(&self, onsets: &mut Onsets, transition: &Transition) {
        onsets.samples += 1;
        let samples = onsets.samples;
        let most_explained = onsets.most_explained();
        for hypothesis in &mut onsets.hypotheses {
            let Some(onset) = hypothesis.onset else { continue };
            let kept = onset.is_multiple_of(self.spacing)
                || most_explained.iter().any(|(_, most)| *most == onset);
            let oldest = if kept { self.oldest } else { YOUNG.min(self.oldest) };
            if samples.saturating_sub(onset) > oldest {
                hypothesis.onset = None;
                continue;
            }
            for (k, signature) in hypothesis.signatures.iter_mut().enumerate() {
                transition.advance(&mut signature.error, k == 0);
            }
        }
        if let Some(free) = onsets.hypotheses.iter_mut().find(|x| x.onset.is_none()) {
            *free = Hypothesis { onset: Some(samples), ..Hypothesis::NONE };
        }
    }
}
