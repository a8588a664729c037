//! What remains of all tables: one ratio a measurement, and where it is worst.

use std::fmt::{self, Display, Formatter};

use super::timing::geometric_mean;
use crate::args::Measurement;

/// The ratios of Sahl to Embree that were measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Summary {
    /// What, of which model, the ratio. Several of one model count as much as those of several.
    pub(crate) ratios: Vec<(Measurement, &'static str, f64)>,
    /// Two threads over one, a model.
    pub(crate) scaling: Vec<f64>,
    /// Lost rays, if they were counted.
    pub(crate) lost: Option<u64>,
}

impl Summary {
    fn values(&self, what: Measurement) -> impl Iterator<Item = (&'static str, f64)> {
        self.ratios
            .iter()
            .filter(move |(measured, ..)| *measured == what)
            .map(|&(_, model, ratio)| (model, ratio))
    }

    fn mean(&self, what: Measurement) -> String {
        shown(geometric_mean(self.values(what).map(|(_, ratio)| ratio)))
    }

    /// The model with the least ratio; with the greatest where small ones are good.
    fn worst(&self, what: Measurement) -> Option<(&'static str, f64)> {
        let small_is_good = matches!(what, Measurement::Build | Measurement::Memory);
        let badness = |ratio: f64| if small_is_good { ratio } else { -ratio };
        self.values(what).max_by(|a, b| badness(a.1).total_cmp(&badness(b.1)))
    }
}

/// Everything that has a ratio, in the order in which it is told.
const RATIOS: [(&str, Measurement); 6] = [
    ("primary", Measurement::Primary),
    ("bounce", Measurement::Bounce),
    ("occlusion", Measurement::Occlusion),
    ("threads", Measurement::Threads),
    ("build", Measurement::Build),
    ("memory", Measurement::Memory),
];

impl Display for Summary {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let worst = |&(name, what): &(&str, Measurement)| {
            self.worst(what).map(|(model, ratio)| format!(" {name} {ratio:.2} ({model})"))
        };
        let worst: String = RATIOS.iter().filter_map(worst).collect();
        if !worst.is_empty() {
            writeln!(f, "worst{worst}")?;
        }
        writeln!(f, "scaling {}", shown(geometric_mean(self.scaling.iter().copied())))?;
        write!(f, "geomean")?;
        for (name, what) in RATIOS {
            write!(f, " {name} {}", self.mean(what))?;
        }
        write!(f, " lost {}", self.lost.map_or("-".to_owned(), |lost| lost.to_string()))
    }
}

/// A ratio, or a dash for what was not measured.
fn shown(ratio: Option<f64>) -> String {
    ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.2}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_line_has_its_form() {
        let ratios = RATIOS.iter().zip([1.05, 1.24, 1.22, 1.21, 0.93, 0.98]);
        let ratios = ratios.map(|(&(_, what), ratio)| (what, "bunny", ratio)).collect();
        let summary = Summary { ratios, scaling: vec![1.9], lost: Some(0) }.to_string();
        let lines: Vec<&str> = summary.lines().collect();
        assert_eq!(lines[1], "scaling 1.90");
        assert_eq!(
            lines[2],
            "geomean primary 1.05 bounce 1.24 occlusion 1.22 threads 1.21 build 0.93 memory 0.98 lost 0"
        );
    }

    #[test]
    fn the_worst_is_the_smallest_rate_and_the_largest_size() {
        let of = |what, a, b| [(what, "a", a), (what, "b", b)];
        let ratios = [of(Measurement::Bounce, 1.2, 0.3), of(Measurement::Memory, 1.2, 0.3)]
            .into_iter()
            .flatten()
            .collect();
        let summary = Summary { ratios, ..Summary::default() };
        assert_eq!(summary.to_string().lines().next(), Some("worst bounce 0.30 (b) memory 1.20 (a)"));
    }

    #[test]
    fn what_was_not_measured_is_a_dash() {
        let summary = Summary {
            ratios: vec![(Measurement::Bounce, "a", 4.0), (Measurement::Bounce, "b", 1.0)],
            ..Summary::default()
        };
        assert!(
            summary
                .to_string()
                .ends_with("geomean primary - bounce 2.00 occlusion - threads - build - memory - lost -")
        );
    }
}
