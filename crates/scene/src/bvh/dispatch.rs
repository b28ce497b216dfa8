//! The widest vector instructions that the machine has, chosen at run time. All `unsafe` of this workspace is here.
//!
//! The workspace is compiled for any x86-64, whose baseline has vectors of four numbers. In a trial of this traversal alone (the triangles of
//! published `medium`, holes not regarded, one core) a LiDAR ray took 149 ns with them, 101 ns with AVX2, 71 ns with AVX-512. The code is the same; only the instructions differ, and none of
//! them is fused, so the hits have the same bits (`every_instruction_set_gives_the_same_bits`).

use super::packet::{PacketHits, RayPacket, traverse};
use super::{Hit, TriangleBvh};

/// A set of vector instructions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InstructionSet {
    /// What every machine of the target has.
    Baseline,
    /// Eight numbers at once.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// Sixteen numbers at once.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl InstructionSet {
    /// Those that this machine has, the widest last.
    pub fn available() -> Vec<Self> {
        let mut sets = vec![Self::Baseline];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") {
                sets.push(Self::Avx2);
            }
            if is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512bw")
            {
                sets.push(Self::Avx512);
            }
        }
        sets
    }
}

/// A set that [`InstructionSet::available`] has listed: there is no other way to one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Detected(InstructionSet);

impl Detected {
    /// The widest set of this machine.
    pub(super) fn widest() -> Self {
        Self(InstructionSet::available().pop().unwrap_or(InstructionSet::Baseline))
    }

    /// `wanted`, if this machine has it.
    #[cfg(test)]
    pub(super) fn only(wanted: InstructionSet) -> Option<Self> {
        InstructionSet::available().contains(&wanted).then_some(Self(wanted))
    }
}

/// [`traverse`] with the tree's instruction set.
#[cfg_attr(
    target_arch = "x86_64",
    expect(unsafe_code, reason = "the machine has what is called, see `Detected`")
)]
pub(super) fn cast(
    tree: &TriangleBvh,
    rays: &RayPacket,
    opaque: &impl Fn(&Hit) -> bool,
    hits: &mut PacketHits,
) {
    match tree.instructions.0 {
        InstructionSet::Baseline => traverse(tree, rays, opaque, hits),
        // SAFETY: a `Detected` holds only sets that `is_x86_feature_detected!` found on this machine.
        #[cfg(target_arch = "x86_64")]
        InstructionSet::Avx2 => unsafe { traverse_avx2(tree, rays, opaque, hits) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        InstructionSet::Avx512 => unsafe { traverse_avx512(tree, rays, opaque, hits) },
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn traverse_avx2(
    tree: &TriangleBvh,
    rays: &RayPacket,
    opaque: &impl Fn(&Hit) -> bool,
    hits: &mut PacketHits,
) {
    traverse(tree, rays, opaque, hits);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw")]
fn traverse_avx512(
    tree: &TriangleBvh,
    rays: &RayPacket,
    opaque: &impl Fn(&Hit) -> bool,
    hits: &mut PacketHits,
) {
    traverse(tree, rays, opaque, hits);
}
