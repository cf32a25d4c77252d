//! The detector is what it was, bit for bit; and a difference would be seen.

#![allow(clippy::unwrap_used)]

use std::path::Path;

use steerguard_detector::{Monitor, Output};
use steerguard_replay::{Difference, Table, Trace};

const RECORDED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/recorded");

fn traces() -> Vec<Trace> {
    Trace::all(Path::new(RECORDED)).unwrap()
}

fn outputs(trace: &Trace) -> Vec<Output> {
    trace.run().unwrap()
}

#[test]
fn every_output_of_every_sample_is_as_stored() {
    let traces = traces();
    let configurations = ["compact", "default", "every_deviation", "paper", "second", "van"];
    for (trace, expected) in traces.iter().step_by(2).zip(configurations) {
        assert_eq!(trace.configuration_name, expected);
    }
    assert_eq!(traces.len(), 2 * configurations.len());

    let mut report = Vec::new();
    for trace in &traces {
        let differences = trace.differences(&Table::of(&outputs(trace))).unwrap();
        if !differences.found.is_empty() {
            report.push(differences.to_string());
        }
    }
    assert!(
        report.is_empty(),
        "the detector's outputs have changed:\n{}\nIf that is meant: cargo run --release -p \
         steerguard-replay -- --renew, in a commit of its own",
        report.join("\n")
    );
}

/// What no trace shows, no trace holds.
#[test]
fn the_drives_of_each_configuration_show_every_condition() {
    for drives in traces().chunks(2) {
        let of = drives.iter().flat_map(outputs).collect::<Vec<_>>();
        let name = &drives[0].configuration_name;
        for monitor in [Monitor::Monitoring, Monitor::OutOfRange, Monitor::InvalidInput] {
            let count = of.iter().filter(|output| output.monitor == monitor).count();
            assert!(count >= 20, "{name}: {count} samples of {monitor:?}");
        }
        let changes = of.windows(2).filter(|two| two[0].alarm != two[1].alarm).count();
        assert!(changes >= 2, "{name}: the alarm comes and goes");
        let estimate_left = of.iter().any(|output| {
            output.monitor == Monitor::OutOfRange
                && !drives[0].configuration.model.range.v_y.contains(output.v_y_hat)
        });
        assert!(estimate_left, "{name}: the estimate leaves its range");
    }
}

#[test]
fn one_bit_is_seen_and_told_by_variable_and_sample() {
    let trace = &traces()[0];
    let mut outputs = outputs(trace);
    for k in [700, 701] {
        outputs[k].j_th = outputs[k].j_th.next_up();
    }
    outputs[3].residual.v_x_m_per_s = -0.0;
    outputs[9].first_alarm = Some(7);
    let differences = trace.differences(&Table::of(&outputs)).unwrap();
    let found: Vec<_> = differences
        .found
        .iter()
        .map(|difference| match difference {
            Difference::Variable { name, sample, count, .. } => (name.as_str(), *sample, *count),
            Difference::Shape { .. } => unreachable!("same shape"),
        })
        .collect();
    assert_eq!(
        found,
        [("residual_v_x_m_per_s", 3, 1), ("j_th", 700, 2), ("first_alarm", 9, 1)],
        "{differences}"
    );
    let text = differences.to_string();
    for part in [
        "compact/edges",
        "j_th: 2 of 3200",
        "first 700",
        "largest relative difference 2.1e-16, at 700",
    ] {
        assert!(text.contains(part), "no `{part}` in: {text}");
    }
}

#[test]
fn a_row_too_few_is_seen() {
    let trace = &traces()[0];
    let outputs = outputs(trace);
    let differences = trace.differences(&Table::of(&outputs[1..])).unwrap();
    assert!(matches!(differences.found.as_slice(), [Difference::Shape { .. }]));
}

/// A field that the detector gains is missing from what is stored.
#[test]
fn stored_configurations_are_whole_and_exact() {
    for trace in traces() {
        let file = Path::new(RECORDED).join(&trace.configuration_name).join("configuration.json");
        let stored = std::fs::read_to_string(file).unwrap();
        let written = serde_json::to_string_pretty(&trace.configuration).unwrap();
        assert_eq!(stored.trim_end(), written, "{}", trace.configuration_name);
    }
}
