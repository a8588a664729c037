//! The instruction sets among which a structure chooses when it is built.

#[cfg(target_arch = "x86_64")]
use super::avx2::Avx2;
#[cfg(target_arch = "x86_64")]
use super::avx512::Avx512;
use super::isa::{Isa, Task};
#[cfg(target_arch = "aarch64")]
use super::neon::Neon;
use super::scalar::Scalar;
#[cfg(target_arch = "x86_64")]
use super::sse2::Sse2;

/// An instruction set that queries run on. All give the same hits, to the last bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Tier {
    /// Plain Rust: the specification of the others, and what processors run that have none of them.
    Scalar,
    /// SSE2, part of every x86-64 processor.
    Sse2,
    /// NEON, part of every aarch64 processor.
    Neon,
    /// AVX2 with BMI: x86-64 since 2013.
    Avx2,
    /// AVX-512 with F, VL, BW and DQ.
    Avx512,
}

impl Tier {
    /// All tiers, the slowest first.
    pub const ALL: [Self; 5] = [Self::Scalar, Self::Sse2, Self::Neon, Self::Avx2, Self::Avx512];

    /// The fastest that this processor has.
    pub fn detect() -> Self {
        Self::ALL.into_iter().rfind(|tier| tier.is_available()).unwrap_or(Self::Scalar)
    }

    /// Whether this processor has the instruction set.
    pub fn is_available(self) -> bool {
        Machine::of(self).is_some()
    }
}

/// A tier with the proof that the processor has it, so that queries need not ask.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Machine {
    Scalar(Scalar),
    #[cfg(target_arch = "x86_64")]
    Sse2(Sse2),
    #[cfg(target_arch = "aarch64")]
    Neon(Neon),
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(Avx512),
}

impl Machine {
    /// The tier, or the fastest instead of one that this processor lacks.
    pub(crate) fn choose(tier: Option<Tier>) -> Self {
        tier.and_then(Self::of).or_else(|| Self::of(Tier::detect())).unwrap_or(Self::Scalar(Scalar))
    }

    fn of(tier: Tier) -> Option<Self> {
        match tier {
            Tier::Scalar => Some(Self::Scalar(Scalar)),
            #[cfg(target_arch = "x86_64")]
            Tier::Sse2 => Some(Self::Sse2(Sse2)),
            #[cfg(target_arch = "aarch64")]
            Tier::Neon => Some(Self::Neon(Neon)),
            #[cfg(target_arch = "x86_64")]
            Tier::Avx2 => Avx2::new().map(Self::Avx2),
            #[cfg(target_arch = "x86_64")]
            Tier::Avx512 => Avx512::new().map(Self::Avx512),
            _ => None,
        }
    }

    /// Runs a task in code compiled for the tier.
    #[inline(always)]
    pub(crate) fn run<T: Task>(self, task: T) -> T::Output {
        match self {
            Self::Scalar(isa) => isa.enter(task),
            #[cfg(target_arch = "x86_64")]
            Self::Sse2(isa) => isa.enter(task),
            #[cfg(target_arch = "aarch64")]
            Self::Neon(isa) => isa.enter(task),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(isa) => isa.enter(task),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(isa) => isa.enter(task),
        }
    }
}

/// Runs a task on a tier, or on the fastest instead of one that this processor lacks.
#[cfg(test)]
pub(crate) fn dispatch<T: Task>(tier: Tier, task: T) -> T::Output {
    Machine::choose(Some(tier)).run(task)
}
