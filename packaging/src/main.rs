//! The `steerguard` command.

fn main() {}
