//! Many instances, many threads, many lives of the library.
#![allow(clippy::unwrap_used)]

mod common;

use std::sync::Barrier;
use std::thread;

use common::Packaged;
use common::drive;
use common::raw::Raw;
use steerguard_conformance_tests::{Functions, host};
use steerguard_fmi2::types::fmi2Status;

const THREADS: u64 = 8;
const INSTANCES: u64 = 64;
const STEPS: u64 = 1000;

/// Inputs that differ from instance to instance.
fn inputs(instance: u64, time_s: f64) -> [f64; 4] {
    let [v_x, r, torque, angle] = drive::inputs(time_s + 0.7 * instance as f64);
    [v_x, r + 1e-3 * instance as f64, torque, angle]
}

fn step(raw: &Raw<'_>, instance: u64, k: u64, period_s: f64) -> [u64; 8] {
    let time_s = k as f64 * period_s;
    raw.set(&inputs(instance, time_s));
    assert!(raw.step(time_s, period_s) <= fmi2Status::fmi2Warning);
    raw.results()
}

#[test]
fn interleaved_instances_do_what_each_does_alone() {
    let packaged = Packaged::new();
    let (functions, _code) = packaged.load();
    let (guid, period_s) = (&*packaged.guid, packaged.sample_period_s());
    let functions = &functions;
    let name = |instance: u64| format!("instance {instance}");

    let alone: Vec<Vec<[u64; 8]>> = (0..INSTANCES)
        .map(|instance| {
            let raw = Raw::new(functions, guid, &name(instance));
            (0..STEPS).map(|k| step(&raw, instance, k, period_s)).collect()
        })
        .collect();
    assert!(alone.windows(2).all(|pair| pair[0] != pair[1]), "each has a course of its own");

    // Every thread steps its instances in turn, all threads at once.
    let start = Barrier::new(THREADS as usize);
    let (alone, start) = (&alone, &start);
    thread::scope(|scope| {
        for thread in 0..THREADS {
            scope.spawn(move || {
                let mine: Vec<(u64, Raw<'_>)> = (0..INSTANCES)
                    .filter(|instance| instance % THREADS == thread)
                    .map(|instance| (instance, Raw::new(functions, guid, &name(instance))))
                    .collect();
                start.wait();
                for k in 0..STEPS {
                    for (instance, raw) in &mine {
                        let expected = alone[*instance as usize][k as usize];
                        assert_eq!(
                            step(raw, *instance, k, period_s),
                            expected,
                            "{instance} at {k}"
                        );
                    }
                }
            });
        }
    });
}

/// The standard lets calls on one instance come from different threads, one after another.
#[test]
fn an_instance_may_go_from_thread_to_thread() {
    struct Send<'a>(Raw<'a>);
    // SAFETY: the instance is used by one thread at a time, as the standard demands.
    unsafe impl std::marker::Send for Send<'_> {}

    let packaged = Packaged::new();
    let (functions, _code) = packaged.load();
    let period_s = packaged.sample_period_s();
    let expected = Raw::new(&functions, &packaged.guid, "alone").drive(0..STEPS, period_s);

    let mut raw = Send(Raw::new(&functions, &packaged.guid, "moved"));
    let mut found = Vec::new();
    for k in (0..STEPS).step_by(10) {
        thread::scope(|scope| {
            let (raw, found) = (&mut raw, &mut found);
            scope.spawn(move || {
                // The whole wrapper moves, not the field alone.
                let raw = raw;
                found.extend(raw.0.drive(k..k + 10, period_s));
            });
        });
    }
    assert_eq!(found, expected);
}

#[test]
fn a_hundred_lives_of_the_library_on_short_lived_threads() {
    let packaged = Packaged::new();
    let period_s = packaged.sample_period_s();
    let mut first: Option<Vec<[u64; 8]>> = None;
    for life in 0..100 {
        let results = thread::scope(|scope| {
            let live = || {
                let (functions, code) = Functions::load(&packaged.library).unwrap();
                let raw = Raw::new(&functions, &packaged.guid, "short-lived");
                let results = raw.drive(0..100, period_s);
                raw.terminate();
                drop(raw);
                let counts = host::counts();
                assert_eq!(counts.allocations, counts.frees, "in life {life}");
                code.close().unwrap();
                results
            };
            scope.spawn(live).join().unwrap()
        });
        assert_eq!(first.get_or_insert_with(|| results.clone()), &results, "in life {life}");
    }
}
