//! `examples/detector`: what it finds in a recorded drive is what the frozen traces hold.

#![cfg(feature = "serde")]
#![allow(clippy::unwrap_used)]

#[path = "../../examples/detector/alarm.rs"]
mod alarm;

#[test]
fn it_raises_the_alarms_of_the_frozen_trace() {
    let configuration = include_str!("../../tests/replay/recorded/default/configuration.json");
    let design = format!("{{\"detector\": {configuration}}}");
    let inputs = include_str!("../../tests/replay/recorded/default/fault.inputs.csv");
    let outputs = include_str!("../../tests/replay/recorded/default/fault.outputs.csv");
    let column = outputs.lines().next().unwrap().split(',').position(|of| of == "alarm").unwrap();
    let stands: Vec<bool> =
        outputs.lines().skip(1).map(|row| row.split(',').nth(column) == Some("true")).collect();
    let raised: Vec<usize> =
        (0..stands.len()).filter(|&k| stands[k] && (k == 0 || !stands[k - 1])).collect();
    assert!(!raised.is_empty());
    assert_eq!(alarm::alarms(&design, inputs).unwrap(), raised);
    assert!(alarm::alarms(&design, "a,b\n1,2\n").unwrap_err().to_string().contains("line 2: 2"));
}
