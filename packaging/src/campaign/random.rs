//! Random numbers by counter: each is a function of the campaign's seed, the drive and the quantity.
//!
//! # Conventions
//! - ChaCha8 with the seed as key, the drive's index as stream and the quantity as position, so a
//!   drive needs no other drive, and a new quantity changes none that is there.
//! - Only `+ - * /` turn the bits into numbers: the same on every machine.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};

/// What is drawn for a drive. The discriminant is the place in the drive's stream: it never changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Quantity {
    Manoeuvre = 0,
    Speed = 1,
    LowestSpeed = 2,
    LongitudinalAcceleration = 3,
    LateralAcceleration = 4,
    Direction = 5,
    Radius = 6,
    ManoeuvreStart = 7,
    Pause = 8,
    Bank = 16,
    Gust = 17,
    GustDuration = 18,
    GustStart = 19,
    GustPause = 20,
    NoiseSeed = 24,
    SpeedBias = 25,
    YawRateBias = 26,
    Mass = 32,
    YawInertia = 33,
    FrontStiffness = 34,
    RearStiffness = 35,
    Saturation = 36,
    Friction = 37,
    ActuatorLag = 38,
    ActuatorDelay = 39,
    Fault = 48,
    FaultSize = 49,
    FaultSign = 50,
    FaultRise = 51,
    FaultFrequency = 52,
    FaultLoss = 53,
    FaultDelay = 54,
    Onset = 55,
}

/// The random numbers of one drive.
pub struct Draw(ChaCha8Rng);

impl Draw {
    /// The numbers of drive `index` under `seed`.
    pub fn new(seed: u64, index: u64) -> Self {
        let mut key = [0; 32];
        for (place, byte) in key.iter_mut().zip(seed.to_le_bytes()) {
            *place = byte;
        }
        let mut generator = ChaCha8Rng::from_seed(key);
        generator.set_stream(index);
        Self(generator)
    }

    /// 64 random bits.
    pub fn bits(&mut self, quantity: Quantity) -> u64 {
        self.0.set_word_pos(2 * quantity as u128);
        self.0.next_u64()
    }

    /// Uniform in `[0, 1)`.
    fn unit(&mut self, quantity: Quantity) -> f64 {
        (self.bits(quantity) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in `[min, max]`.
    pub fn uniform(&mut self, quantity: Quantity, min: f64, max: f64) -> f64 {
        // Rounding may lead past the end.
        (min + (max - min) * self.unit(quantity)).min(max)
    }

    /// Uniform in `[-bound, bound]`.
    pub fn within(&mut self, quantity: Quantity, bound: f64) -> f64 {
        self.uniform(quantity, -bound, bound)
    }

    /// 1 or -1, equally likely.
    pub fn sign(&mut self, quantity: Quantity) -> f64 {
        if self.bits(quantity) >> 63 == 0 { 1.0 } else { -1.0 }
    }

    /// One of `choices`, equally likely; `None` of none.
    pub fn choose<T: Copy>(&mut self, quantity: Quantity, choices: &[T]) -> Option<T> {
        let place = (u128::from(self.bits(quantity)) * choices.len() as u128) >> 64;
        choices.get(place as usize).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_depend_on_seed_drive_and_quantity_alone() {
        let mut draw = Draw::new(7, 3);
        let bits = draw.bits(Quantity::Bank);
        draw.bits(Quantity::Onset);
        assert_eq!(draw.bits(Quantity::Bank), bits);
        assert_ne!(draw.bits(Quantity::Gust), bits);
        assert_ne!(Draw::new(7, 4).bits(Quantity::Bank), bits);
        assert_ne!(Draw::new(8, 3).bits(Quantity::Bank), bits);
    }

    #[test]
    fn numbers_are_those_of_chacha8() {
        // Key and nonce zero: the first words of ChaCha8's key stream, draft-strombergson, TC1.
        assert_eq!(
            Draw::new(0, 0).bits(Quantity::Manoeuvre).to_le_bytes(),
            [0x3e, 0x00, 0xef, 0x2f, 0x89, 0x5f, 0x40, 0xd6]
        );
    }

    #[test]
    fn uniform_numbers_fill_their_interval() {
        let n = 10_000;
        let numbers: Vec<_> =
            (0..n).map(|index| Draw::new(1, index).uniform(Quantity::Speed, 2.0, 6.0)).collect();
        assert!(numbers.iter().all(|x| (2.0..=6.0).contains(x)));
        let mean = numbers.iter().sum::<f64>() / n as f64;
        // Five standard errors.
        assert!((mean - 4.0).abs() < 5.0 * 4.0 / (12.0 * n as f64).sqrt(), "{mean}");
        let ones = (0..n).filter(|&index| Draw::new(1, index).sign(Quantity::Direction) > 0.0);
        assert!((ones.count() as f64 / n as f64 - 0.5).abs() < 5.0 * 0.5 / (n as f64).sqrt());
    }

    #[test]
    fn choices_are_equally_likely() {
        let mut counts = [0_u32; 7];
        for index in 0..7000 {
            let choice =
                Draw::new(1, index).choose(Quantity::Fault, &[0_usize, 1, 2, 3, 4, 5, 6]).unwrap();
            counts[choice] += 1;
        }
        assert!(counts.iter().all(|&count| count.abs_diff(1000) < 150), "{counts:?}");
    }
}
