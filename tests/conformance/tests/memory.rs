//! What the library may call, and that a step calls nothing.
#![allow(clippy::unwrap_used)]

mod common;

use std::collections::BTreeSet;
use std::fs;

use common::Packaged;
use common::drive::inputs;
use common::raw::Raw;
use object::{Object as _, ObjectSymbol as _};
use steerguard_conformance_tests::host;
use steerguard_fmi2::types::fmi2Status;

/// The library can get memory by `calloc` alone, and from the importer's callback.
#[test]
#[cfg(target_os = "linux")]
fn the_library_knows_no_other_allocator_than_calloc() {
    let library = fs::read(Packaged::new().library).unwrap();
    let file = object::File::parse(&*library).unwrap();
    let imports: BTreeSet<&str> = file
        .dynamic_symbols()
        .filter(|symbol| symbol.is_undefined() && !symbol.is_weak())
        .map(|symbol| symbol.name().unwrap())
        .filter(|name| !name.is_empty())
        .collect();
    let known = ["bcmp", "calloc", "free", "memcmp", "memcpy", "memmove", "memset", "strlen"];
    assert!(imports.is_subset(&known.into()), "{imports:?}");
    println!("imports {imports:?}, {} bytes", library.len());
}

/// With the importer's callbacks given, memory comes from them alone, and a step asks for none:
/// whether it runs samples or not, logs, warns, raises an alarm, or is refused.
#[test]
fn a_step_allocates_nothing() {
    let packaged = Packaged::new();
    let (functions, _code) = packaged.load();
    let period_s = packaged.sample_period_s();

    let before = host::counts();
    let raw = Raw::new(&functions, &packaged.guid, "counted");
    let created = host::counts();
    assert_eq!(created.allocations, before.allocations + 1, "one block for an instance");

    let (mut statuses, mut alarms) = (BTreeSet::new(), BTreeSet::new());
    let mut time_s = 0.0;
    for k in 0..6000_u32 {
        let size_s = period_s * [1.0, 0.25, 3.0, 1.5][k as usize % 4];
        raw.set(&inputs(f64::from(k) * period_s));
        statuses.insert(raw.step(time_s, size_s));
        statuses.insert(raw.step(-1.0, size_s));
        time_s += size_s;
        alarms.insert(raw.alarm());
    }
    let stepped = host::counts();
    assert_eq!(
        (stepped.allocations, stepped.frees),
        (created.allocations, created.frees),
        "in 12000 calls of fmi2DoStep"
    );
    use fmi2Status as S;
    assert_eq!(statuses, [S::fmi2OK, S::fmi2Warning, S::fmi2Error].into());
    assert_eq!(alarms, [false, true].into());
    assert!(stepped.messages > created.messages, "events were logged");

    raw.reset();
    let _ = raw.serialised();
    drop(raw);
    let after = host::counts();
    assert_eq!(after.allocations - before.allocations, after.frees - before.frees);
    assert_eq!(after.allocations, created.allocations + 1, "one block for a saved state");
}
