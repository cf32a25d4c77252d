//! What a design sees, for people.

use steerguard_designer::sight::{CourseSight, FaultSight, HiddenBy, Sight};

/// What the table is about.
pub const HEADING: &str =
    "faults that begin during the drive: s until the alarm that stays, in simulation";

/// A head, then a row a course: speed, lateral acceleration, the size from which on faults are seen, and
/// what becomes of a fault of each size.
pub fn rows(sight: &Sight) -> Vec<Vec<String>> {
    let sizes = sight.courses.first().map_or(&[][..], |course| &course.faults);
    let head = ["v_x m/s", "a_y m/s^2", "seen from deg"].map(String::from).into_iter();
    let head = head.chain(sizes.iter().map(|fault| format!("{} deg", fault.fault_deg)));
    let row = |course: &CourseSight| {
        let CourseSight { v_x_m_per_s, lateral_acceleration_m_per_s2, .. } = course;
        // Rounded up: what is said to be seen is.
        let from = course.seen_from_deg.map(|deg| (100.0 * deg).ceil() / 100.0);
        let from = from.map_or("-".into(), |deg| format!("{deg:.2}"));
        let speed = [v_x_m_per_s, lateral_acceleration_m_per_s2].map(|x| format!("{x:.1}"));
        speed.into_iter().chain([from]).chain(course.faults.iter().map(cell)).collect()
    };
    std::iter::once(head.collect()).chain(sight.courses.iter().map(row)).collect()
}

fn cell(fault: &FaultSight) -> String {
    match (fault.seen, fault.false_alarm, fault.delay_s) {
        (true, false, Some(delay_s)) => format!("{delay_s:.2}"),
        (_, true, _) => "false alarm".into(),
        (false, _, Some(_)) => "lost".into(),
        _ => "missed".into(),
    }
}

/// What the table comes to, a sentence each.
pub fn remarks(sight: &Sight) -> Vec<String> {
    let smallest_deg = smallest_deg(sight);
    let mut remarks = vec![match sight.told_from_deg(smallest_deg) {
        None => format!(
            "Straight and steady, bank and wind within their bounds look like a fault of {:.2} deg (F) at \
             most, and between two vehicles twice that.",
            sight.bank_and_wind_deg
        ),
        Some(told_deg) => format!(
            "Straight and steady, bank and wind within their bounds look like a fault of {:.2} deg (F). \
             Between two vehicles it counts twice: no method can tell a lasting fault of less than \
             {told_deg:.2} deg from them, which is more than the smallest of interest, {smallest_deg} deg. \
             What is seen of less is seen as it begins.",
            sight.bank_and_wind_deg
        ),
    }];
    remarks.extend(blindness(sight).map(|why| format!("BLIND: {why}")));
    remarks
}

/// Why the design is blind, if it is.
pub fn blindness(sight: &Sight) -> Option<String> {
    let blind = sight.blind.as_ref()?;
    let seen = match blind.seen_from_deg {
        Some(deg) => format!("Faults are seen there from {deg:.2} deg."),
        None => "No size of fault is seen there at every speed.".into(),
    };
    let hidden = match &blind.hidden_by {
        Some(hidden) => hides(hidden),
        None => {
            " It is not the threshold that hides it: the detector does not monitor all the time, \
                     or an alarm stands before the fault."
                .into()
        }
    };
    Some(format!(
        "a fault of {} deg that begins straight ahead is missed. {seen}{hidden}",
        smallest_deg(sight)
    ))
}

/// The smallest fault of interest.
fn smallest_deg(sight: &Sight) -> f64 {
    let smallest = sight.courses.first().and_then(|course| course.faults.first());
    smallest.map_or(0.0, |fault| fault.fault_deg)
}

/// What hides the fault, and what to do.
fn hides(hidden: &HiddenBy) -> String {
    let HiddenBy { key, value, seen_at } = hidden;
    let numbers = |values: &[f64]| match values {
        [value] => value.to_string(),
        values => format!("{values:?}"),
    };
    let remedy = match seen_at {
        Some(values) => format!("with {} it would be seen", numbers(values)),
        None => "and it would be missed even with 0".into(),
    };
    format!(" What hides it most is {key} = {}: {remedy}.", numbers(value))
}
