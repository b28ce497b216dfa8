//! States and the arcs between them.

/// No arc, or no state.
pub const NONE: u32 = u32::MAX;

/// An arc between two states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Arc {
    /// The state that it leaves.
    pub from: u32,
    /// The state that it leads to.
    pub to: u32,
    /// The directed edge that it passes along: twice the edge's number, plus one against its
    /// direction.
    pub via: u32,
}

/// Arcs, by one of their states.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Arcs {
    /// For each state its first arc, and the end of the last one's.
    pub first: Vec<u32>,
    /// The state at the other end.
    pub head: Vec<u32>,
    /// The directed edge that the arc passes along: twice the edge's number, plus one against its
    /// direction.
    pub via: Vec<u32>,
    /// The highest layer in which the two states are in different cells; 0 if there is none.
    pub(crate) border: Vec<u8>,
}

impl Arcs {
    /// Arcs between `states` states.
    pub fn new(states: usize, arcs: impl Iterator<Item = Arc> + Clone) -> Self {
        // Sorts by counting: the numbers of arcs, summed up, are where each state's arcs begin.
        // Arcs of one state keep their order.
        let mut first = vec![0_u32; states + 1];
        arcs.clone()
            .for_each(|arc| first[arc.from as usize + 1] += 1);
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        let count = first[states] as usize;
        let mut next = first.clone();
        let mut result = Self {
            first,
            head: vec![0; count],
            via: vec![0; count],
            border: vec![0; count],
        };
        for arc in arcs {
            let slot = next[arc.from as usize] as usize;
            next[arc.from as usize] += 1;
            result.head[slot] = arc.to;
            result.via[slot] = arc.via;
        }
        result
    }

    /// Whether each arc has exactly one in the opposite direction along the same edge.
    pub(crate) fn is_symmetric(&self) -> bool {
        let mut ends = vec![
            [NONE; 2];
            self.via
                .iter()
                .max()
                // An even number, so that both directions of the last edge have a place.
                .map_or(0, |last| (*last as usize | 1) + 1)
        ];
        for (from, slot) in self.iter() {
            let known = &mut ends[self.via[slot] as usize];
            // Two arcs along one directed edge, as the turns into it are: no arc has a single
            // opposite.
            if *known != [NONE; 2] {
                return false;
            }
            *known = [from, self.head[slot]];
        }
        ends.chunks_exact(2)
            .all(|both| both[0] == [both[1][1], both[1][0]])
    }

    /// The same arcs, by the states that they lead to.
    pub(crate) fn reversed(&self) -> Self {
        let back = |(from, slot): (u32, usize)| Arc {
            from: self.head[slot],
            to: from,
            via: self.via[slot],
        };
        Self::new(self.states(), self.iter().map(back))
    }

    /// Number of states.
    pub fn states(&self) -> usize {
        self.first.len() - 1
    }

    /// The arcs of a state.
    #[inline]
    pub fn of(&self, state: u32) -> std::ops::Range<usize> {
        self.first[state as usize] as usize..self.first[state as usize + 1] as usize
    }

    /// All arcs, with the states that they are stored at.
    pub fn iter(&self) -> impl Iterator<Item = (u32, usize)> + Clone + '_ {
        (0..self.states() as u32).flat_map(|state| self.of(state).map(move |slot| (state, slot)))
    }
}
