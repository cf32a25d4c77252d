//! A model with one variable of each sort.

use std::ffi::CStr;

use steerguard_fmu_core::{Archive, Log, Model, Status};
use steerguard_model_description::{
    EnumerationItem, EnumerationType, Kind, ModelInfo, Role, Value, unit, variables,
};

/// Sample period of the toy, s.
pub const PERIOD: f64 = 0.01;
pub const PAYLOAD: [u8; 8] = PERIOD.to_le_bytes();

const MODE: EnumerationType = EnumerationType {
    name: "Mode",
    description: "What the integrator does",
    items: &[
        EnumerationItem { name: "Run", description: "Integrates" },
        EnumerationItem { name: "Fail", description: "Cannot be initialised" },
    ],
};

variables! {
    /// The variables of the toy.
    pub enum ToyVariable {
        Input, "u", "Input", Role::INPUT, Kind::real(&unit::ONE).min(0.0).max(1.0);
        Order, "order", "Whole-numbered input", Role::INPUT, Kind::Integer { min: -4, max: 0 };
        Output, "y", "Integral of gain u", Role::OUTPUT, Kind::real(&unit::ONE);
        Seen, "seen", "Input at the last sample", Role::LOCAL, Kind::real(&unit::ONE);
        Samples, "samples", "Samples run", Role::LOCAL, Kind::Integer { min: 0, max: i32::MAX };
        Gain, "gain", "Gain", Role::TUNABLE_PARAMETER, Kind::real(&unit::ONE).min(0.0).max(10.0);
        Offset, "offset", "Initial y", Role::FIXED_PARAMETER, Kind::real(&unit::ONE);
        Mode, "mode", "Mode", Role::FIXED_PARAMETER, Kind::Enumeration(&MODE);
        Hold, "hold", "Integrate nothing", Role::TUNABLE_PARAMETER, Kind::Boolean;
        Label, "label", "Any text", Role::FIXED_PARAMETER, Kind::String;
        Period, "period", "Sample period", Role::CONSTANT, Kind::real(&unit::SECOND);
    }
}

use ToyVariable as V;

#[derive(Clone)]
pub struct Toy {
    period: f64,
    input: f64,
    order: i32,
    output: f64,
    seen: f64,
    samples: i32,
    gain: f64,
    offset: f64,
    mode: i32,
    hold: bool,
    label: [u8; 16],
}

impl Model for Toy {
    type Variable = ToyVariable;
    const INFO: ModelInfo = ModelInfo { name: "Toy", identifier: "Toy", description: "A toy" };

    fn new(payload: &[u8]) -> Result<Self, &'static str> {
        let period = <[u8; 8]>::try_from(payload).map_err(|_| "the toy's payload is no number")?;
        Ok(Self {
            period: f64::from_le_bytes(period),
            input: 0.0,
            order: 0,
            output: 0.0,
            seen: 0.0,
            samples: 0,
            gain: 1.0,
            offset: 0.0,
            mode: 1,
            hold: false,
            label: [0; 16],
        })
    }

    fn sample_period_s(&self) -> f64 {
        self.period
    }

    fn get(&self, variable: V) -> Value<'_> {
        match variable {
            V::Input => Value::Real(self.input),
            V::Order => Value::Integer(self.order),
            V::Output => Value::Real(self.output),
            V::Seen => Value::Real(self.seen),
            V::Samples => Value::Integer(self.samples),
            V::Gain => Value::Real(self.gain),
            V::Offset => Value::Real(self.offset),
            V::Mode => Value::Integer(self.mode),
            V::Hold => Value::Boolean(self.hold),
            V::Label => Value::String(CStr::from_bytes_until_nul(&self.label).unwrap()),
            V::Period => Value::Real(self.period),
        }
    }

    fn set(&mut self, variable: V, value: Value<'_>) {
        match variable {
            V::Input => value.store_real(&mut self.input),
            V::Order => value.store_integer(&mut self.order),
            V::Gain => value.store_real(&mut self.gain),
            V::Offset => value.store_real(&mut self.offset),
            V::Mode => value.store_integer(&mut self.mode),
            V::Hold => value.store_boolean(&mut self.hold),
            V::Label => {
                let Value::String(text) = value else { unreachable!() };
                let length = text.count_bytes().min(15);
                self.label = [0; 16];
                self.label[..length].copy_from_slice(&text.to_bytes()[..length]);
            }
            V::Output | V::Seen | V::Samples | V::Period => unreachable!(),
        }
    }

    fn initialise(&mut self, start_time_s: f64) -> Result<(), &'static str> {
        assert!(start_time_s.is_finite());
        self.output = self.offset;
        if self.mode == 2 { Err("the toy was told to fail") } else { Ok(()) }
    }

    fn sample(&mut self, log: &Log<'_>) -> Status {
        match self.order {
            -1 => return Status::Discard,
            -2 => {
                log.error(|text| {
                    text.str("the toy broke");
                });
                return Status::Error;
            }
            -3 => return Status::Fatal,
            -4 => log.warning(|text| {
                text.str("careful");
            }),
            _ => log.event(|text| {
                text.str("sample ").integer(self.samples.into());
            }),
        }
        self.samples += 1;
        self.seen = self.input;
        if !self.hold {
            self.output += self.gain * self.input * self.period;
        }
        if self.order == -4 { Status::Warning } else { Status::Ok }
    }

    fn archive(&mut self, archive: &mut Archive<'_>) {
        archive.real(&mut self.input);
        let mut order = self.order.unsigned_abs();
        archive.u32(&mut order);
        self.order = -(order as i32);
        archive.finite(&mut self.output);
        archive.real(&mut self.seen);
        let mut samples = self.samples as u32;
        archive.u32(&mut samples);
        self.samples = samples as i32;
        archive.finite(&mut self.gain);
        archive.finite(&mut self.offset);
        archive.choice(&mut self.mode, &[1, 2]);
        archive.flag(&mut self.hold);
        archive.bytes(&mut self.label);
        archive.require(self.label[15] == 0);
    }
}
