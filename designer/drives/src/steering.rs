//! From the hand wheel to the road wheel by a table, for a steering gear whose ratio varies.

/// Angles of the hand wheel, and of the road wheel at each.
///
/// Straight lines join its points, and the first and last of them go on beyond it. A table that begins at 0 is
/// turned about it for the other side.
#[derive(Clone, Debug, PartialEq)]
pub struct SteeringTable {
    /// Hand wheel, road wheel, rad, rising.
    points: Vec<[f64; 2]>,
}

/// A table that is none.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SteeringTableError {
    /// No line.
    #[error("{0} points; it takes two, of [hand wheel, road wheel] in deg")]
    TooShort(usize),
    /// Angles that do not rise.
    #[error("the point [{0}, {1}] does not lie beyond the one before it, in both angles")]
    Falls(f64, f64),
    /// No angles of a wheel.
    #[error(
        "the point [{0}, {1}] is none of angles in deg: the hand wheel's is within 3600, the road wheel's \
         within 90"
    )]
    NoAngles(f64, f64),
    /// No line through straight ahead.
    #[error("it ends before 0: straight ahead has to be in it")]
    NotAhead,
}

impl SteeringTable {
    /// The table of such points `[hand wheel, road wheel]`, deg.
    ///
    /// # Errors
    /// [`SteeringTableError`].
    pub fn of_degrees(points: &[[f64; 2]]) -> Result<Self, SteeringTableError> {
        use SteeringTableError::{Falls, NoAngles, NotAhead, TooShort};
        for (index, &[hand, road]) in points.iter().enumerate() {
            if !(hand.abs() <= 3600.0 && road.abs() <= 90.0) {
                return Err(NoAngles(hand, road));
            }
            let before = index.checked_sub(1).map(|before| points[before]);
            if before
                .is_some_and(|[other_hand, other_road]| hand <= other_hand || road <= other_road)
            {
                return Err(Falls(hand, road));
            }
        }
        let (Some(first), Some(last), 2..) = (points.first(), points.last(), points.len()) else {
            return Err(TooShort(points.len()));
        };
        if first[0] > 0.0 || last[0] < 0.0 {
            return Err(NotAhead);
        }
        let mirrored = points.iter().rev().filter(|_| *first == [0.0, 0.0]);
        let mirrored =
            mirrored.map(|point| point.map(|angle| -angle)).filter(|point| point[0] < 0.0);
        let all = mirrored.chain(points.iter().copied());
        Ok(Self { points: all.map(|point| point.map(f64::to_radians)).collect() })
    }

    /// Number of its points, those of the other side included.
    pub fn points(&self) -> usize {
        self.points.len()
    }

    /// Angle of the road wheel where the hand wheel stands at `hand_rad`, rad.
    pub fn road_wheel_rad(&self, hand_rad: f64) -> f64 {
        let beyond = self.points.partition_point(|[hand, _]| *hand < hand_rad);
        let end = beyond.clamp(1, self.points.len() - 1);
        let ([from, low], [to, high]) = (self.points[end - 1], self.points[end]);
        low + (high - low) * (hand_rad - from) / (to - from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn deg(table: &SteeringTable, hand_deg: f64) -> f64 {
        table.road_wheel_rad(hand_deg.to_radians()).to_degrees()
    }

    #[test]
    fn lines_join_the_points_and_go_on_beyond_them() {
        let table = SteeringTable::of_degrees(&[[-90.0, -6.0], [0.0, 0.5], [100.0, 5.5]]).unwrap();
        for (hand, road) in
            [(-90.0, -6.0), (-45.0, -2.75), (0.0, 0.5), (50.0, 3.0), (200.0, 10.5), (-180.0, -12.5)]
        {
            assert!((deg(&table, hand) - road).abs() < 1e-12, "{hand}");
        }
        assert!(table.road_wheel_rad(f64::NAN).is_nan());
    }

    #[test]
    fn a_table_of_one_side_serves_both() {
        let table = SteeringTable::of_degrees(&[[0.0, 0.0], [90.0, 5.0], [450.0, 35.0]]).unwrap();
        assert_eq!(table.points(), 5);
        for hand in [0.0, 30.0, 90.0, 200.0, 500.0] {
            assert!((deg(&table, -hand) + deg(&table, hand)).abs() < 1e-12, "{hand}");
        }
    }

    #[test]
    fn what_is_no_table_is_refused() {
        use SteeringTableError::{Falls, NoAngles, NotAhead, TooShort};
        for (points, error) in [
            (&[[0.0, 0.0]][..], TooShort(1)),
            (&[], TooShort(0)),
            (&[[0.0, 0.0], [90.0, -5.0]], Falls(90.0, -5.0)),
            (&[[0.0, 0.0], [0.0, 1.0]], Falls(0.0, 1.0)),
            (&[[0.0, 0.0], [90.0, 500.0]], NoAngles(90.0, 500.0)),
            (&[[10.0, 1.0], [90.0, 5.0]], NotAhead),
        ] {
            assert_eq!(SteeringTable::of_degrees(points), Err(error));
        }
        let not_a_number = SteeringTable::of_degrees(&[[0.0, 0.0], [f64::NAN, 1.0]]);
        assert!(matches!(not_a_number, Err(NoAngles(..))));
    }
}
