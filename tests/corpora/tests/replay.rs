//! What fuzzing has found, given again to what it was found for: the corpora, and every example of the project.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::{Path, PathBuf};

use steerguard_corpora::TARGETS;

/// Gives every file of `corpus/TARGET` to the target, and names the one that breaks it.
fn replay(name: &str) {
    struct Current(PathBuf);
    impl Drop for Current {
        fn drop(&mut self) {
            if std::thread::panicking() {
                eprintln!("this was {}", self.0.display());
            }
        }
    }
    let target = steerguard_corpora::target(name);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(name);
    let mut inputs = 0;
    for entry in fs::read_dir(&folder).unwrap() {
        let input = Current(entry.unwrap().path());
        target(&fs::read(&input.0).unwrap());
        inputs += 1;
    }
    assert!(inputs > 0, "`{}` is empty", folder.display());
}

macro_rules! corpora {
    ($($name:ident)+) => {
        $(#[test]
        fn $name() {
            replay(stringify!($name));
        })+

        #[test]
        fn every_target_has_a_corpus() {
            let tested = [$(stringify!($name)),+];
            assert_eq!(tested, TARGETS.map(|(name, _)| name));
        }
    };
}

corpora!(specification scenario design drive xml archive block state fmi2 fmi3);
