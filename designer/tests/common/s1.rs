//! S1 of METHOD.md 7.

/// Its fault and disturbances.
pub const S1: &str = r#"
    [[fault]]
    channel = "steering"
    smallest_deg = 1.0
    [[disturbance]]
    kind = "direction"
    name = "lateral"
    direction = [0.0, 1.0, 0.0]
    bound = 0.5
    [[disturbance]]
    kind = "direction"
    name = "yaw"
    direction = [0.0, 0.0, 1.0]
    bound = 0.1
"#;
