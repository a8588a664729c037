//! The text tables in data/color/: comma-separated, a line of names first, wavelengths in nanometres in the first column.

/// The pairs of wavelength and value in the column called `name`, wavelengths increasing.
///
/// The tables are part of the program: a missing column or a word that is no number would be found by every test that uses it.
pub(super) fn column(table: &str, name: &str) -> Option<Vec<(f32, f32)>> {
    let mut lines = table.lines().filter(|line| !line.starts_with('#'));
    let place = lines.next()?.split(',').position(|word| word == name)?;
    lines
        .map(|line| {
            let mut words = line.split(',');
            let nm = words.next()?.parse().ok()?;
            let value = words.nth(place.checked_sub(1)?)?.parse().ok()?;
            Some((nm, value))
        })
        .collect()
}

/// The value at `lambda` between samples of increasing wavelengths: linear; what `outside` says beyond their range.
pub(super) fn interpolate(samples: &[(f32, f32)], lambda: f32, outside: Outside) -> f32 {
    let after = samples.partition_point(|&(wavelength, _)| wavelength < lambda);
    match (after.checked_sub(1).and_then(|before| samples.get(before)), samples.get(after)) {
        (_, Some(&(wavelength, value))) if wavelength == lambda => value,
        (Some(&(x0, y0)), Some(&(x1, y1))) => y0 + (y1 - y0) * (lambda - x0) / (x1 - x0),
        (Some(&(_, end)), None) | (None, Some(&(_, end))) if outside == Outside::Ends => end,
        _ => 0.0,
    }
}

/// What lies outside the range of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outside {
    /// Nothing.
    Zero,
    /// The first and the last value.
    Ends,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_by_name() {
        let table = "# a remark\nnm,a,b\n400,1,2.5\n410,3,4\n";
        assert_eq!(column(table, "b"), Some(vec![(400.0, 2.5), (410.0, 4.0)]));
        assert_eq!(column(table, "c"), None);
        assert_eq!(column("nm,a\n400,x\n", "a"), None);
    }

    #[test]
    fn samples_are_joined_by_lines() {
        let samples = [(400.0, 1.0), (500.0, 3.0)];
        for (lambda, expected) in [(399.9, 0.0), (400.0, 1.0), (450.0, 2.0), (500.0, 3.0), (500.1, 0.0)] {
            assert_eq!(interpolate(&samples, lambda, Outside::Zero), expected, "{lambda}");
        }
        assert_eq!(interpolate(&samples, 100.0, Outside::Ends), 1.0);
        assert_eq!(interpolate(&samples, 900.0, Outside::Ends), 3.0);
        assert_eq!(interpolate(&[], 500.0, Outside::Ends), 0.0);
    }
}
