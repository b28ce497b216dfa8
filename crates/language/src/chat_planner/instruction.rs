//! An instruction as the grammar and the map see it, and a model's deliveries looked up in both.

use super::adopt::adopt_places;
use super::answers::Entry;
use crate::PlanRequest;
use crate::gazetteer::{Gazetteer, generic_label};
use crate::grammar::GrammarPlanner;
use crate::grammar::evidence::{Evidence, unit_label};
use crate::lexicon::words::Words;
use crate::resolve::{Stops, resolve};
use crate::wish::{Named, Wish, Wishes};

/// What the grammar and the map say of an instruction.
pub(super) struct Instruction<'a> {
    pub request: &'a PlanRequest<'a>,
    pub words: &'a Words,
    pub gazetteer: Gazetteer,
    pub evidence: Evidence,
    /// The doors that the grammar reads.
    pub read: Option<Stops>,
}

impl<'a> Instruction<'a> {
    /// An instruction and what the grammar reads in it.
    pub(super) fn new(grammar: &'a GrammarPlanner, request: &'a PlanRequest<'a>) -> Self {
        let words = grammar.words();
        let gazetteer = Gazetteer::new(request.map, words);
        let evidence = Evidence::of(request.instruction, words, &gazetteer);
        // The model may understand what the grammar does not, so that is no error here.
        let wishes = grammar.understand(request.instruction, &gazetteer).ok();
        let read = wishes.map(|wishes| resolve(wishes, request.map, &gazetteer));
        Self {
            request,
            words,
            gazetteer,
            evidence,
            read,
        }
    }

    /// The stops that a model's deliveries are.
    pub(super) fn stops(&self, entries: Vec<Entry>) -> Stops {
        let doors = entries.into_iter().map(|entry| self.wish(entry)).collect();
        let wishes = Wishes {
            doors,
            ..Wishes::default()
        };
        let mut stops = resolve(wishes, self.request.map, &self.gazetteer);
        if let Some(read) = &self.read {
            adopt_places(&mut stops, read);
        }
        stops
    }

    fn wish(&self, entry: Entry) -> Wish {
        Wish {
            building: Some(self.building(&entry.building)),
            unit: entry.unit.as_deref().map(|unit| self.unit(unit)),
            item: entry.item.unwrap_or_default(),
            ..Wish::default()
        }
    }

    /// How a model's building is named.
    pub(super) fn building(&self, said: &str) -> Named {
        let places = self.gazetteer.named(said);
        if !places.is_empty() {
            return Named::Places {
                places: places.to_vec(),
                percent: 100,
            };
        }
        named(generic_label(said, self.words), said)
    }

    /// How a model's unit is named.
    pub(super) fn unit(&self, said: &str) -> Named {
        named(unit_label(said, self.words), said)
    }

    /// The label of a place's name, if that is a word for a building and a label.
    pub(super) fn label_of(&self, place: usize) -> Option<String> {
        generic_label(&self.gazetteer.places[place].name, self.words)
    }
}

fn named(label: Option<String>, said: &str) -> Named {
    match label {
        Some(label) => Named::Label {
            label,
            said: said.to_owned(),
        },
        None => Named::Words(said.to_owned()),
    }
}
