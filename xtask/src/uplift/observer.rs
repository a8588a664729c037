//! The standard observer under a white, as weights of samples.

use crate::Result;

/// What turns the values of a reflectance into its XYZ under a white.
pub(super) struct Observer {
    /// Of each nanometre: place from −1 at 360 nm to 1 at 830 nm, and weights whose products with the reflectance add up to XYZ.
    pub(super) samples: Vec<(f64, [f64; 3])>,
    /// XYZ of the white, Y being one.
    pub(super) white: [f64; 3],
}

impl Observer {
    /// The observer of the table `functions` under the column `illuminant` of the table `illuminants`: both in the format of
    /// the files in data/color/.
    pub(super) fn new(functions: &str, illuminants: &str, illuminant: &str) -> Result<Self> {
        let power = column(illuminants, illuminant)?;
        let [x, y, z] = [column(functions, "x")?, column(functions, "y")?, column(functions, "z")?];
        let mut samples = Vec::with_capacity(x.len());
        for (i, &(nm, x)) in x.iter().enumerate() {
            let power = interpolate(&power, nm);
            samples.push(((nm - 595.0) / 235.0, [x * power, y[i].1 * power, z[i].1 * power]));
        }
        let total: f64 = samples.iter().map(|(_, weights)| weights[1]).sum();
        let mut white = [0.0; 3];
        for (_, weights) in &mut samples {
            *weights = weights.map(|weight| weight / total);
            for (white, weight) in white.iter_mut().zip(*weights) {
                *white += weight;
            }
        }
        Ok(Self { samples, white })
    }
}

/// An illuminant as Jakob and Hanika's program has it.
pub(super) struct Illuminant {
    /// Its column in the table of illuminants.
    pub(super) name: &'static str,
    /// The last wavelength at which it is not zero.
    pub(super) last: f64,
    /// What it is divided by: ∫ ȳ P dλ to some digits.
    pub(super) total: f64,
}

impl Observer {
    /// The observer as Jakob and Hanika's program has it: of every fifth nanometre of `functions`, linear between, by Simpson's
    /// 3/8 rule.
    pub(super) fn coarse(functions: &str, illuminants: &str, illuminant: &Illuminant) -> Result<Self> {
        const PARTS: usize = 3 * 94;
        let every_fifth =
            |name| -> Result<Vec<_>> { Ok(column(functions, name)?.into_iter().step_by(5).collect()) };
        let (power, [x, y, z]) =
            (power(illuminants, illuminant)?, [every_fifth("x")?, every_fifth("y")?, every_fifth("z")?]);
        let mut samples = Vec::with_capacity(PARTS + 1);
        let mut white = [0.0; 3];
        for i in 0..=PARTS {
            let place = i as f64 / PARTS as f64;
            let nm = 360.0 + 470.0 * place;
            let rule = match i {
                0 | PARTS => 1.0,
                _ if i.is_multiple_of(3) => 2.0,
                _ => 3.0,
            };
            let weight = 0.375 * rule * (470.0 / PARTS as f64) * interpolate(&power, nm) / illuminant.total;
            let weights = [&x, &y, &z].map(|function| weight * interpolate(function, nm));
            samples.push((2.0 * place - 1.0, weights));
            for (white, weight) in white.iter_mut().zip(weights) {
                *white += weight;
            }
        }
        Ok(Self { samples, white })
    }
}

/// The pairs of wavelength and power of an illuminant, every five nanometres.
fn power(illuminants: &str, illuminant: &Illuminant) -> Result<Vec<(f64, f64)>> {
    let end = |(nm, power)| (nm, if nm > illuminant.last { 0.0 } else { power });
    Ok(column(illuminants, illuminant.name)?.into_iter().map(end).collect())
}

/// The pairs of wavelength and value in the column called `name` of a table with commas.
fn column(table: &str, name: &str) -> Result<Vec<(f64, f64)>> {
    let mut lines = table.lines().filter(|line| !line.starts_with('#'));
    let head = lines.next().ok_or("the table is empty")?;
    let place = head.split(',').position(|word| word == name).ok_or_else(|| format!("no column `{name}`"))?;
    lines
        .map(|line| {
            let words: Vec<&str> = line.split(',').collect();
            let value = words.get(place).ok_or_else(|| format!("a short line: `{line}`"))?;
            Ok((words[0].parse()?, value.parse()?))
        })
        .collect()
}

/// The value at `nm`, linear between the pairs and constant outside.
fn interpolate(pairs: &[(f64, f64)], nm: f64) -> f64 {
    let after = pairs.partition_point(|&(x, _)| x < nm).clamp(1, pairs.len() - 1);
    let ((x0, y0), (x1, y1)) = (pairs[after - 1], pairs[after]);
    y0 + (y1 - y0) * ((nm - x0) / (x1 - x0)).clamp(0.0, 1.0)
}
