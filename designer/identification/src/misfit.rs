//! What changes where the fit is asked of parts of the drives, or without a guess: what the single-track
//! model is off by, which standard errors cannot say.

use std::collections::BTreeMap;

use crate::course::{Course, Limits};
use crate::drives::Drives;
use crate::fit::{self, Fit};
use crate::parameter::{Parameter, Parameter::*};

/// By how much yaw inertias of cars scatter about M l_f l_r: the stiffnesses follow a guess of it.
const INERTIA_SCATTERS: f64 = 0.1;

/// Largest standard error, without the guess, that says something of it.
const SHOWN: f64 = 0.1;

/// Largest change of the logarithm of the yaw inertia without the guess.
const LARGEST_CHANGE: f64 = 0.7;

/// By how much each fitted parameter changes, beyond what its standard errors allow, where only slow
/// cornering, the first or the second half is asked, or the yaw inertia not guessed.
pub(crate) fn misfits(drives: &Drives, fitted: &Fit) -> BTreeMap<Parameter, f64> {
    let mut most = BTreeMap::new();
    let mut widen = |of_part: &Fit, shown: &Fit, largest_error: fn(Parameter) -> f64| {
        for &parameter in &fitted.free {
            let errors = [fitted, shown, of_part].map(|fit| fit.scatter(parameter));
            let [Some(error), Some(at_whole), Some(at_part)] = errors else { continue };
            // A part that ends far off may say less there than it did at the values of the whole.
            let of_part_error = at_whole.max(at_part);
            if of_part_error > largest_error(parameter) {
                continue;
            }
            let change = of_part.values[parameter] - fitted.values[parameter];
            let change = parameter.error(fitted.values[parameter], change.abs());
            // Hausman: the variance of the change is the difference of the variances.
            let allowed = (of_part_error.powi(2) - error.powi(2)).max(0.0).sqrt();
            let misfit = (change - 2.0 * allowed.hypot(parameter.model_error())).max(0.0);
            let entry: &mut f64 = most.entry(parameter).or_default();
            *entry = entry.max(misfit);
        }
    };
    let gentle = drives.courses(Limits::GENTLE);
    for part in [gentle, half(drives, false), half(drives, true)] {
        if fit::compared(&part) > 100
            && let Some(shown) = fit::elsewhere(drives.chassis, &part, fitted)
            && let Some(of_part) = fit::refine(drives.chassis, &part, &fitted.free, &fitted.values)
        {
            widen(&of_part, &shown, Parameter::part_error);
        }
    }
    if drives.guesses_inertia {
        let free = [&fitted.free[..], &[YawInertia]].concat();
        let courses = drives.courses(Limits::LINEAR);
        let of_all = fit::refine(drives.chassis, &courses, &free, &fitted.values);
        // An inertia that no car has says nothing.
        let guess = fitted.values[YawInertia];
        if let Some(of_all) =
            of_all.filter(|of| (of.values[YawInertia] - guess).abs() < LARGEST_CHANGE)
        {
            widen(&of_all, &of_all, |_| SHOWN);
        }
        for parameter in
            [FrontStiffness, RearStiffness].iter().filter(|of| fitted.free.contains(of))
        {
            let entry = most.entry(*parameter).or_default();
            *entry = entry.max(INERTIA_SCATTERS);
        }
    }
    most
}

/// The first or the second half of the samples.
fn half(drives: &Drives, second: bool) -> Vec<Course> {
    let mut courses = drives.courses(Limits::LINEAR);
    let all = courses.iter().map(Course::len).sum::<usize>();
    let mut at = 0;
    for course in &mut courses {
        for compared in &mut course.compared {
            *compared &= (at >= all / 2) == second;
            at += 1;
        }
    }
    courses
}
