//! Multiple importance sampling: how much a sample counts that could have been found in two ways.
//!
//! Deliberately absent: the choice of ways, which belongs to who samples.

/// How much a sample found with density `pdf` counts beside another way of density `other`.
///
/// The power heuristic with exponent two: Veach, *Robust Monte Carlo Methods for Light Transport Simulation*, 1997, equation 9.13. The
/// ratio is squared, not the densities, which could overflow.
#[inline]
pub(crate) fn power_heuristic(pdf: f32, other: f32) -> f32 {
    let ratio = other / pdf;
    1.0 / (1.0 + ratio * ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_both_ways_add_up_to_one() {
        for (a, b) in [(1.0, 1.0), (0.2, 30.0), (1e30, 1e25), (1e-30, 1e-28)] {
            assert!((power_heuristic(a, b) + power_heuristic(b, a) - 1.0).abs() < 1e-6);
        }
        assert_eq!([power_heuristic(2.0, 0.0), power_heuristic(1.0, f32::INFINITY)], [1.0, 0.0]);
    }
}
