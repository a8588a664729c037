//! Edge cases and inverses; the sampling is tested by the statistical tests of the crate.

use super::*;

#[test]
fn densities_are_the_function_over_its_integral() {
    let line = PiecewiseConstant1d::new(&[1.0, 0.0, 3.0, 4.0]);
    assert_eq!(line.integral(), 2.0);
    assert_eq!([0.1, 0.3, 0.6, 0.9, 1.0].map(|x| line.pdf(x)), [0.5, 0.0, 1.5, 2.0, 2.0]);
    assert_eq!((line.pdf(-0.1), line.pdf(1.1), line.pdf(f32::NAN)), (0.0, 0.0, 0.0));
    let grid = PiecewiseConstant2d::new(&[1.0, 3.0, 0.0, 4.0], 2);
    assert_eq!(grid.integral(), 2.0);
    assert_eq!(grid.pdf(Vec2::new(0.7, 0.2)), 1.5);
    assert_eq!(grid.pdf(Vec2::new(0.2, 0.7)), 0.0);
    assert_eq!(grid.pdf(Vec2::new(1.2, 0.7)), 0.0);
}

#[test]
fn inverses_undo() {
    let line = PiecewiseConstant1d::new(&[0.0, 1.0, 0.0, 3.0, 4.0, 0.0]);
    let grid = PiecewiseConstant2d::new(&[1.0, 3.0, 0.0, 4.0, 0.5, 2.0], 3);
    for i in 0..100 {
        let u = Vec2::new(i as f32 / 100.0, (i * 37 % 100) as f32 / 100.0);
        assert!((line.inverse(line.sample(u.x).0) - u.x).abs() < 1e-6);
        assert!((grid.inverse(grid.sample(u).0) - u).length() < 1e-5, "{u:?}");
    }
}

#[test]
fn nothing_of_zero_probability_is_drawn() {
    let values = [0.0, 0.0, 1.0, 0.0, 2.0, 0.0, 0.0];
    let line = PiecewiseConstant1d::new(&values);
    let alias = AliasTable::new(&values);
    let below_one = 1.0 - f32::EPSILON / 2.0;
    for u in (0..1000).map(|i| i as f32 / 1000.0).chain([0.0, 1e-30, below_one]) {
        let (x, pdf, entry) = line.sample(u);
        assert!(values[entry] > 0.0 && pdf > 0.0 && x < 1.0 && pdf == line.pdf(x), "{u}: {x}");
        let (outcome, pmf, rest) = alias.sample(f64::from(u)).unwrap();
        assert!(values[outcome] > 0.0 && pmf > 0.0 && (0.0..1.0).contains(&rest), "{u}: {outcome}");
    }
}

#[test]
fn a_function_that_is_zero_is_sampled_uniformly() {
    let line = PiecewiseConstant1d::new(&[0.0; 4]);
    assert_eq!((line.integral(), line.sample(0.3).1, line.pdf(0.9)), (0.0, 1.0, 1.0));
    assert!((line.sample(0.3).0 - 0.3).abs() < 1e-6);
    let grid = PiecewiseConstant2d::new(&[0.0, f32::NAN, -1.0, f32::INFINITY], 2);
    let (p, pdf) = grid.sample(Vec2::new(0.8, 0.1));
    assert!((p - Vec2::new(0.8, 0.1)).length() < 1e-6 && pdf == 1.0 && grid.integral() == 0.0);
    let alias = AliasTable::new(&[0.0; 5]);
    assert_eq!(alias.sample(0.5).map(|(outcome, pmf, _)| (outcome, pmf)), Some((2, 0.2)));
}

#[test]
fn a_single_outcome_and_none() {
    let alias = AliasTable::new(&[7.0]);
    assert_eq!(alias.sample(0.25), Some((0, 1.0, 0.25)));
    let none = AliasTable::new(&[]);
    assert!(none.is_empty() && none.sample(0.5).is_none() && none.pmf(0) == 0.0);
}

#[test]
fn the_tail_of_a_long_table_has_its_share() {
    // Single-precision sums of a million equal values drift by whole per cents.
    let count = 1 << 20;
    let line = PiecewiseConstant1d::new(&vec![0.1; count]);
    for x in [0.25, 0.5, 0.75, 0.999] {
        assert!((line.sample(x).0 - x).abs() < 1e-6, "{x}: {}", line.sample(x).0);
    }
    assert!((line.integral() - 0.1).abs() < 1e-7);
}

#[test]
fn an_alias_table_keeps_every_probability() {
    let weights: Vec<f32> = (0..1000).map(|i| ((i * 7919) % 1009) as f32).collect();
    let alias = AliasTable::new(&weights);
    let total: f32 = weights.iter().sum();
    // The mass of each outcome, added up over the bins.
    let mut mass = vec![0.0_f64; weights.len()];
    for (own, bin) in alias.bins.iter().enumerate() {
        mass[own] += f64::from(bin.share);
        mass[bin.alias as usize] += 1.0 - f64::from(bin.share);
    }
    for (outcome, &weight) in weights.iter().enumerate() {
        let expected = f64::from(weight / total);
        assert!((mass[outcome] / 1000.0 - expected).abs() < 1e-7, "{outcome}");
        assert!((f64::from(alias.pmf(outcome)) - expected).abs() < 1e-7);
    }
}
