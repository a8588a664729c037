//! What can be typed.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::{Parser, Subcommand, ValueEnum};
use sahl_accel::Tier;

use crate::Result;

/// Tasks of the project.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// The tasks.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Measure Sahl against programs that do the same.
    Peers {
        #[command(subcommand)]
        what: Peers,
    },
    /// Make the tables that turn RGB into spectra.
    Uplift {
        /// Where the tables of the standard observer lie, and where those made are written.
        #[arg(long, value_name = "DIR", default_value = "data/color")]
        data: PathBuf,
    },
}

/// What is compared.
#[derive(Debug, Subcommand)]
pub(crate) enum Peers {
    /// `sahl-accel` against Embree 4.4: the same rays in one process.
    Accel(AccelArgs),
}

/// How the acceleration structures are compared.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct AccelArgs {
    /// Fewer models and smaller images: a few minutes.
    #[arg(long)]
    pub(crate) quick: bool,
    /// Only these models, by name.
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub(crate) models: Vec<String>,
    /// Only these measurements.
    #[arg(long, value_name = "WHAT", value_delimiter = ',', value_enum)]
    pub(crate) only: Vec<Measurement>,
    /// Only these configurations of Embree.
    #[arg(long, value_name = "CONFIGURATION", value_delimiter = ',', value_enum)]
    pub(crate) peers: Vec<Peer>,
    /// The instruction set of Sahl's queries, by the name of its `Tier`; the fastest by default.
    #[arg(long, value_name = "TIER")]
    pub(crate) tier: Option<String>,
    /// Where `meshes/` and `sponza-crytek/` lie; without it the procedural models alone are used.
    #[arg(long, value_name = "DIR", env = "SAHL_SCENES")]
    pub(crate) scenes: Option<PathBuf>,
    /// Rounds of alternating runs, of which medians are taken.
    #[arg(long, value_name = "N", default_value = "5")]
    pub(crate) runs: NonZeroUsize,
    /// Threads where all are measured; those of the machine by default.
    #[arg(short, long, value_name = "N")]
    pub(crate) threads: Option<NonZeroUsize>,
}

/// What can be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Measurement {
    /// Nearest hits of camera rays, one thread.
    Primary,
    /// Nearest hits of one diffuse bounce, one thread.
    Bounce,
    /// Segments to a light, one thread.
    Occlusion,
    /// The bounces on all threads.
    Threads,
    /// Seconds to build.
    Build,
    /// Size of what was built.
    Memory,
    /// Rays at vertices and edges of closed meshes that hit nothing.
    Lost,
}

/// A configuration of Embree: instruction set and build quality.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Peer {
    /// AVX2, medium quality.
    Avx2Medium,
    /// AVX2, high quality.
    Avx2High,
    /// AVX-512, medium quality.
    Avx512Medium,
    /// AVX-512, high quality.
    Avx512High,
}

#[cfg_attr(not(feature = "embree"), expect(dead_code, reason = "without the feature nothing is compared"))]
impl AccelArgs {
    /// Whether `what` was asked for.
    pub(crate) fn measures(&self, what: Measurement) -> bool {
        self.only.is_empty() || self.only.contains(&what)
    }

    /// The instruction set that was asked for.
    ///
    /// # Errors
    /// There is none of that name, or the processor lacks it.
    pub(crate) fn tier(&self) -> Result<Option<Tier>> {
        let Some(name) = &self.tier else { return Ok(None) };
        let available: Vec<Tier> = Tier::ALL.into_iter().filter(|tier| tier.is_available()).collect();
        let found = available.iter().find(|tier| format!("{tier:?}").eq_ignore_ascii_case(name));
        found.map(|&tier| Some(tier)).ok_or_else(|| {
            format!("no instruction set `{name}` on this processor; there are: {available:?}").into()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(words: &str) -> Result<AccelArgs, clap::Error> {
        let words = ["xtask", "peers", "accel"].into_iter().chain(words.split_whitespace());
        Args::try_parse_from(words).map(|args| match args.command {
            Command::Peers { what: Peers::Accel(args) } => args,
            other => panic!("{other:?}"),
        })
    }

    #[test]
    fn nothing_typed_measures_everything() {
        let args = parse("").unwrap();
        assert!(!args.quick && args.models.is_empty() && args.peers.is_empty());
        assert_eq!((args.runs.get(), args.threads), (5, None));
        assert!(Measurement::value_variants().iter().all(|&what| args.measures(what)));
    }

    #[test]
    fn lists_are_separated_by_commas() {
        let args =
            parse("--quick --models bunny,head --only bounce,lost --peers avx2-high -t 3 --runs 7").unwrap();
        assert!(args.quick);
        assert_eq!(args.models, ["bunny", "head"]);
        assert!(args.measures(Measurement::Lost) && !args.measures(Measurement::Primary));
        assert_eq!(args.peers, [Peer::Avx2High]);
        assert_eq!((args.runs.get(), args.threads.map(NonZeroUsize::get)), (7, Some(3)));
    }

    #[test]
    fn nonsense_is_refused() {
        for words in ["--runs 0", "--threads 0", "--only speed", "--peers sse2", "extra"] {
            assert!(parse(words).is_err(), "{words}");
        }
    }

    #[test]
    fn the_definition_is_consistent() {
        use clap::CommandFactory;
        Args::command().debug_assert();
    }
}
