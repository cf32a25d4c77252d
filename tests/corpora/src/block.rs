//! The block that a design is baked into.

use steerguard_fmu::{BakedDesign, DetectorModel};
use steerguard_fmu_core::{BLOCK_SIZE, Categories, Log, Logger, Model, Text, baked, seal};
use steerguard_model_description::detector::DetectorVariable as V;
use steerguard_model_description::{LogCategory, Value, VariableSet};

use crate::unsolved::{BLOCK, PAYLOAD};

/// Takes all messages, so that they are made.
struct Listener(Categories);

impl Logger for Listener {
    fn categories(&self) -> Categories {
        self.0
    }

    fn send(&self, _: LogCategory, text: &Text) {
        assert!(!text.as_str().is_empty());
    }
}

/// Bytes are edits: place (two bytes, little-endian) and what goes there (eight).
pub fn edited(original: &[u8], edits: &[u8]) -> Vec<u8> {
    let mut bytes = original.to_vec();
    for edit in edits.chunks_exact(10) {
        let place = usize::from(u16::from_le_bytes([edit[0], edit[1]])) % bytes.len();
        let end = bytes.len().min(place + 8);
        bytes[place..end].copy_from_slice(&edit[2..2 + end - place]);
    }
    bytes
}

pub fn run(bytes: &[u8]) {
    let [kind, edits @ ..] = bytes else { return };
    let mut block = BLOCK.load();
    if kind % 4 == 0 {
        // A block with damage: what is opened is what was sealed, or the damage is seen.
        let damaged = edited(&block, edits);
        let mut array = [0; BLOCK_SIZE];
        array.copy_from_slice(&damaged);
        if let Ok(open) = baked::open(&array) {
            let _ = DetectorModel::new(open.payload);
        }
        return;
    }
    // Other numbers under a checksum that fits: what comes of them is finite, and nothing panics.
    let payload = edited(&PAYLOAD, edits);
    seal(&mut block, "{fuzz}", &payload).unwrap();
    let open = baked::open(&block).expect("what is sealed opens");
    assert_eq!((open.guid, open.payload), ("{fuzz}", payload.as_slice()));
    if let Ok(design) = BakedDesign::decode(open.payload) {
        // Bytes of what is absent may be any, and zero has two signs: the design is the same, not its bytes.
        let again = BakedDesign::decode(&design.encode().unwrap());
        assert_eq!(again, Ok(design), "encoded and decoded again");
    }
    let Ok(mut model) = DetectorModel::new(open.payload) else { return };
    assert!(model.sample_period_s() > 0.0 && model.sample_period_s().is_finite());
    if model.initialise(0.0).is_err() {
        return;
    }
    let mut all = Categories::NONE;
    all.enable(LogCategory::All);
    let listener = Listener(all);
    let log = Log::new(&listener);
    for k in 0..60_u8 {
        for (variable, value) in
            [(V::SpeedX, 15.0), (V::YawRate, 0.2 * f64::from(k % 7)), (V::SteeringAngle, 0.01)]
        {
            model.set(variable, Value::Real(value));
        }
        model.sample(&log);
        for &variable in V::ALL {
            if let Value::Real(real) = model.get(variable) {
                assert!(
                    real.is_finite(),
                    "{} is {real} at sample {k}",
                    V::TABLE[variable.value_reference() as usize].name
                );
            }
        }
    }
}
