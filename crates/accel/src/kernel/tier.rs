//! The instruction sets among which a structure chooses when it is built.

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
        match self {
            Self::Scalar => true,
            #[cfg(target_arch = "x86_64")]
            Self::Sse2 => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => super::avx2::Avx2::new().is_some(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => super::avx512::Avx512::new().is_some(),
            #[cfg(target_arch = "aarch64")]
            Self::Neon => true,
            _ => false,
        }
    }
}
