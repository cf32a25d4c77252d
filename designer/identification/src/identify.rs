//! From pieces of drives to estimates, and to what they do not show.

use steerguard_drives::Piece;

use crate::course::{Course, Limits};
use crate::drives::Drives;
use crate::error::{IdentificationError, RATIOS, SHORTEST_S};
use crate::fit::{self, Fit, STARTS};
use crate::identified::{Estimate, Identified, Lateral, Origin, Refused, Told, Trace};
use crate::misfit::misfits;
use crate::model::{Chassis, shown};
use crate::parameter::{Parameter, Parameter::*, Values};

/// Calls of `advance` that [`identify`] makes at most.
pub const STEPS: u64 = 2 * STARTS;

/// Height of a passenger car's centre of gravity, m: `vehicle.centre_of_gravity_height_m`.
const HEIGHT_M: f64 = 0.55;
/// Largest standard error of a height that is taken from the drive, m.
const HEIGHT_ERROR_M: f64 = 0.1;
/// Largest standard error of a lag that is told apart from a delay, s.
const LAG_ERROR_S: f64 = 0.01;
/// Correlation of steering and yaw rate from which on an axis is turned.
const TURNED: f64 = -0.5;
/// How far a ratio may be from the one that is told, as a factor, before units are doubted.
const RATIO_FACTOR: f64 = 5.0;
/// By how much the steering may seem late, s.
const LATE_S: f64 = 0.005;
/// What is left over of the lateral acceleration, over what noise leaves, up to which it is explained; and
/// what counts as nothing, m/s^2.
const EXPLAINED: (f64, f64) = (1.25, 0.01);
/// By how much an explained one may be late or early, s: its phase is what shows the yaw inertia.
const IN_TIME_S: f64 = 0.005;
/// Largest standard error of a ratio that stands without the stiffnesses: slow driving shows it.
const SURE_RATIO: f64 = 0.02;
/// Correlation from which on offset and bias are a pair.
const PAIR: f64 = 0.95;
/// A guessed yaw inertia may be off by as much either way.
const GUESSED_INERTIA: f64 = 0.5;

/// Identifies what is not `told` from `pieces`, which count together; calls `advance` at most
/// [`STEPS`] times.
///
/// # Errors
/// [`IdentificationError`]: what is wrong with the drives, or what they do not show.
pub fn identify(
    pieces: &[Piece],
    told: &Told,
    advance: &(dyn Fn() + Sync),
) -> Result<Identified, IdentificationError> {
    let logged = !pieces.is_empty()
        && pieces
            .iter()
            .flat_map(|piece| &piece.samples)
            .all(|sample| sample.lateral_acceleration_m_per_s2.is_some());
    let inertia_is_told = told.values.contains_key(&YawInertia);
    let mut drives =
        Drives { chassis: &told.chassis, pieces, lateral: logged, guesses_inertia: false };
    check(&drives, told)?;

    let mut lateral = Lateral::NotLogged;
    let mut solved = None;
    if logged {
        let with = solve(&drives, told, advance)?;
        let left_over = with.fit.deviations.lateral_acceleration;
        let noise = drives
            .courses(Limits::LINEAR)
            .iter()
            .map(|course| course.lateral_noise)
            .fold(0.0, f64::max);
        let in_time = with.fit.values[LateralDelay].abs() <= IN_TIME_S;
        if in_time && left_over <= (EXPLAINED.0 * noise).max(EXPLAINED.1) {
            lateral = Lateral::Used { left_over };
            solved = Some(with);
        } else {
            lateral = Lateral::Unexplained { left_over, noise };
        }
    }
    let Solved { fit, height } = match solved {
        Some(solved) => solved,
        None => {
            drives.lateral = false;
            drives.guesses_inertia = !inertia_is_told;
            solve(&drives, told, advance)?
        }
    };
    let delay_s = fit.values[Delay];
    if fit.free.contains(&Delay) && fit.scatter(Delay) < Some(LATE_S) && delay_s < -LATE_S {
        return Err(IdentificationError::LateSteering { late_s: -delay_s });
    }

    let courses = drives.courses(Limits::LINEAR);
    let mut identified = Identified {
        estimates: estimates(&drives, told, &fit, height.as_ref()),
        correlations: correlations(&fit),
        yaw_rate_left_over: fit.deviations.yaw_rate,
        lateral_acceleration: lateral,
        autocorrelation: autocorrelation(&fit, 0.1),
        compared_s: drives.time_s(fit::compared(&courses)),
        driven_s: drives.driven_s(),
        speeds_m_per_s: speeds(&courses),
        traces: courses.iter().map(|course| trace(&told.chassis, &fit.values, course)).collect(),
    };
    let refused = refuse(&mut identified, told);
    if refused.is_empty() {
        Ok(identified)
    } else {
        Err(IdentificationError::NotShown(refused, Box::new(identified)))
    }
}

/// A fit, and one of the height beside it.
struct Solved {
    fit: Fit,
    height: Option<Fit>,
}

/// Refuses drives that no fit can help.
fn check(drives: &Drives, told: &Told) -> Result<(), IdentificationError> {
    let courses = drives.courses(Limits::LINEAR);
    let compared_s = drives.time_s(fit::compared(&courses));
    if compared_s < SHORTEST_S {
        let driven_s = drives.driven_s();
        return Err(IdentificationError::TooShort { compared_s, driven_s });
    }
    let changes = |column: fn(&Course) -> &Vec<f64>| {
        let mut values = courses.iter().flat_map(column);
        let first = values.next();
        values.any(|value| Some(value) != first)
    };
    if !changes(|course| &course.steering) {
        return Err(IdentificationError::NoExcitation("steering angle"));
    }
    if !changes(|course| &course.yaw_rate) {
        return Err(IdentificationError::NoExcitation("yaw rate"));
    }
    let (inverse_ratio, correlation) = fit::against_steering(drives.chassis, &courses);
    if correlation < TURNED {
        return Err(IdentificationError::TurnedAxis { correlation });
    }
    let (low, high, expected) = match told.values.get(&SteeringRatio) {
        Some(told) => (told / RATIO_FACTOR, told * RATIO_FACTOR, format!("{told} is told")),
        None => (
            RATIOS[0] / RATIO_FACTOR,
            RATIOS[1] * RATIO_FACTOR,
            format!("steering systems have {} to {}", RATIOS[0], RATIOS[1]),
        ),
    };
    let ratio = 1.0 / inverse_ratio;
    if correlation > -TURNED && !(low..=high).contains(&ratio) {
        return Err(IdentificationError::ImpossibleRatio { ratio, expected });
    }
    Ok(())
}

/// The value of `parameter` before any drive, in SI: as told, or assumed.
fn beforehand(told: &Told, parameter: Parameter) -> f64 {
    told.values.get(&parameter).copied().unwrap_or(match parameter {
        SteeringRatio => 16.0,
        FrontStiffness | RearStiffness => 60_000.0,
        YawInertia => told.chassis.yaw_inertia_kg_m2(),
        Height => HEIGHT_M,
        SteeringOffset | YawRateBias | Delay | Lag => 0.0,
        LateralBias | LateralScale | LateralDelay => 0.0,
    })
}

/// Fits what is not told.
fn solve(
    drives: &Drives,
    told: &Told,
    advance: &(dyn Fn() + Sync),
) -> Result<Solved, IdentificationError> {
    let chassis = drives.chassis;
    let values = Values::of(|parameter| beforehand(told, parameter));
    let is_free = |parameter: &Parameter| {
        let may_be = match parameter {
            // Its part in the delay is small: only where a fit with it tells the two apart.
            Lag => false,
            // Its part is small but while braking: where the rest is known.
            Height => false,
            YawInertia | LateralBias | LateralScale | LateralDelay => drives.lateral,
            _ => true,
        };
        may_be && !told.values.contains_key(parameter)
    };
    let free: Vec<Parameter> = Parameter::ALL.into_iter().filter(is_free).collect();
    let courses = drives.courses(Limits::LINEAR);
    let fit = fit::from_starts(chassis, &courses, &free, &values, advance);
    let mut fit = fit.ok_or(IdentificationError::NoFit)?;
    if !told.values.contains_key(&Lag)
        && free.contains(&Delay)
        && let Some(with_lag) = with_lag(chassis, &courses, &fit)
    {
        fit = with_lag;
    }
    let mut height = None;
    if drives.lateral && !told.values.contains_key(&Height) {
        height = of_braking(drives, &fit);
    }
    if let Some(height) = &height {
        fit.values[Height] = height.values[Height];
        fit = fit::refine(chassis, &courses, &fit.free, &fit.values).unwrap_or(fit);
    }
    Ok(Solved { fit, height })
}

/// The fit with a lag beside the delay, if the drives tell the two apart.
fn with_lag(chassis: &Chassis, courses: &[Course], fitted: &Fit) -> Option<Fit> {
    let free = [&fitted.free[..], &[Lag]].concat();
    let mut values = fitted.values;
    let lag_s = 0.02;
    values[Lag] = lag_s;
    values[Delay] -= lag_s;
    let fit = fit::refine(chassis, courses, &free, &values)?;
    let error_s = fit.scatter(Lag)?;
    let apart = error_s <= LAG_ERROR_S && fit.values[Lag] > 2.0 * error_s;
    (apart && fit.values[Delay] > -LATE_S).then_some(fit)
}

/// The height of the centre of gravity by what braking does to the tyres, if the drives show one that a
/// car may have.
fn of_braking(drives: &Drives, fitted: &Fit) -> Option<Fit> {
    let courses = drives.courses(Limits::BRAKING);
    let fit = fit::refine(drives.chassis, &courses, &[Height], &fitted.values)?;
    let shown = fit.standard_error(Height)? <= HEIGHT_ERROR_M;
    (shown && (0.2..=1.5).contains(&fit.values[Height])).then_some(fit)
}

/// All parameters that matter.
fn estimates(drives: &Drives, told: &Told, fit: &Fit, height: Option<&Fit>) -> Vec<Estimate> {
    let misfits = misfits(drives, fit);
    let of_lateral = |parameter| matches!(parameter, LateralBias | LateralScale | LateralDelay);
    Parameter::ALL
        .into_iter()
        .filter(|&parameter| drives.lateral || !of_lateral(parameter))
        .map(|parameter| {
            let error = match (parameter, height) {
                (Height, Some(height)) => height.standard_error(Height),
                _ => fit.standard_error(parameter),
            };
            let origin = match error {
                Some(_) => Origin::Identified,
                None if told.values.contains_key(&parameter) => Origin::Told,
                None => Origin::Assumed,
            };
            let guessed = parameter == YawInertia && drives.guesses_inertia;
            let misfit = misfits.get(&parameter).copied().unwrap_or(0.0);
            Estimate {
                parameter,
                value: match origin {
                    Origin::Identified => fit.values.value(parameter),
                    _ => beforehand(told, parameter),
                },
                origin,
                standard_error: error.unwrap_or(0.0),
                misfit: if guessed { GUESSED_INERTIA } else { misfit },
            }
        })
        .collect()
}

/// What is not shown: by itself; a ratio that is not sure, with the stiffnesses that its error goes with;
/// and offset and bias together, where they go with each other. Where ratio and stiffnesses are told, these
/// two may stand as the pair that they are.
fn refuse(identified: &mut Identified, told: &Told) -> Vec<Refused> {
    let error_of =
        |of: Parameter| identified.estimate(of).map_or(0.0, |found| found.standard_error);
    let is_shown = |of: Parameter| of.largest_error().is_none_or(|largest| error_of(of) <= largest);
    let stiffnesses_are_shown = [FrontStiffness, RearStiffness].into_iter().all(is_shown);
    let goes_together = !stiffnesses_are_shown
        || identified.correlations.iter().any(|&(of, with, correlation)| {
            (of, with) == (SteeringOffset, YawRateBias) && correlation.abs() > PAIR
        });
    let pair_is_shown = [SteeringOffset, YawRateBias].into_iter().all(is_shown);
    let refused: Vec<Refused> = identified
        .estimates
        .iter()
        .filter(|estimate| estimate.origin == Origin::Identified)
        .filter(|estimate| match estimate.parameter {
            SteeringRatio if !stiffnesses_are_shown => estimate.standard_error > SURE_RATIO,
            SteeringOffset | YawRateBias if goes_together => !pair_is_shown,
            other => !is_shown(other),
        })
        .map(|&Estimate { parameter, standard_error, .. }| Refused { parameter, standard_error })
        .collect();

    let rest_is_told = [SteeringRatio, FrontStiffness, RearStiffness]
        .iter()
        .all(|parameter| told.values.contains_key(parameter));
    let (pair, refused): (Vec<Refused>, Vec<Refused>) = refused.into_iter().partition(|refused| {
        rest_is_told && matches!(refused.parameter, SteeringOffset | YawRateBias)
    });
    for estimate in &mut identified.estimates {
        if pair.iter().any(|of| of.parameter == estimate.parameter) {
            estimate.origin = Origin::Pair;
        }
    }
    refused
}

fn correlations(fitted: &Fit) -> Vec<(Parameter, Parameter, f64)> {
    let mut all = Vec::new();
    for (k, &of) in fitted.free.iter().enumerate() {
        for &with in &fitted.free[k + 1..] {
            if let Some(correlation) = fitted.correlation(of, with) {
                all.push((of, with, correlation));
            }
        }
    }
    all
}

/// Autocorrelation of what is left of the yaw rate, `lag_s` later.
fn autocorrelation(fitted: &Fit, lag_s: f64) -> f64 {
    let left: Vec<(f64, f64)> = fitted
        .rows
        .iter()
        .zip(&fitted.left_over)
        .filter(|(row, _)| !row.lateral)
        .map(|(row, &left)| (row.time_s, left))
        .collect();
    let (mut product, mut square) = (0.0, 0.0);
    let mut ahead = 0;
    for &(time_s, value) in &left {
        while ahead < left.len() && left[ahead].0 < time_s + lag_s - 1e-6 {
            ahead += 1;
        }
        if let Some(&(at_s, later)) = left.get(ahead)
            && (at_s - time_s - lag_s).abs() < 1e-3
        {
            product += value * later;
            square += 0.5 * (value * value + later * later);
        }
    }
    if square > 0.0 { product / square } else { 0.0 }
}

fn speeds(courses: &[Course]) -> [f64; 2] {
    let speeds = courses.iter().flat_map(|course| {
        course
            .speed
            .iter()
            .zip(&course.compared)
            .filter(|(_, compared)| **compared)
            .map(|(v, _)| *v)
    });
    speeds.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
}

fn trace(chassis: &Chassis, values: &Values, course: &Course) -> Trace {
    let fitted = shown(chassis, values, course).into_iter().map(|shown| shown.yaw_rate).collect();
    Trace {
        start_s: course.start_s,
        period_s: course.period_s,
        yaw_rate: course.yaw_rate.clone(),
        fitted,
        compared: course.compared.clone(),
    }
}
