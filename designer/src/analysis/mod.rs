//! What given gains are worth: at frozen operating points, certified, and after a start.

pub mod certificate;
pub mod certified;
pub mod estimate;
pub mod frequency;
pub mod operating_point;
pub mod start_up;
pub mod worth;
