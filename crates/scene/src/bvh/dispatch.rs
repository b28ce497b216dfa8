//! The widest vector instructions of the machine, chosen at run time. All `unsafe` of this
//! workspace is here.
//!
//! The workspace is compiled for any x86-64, whose baseline has vectors of four numbers. In a trial
//! of the traversal alone a LiDAR ray took 149 ns with them, 101 ns with AVX2, 71 ns with AVX-512.
//! (The triangles of published `medium`, holes ignored, one core.) The code is the same and only
//! the instructions differ. None of them is fused, so the results have the same bits
//! (`every_instruction_set_gives_the_same_bits`).

use std::sync::LazyLock;

/// Loops over lanes that benefit from wide vectors.
pub trait Kernel {
    /// Result of the work.
    type Output;

    /// Does the work. It must be `#[inline(always)]`, and so must everything that its loops call:
    /// code that is not inlined keeps the instructions of the baseline.
    fn run(self) -> Self::Output;
}

/// Runs a kernel with the widest vectors of this machine.
#[inline]
pub fn widest<K: Kernel>(kernel: K) -> K::Output {
    static WIDEST: LazyLock<Vectors> = LazyLock::new(|| {
        Vectors::available()
            .pop()
            .unwrap_or(Vectors(Instructions::Baseline))
    });
    WIDEST.run(kernel)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Instructions {
    Baseline,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

/// A set of vector instructions that this machine has; only [`Vectors::available`] makes them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Vectors(Instructions);

impl Vectors {
    /// The sets that this machine has, the widest last.
    pub(super) fn available() -> Vec<Self> {
        let mut sets = vec![Self(Instructions::Baseline)];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") {
                sets.push(Self(Instructions::Avx2));
            }
            if is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512bw")
            {
                sets.push(Self(Instructions::Avx512));
            }
        }
        sets
    }

    /// Runs a kernel with these instructions.
    #[cfg_attr(
        target_arch = "x86_64",
        expect(unsafe_code, reason = "the machine has what is called, see `Vectors`")
    )]
    #[inline]
    pub(super) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            Instructions::Baseline => kernel.run(),
            // SAFETY: `available` lists only sets that `is_x86_feature_detected!` found on this
            // machine.
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx2 => unsafe { run_avx2(kernel) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx512 => unsafe { run_avx512(kernel) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw")]
fn run_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}
