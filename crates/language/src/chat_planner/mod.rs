//! The paper's pipeline against a chat model: address resolution, verification against invented
//! places, optimisation of the order.
//!
//! The model is not trusted. Its answers are read tolerantly, but
//!
//! - nothing is invented: every building and unit must be supported by the instruction's numbers,
//!   words or names; where the grammar reads other doors, the model quotes the words that name its
//!   own;
//! - nothing is dropped: a door that the grammar reads is in the list, or the model quotes the
//!   words by which the sender rejects it;
//! - the order holds each stop once, and keeps to what the instruction asks for (as the grammar
//!   reads it); where something is due at a time, the model is not asked for one.
//!
//! Each prompt is asked again once with the reason. Then there is no plan, unless the grammar was
//! named as the fallback ([`ChatPlanner::with_fallback`]): it makes that part of the plan, which
//! says so ([`Fallback`]), also where the model does not answer at all. Names and problems are made
//! as for every planner. The prompts are the files in `prompts/`.

mod adopt;
mod answers;
mod conversation;
mod guard;
mod instruction;
mod json;
mod prompt;
mod question;

use openbench_core::{Fallback, Plan, PlanPart, with_causes};
use openbench_models::ChatModel;

use self::conversation::Conversation;
use self::instruction::Instruction;
use crate::arrange::{in_order, shortest};
use crate::grammar::GrammarPlanner;
use crate::resolve::Stops;
use crate::{PlanError, PlanRequest, Planner};

/// How often each prompt is asked.
const ATTEMPTS: usize = 2;

/// Plans with a chat model in three steps.
///
/// # Examples
/// ```
/// use openbench_core::{Georeference, LonLat, MapPoint, TravelTimes};
/// use openbench_language::{ChatPlanner, PlanRequest, Planner};
/// use openbench_models::{ChatError, ChatModel, ChatReply, ChatRequest};
/// use openbench_osm::{OsmData, OsmMap};
///
/// /// Gives one answer, whatever it is asked.
/// struct Parrot(&'static str);
///
/// impl ChatModel for Parrot {
///     fn name(&self) -> &str {
///         "parrot"
///     }
///
///     fn chat(&self, _: &ChatRequest) -> Result<ChatReply, ChatError> {
///         Ok(ChatReply { text: self.0.to_owned(), prompt_tokens: 0, completion_tokens: 0 })
///     }
/// }
/// # struct Walk;
/// # impl TravelTimes for Walk {
/// #     fn matrix(&self, places: &[MapPoint]) -> Vec<f64> {
/// #         vec![60.0; places.len() * places.len()]
/// #     }
/// # }
/// # let xml = r#"<osm version="0.6">
/// #     <node id="1" lat="48.1500" lon="11.5800"/><node id="2" lat="48.1500" lon="11.5804"/>
/// #     <node id="3" lat="48.1503" lon="11.5804"/>
/// #     <way id="4"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="1"/>
/// #         <tag k="building" v="yes"/><tag k="name" v="building3"/></way></osm>"#;
/// # let data = OsmData::from_xml(xml.as_bytes())?;
/// # let map = OsmMap::new(&data, Georeference::tangent_plane(LonLat::new(11.58, 48.15)));
///
/// let answer = r#"{"deliveries": [{"item": "the box", "building": "building3", "unit": "1"}]}"#;
/// let planner = ChatPlanner::new(Box::new(Parrot(answer)));
/// let plan = planner.plan(&PlanRequest {
///     instruction: "Take the box to unit 1 of building 3",
///     map: &map,
///     start: MapPoint::default(),
///     times: &Walk,
/// })?;
/// assert_eq!(plan.planner, "chat:parrot");
/// assert_eq!(plan.deliveries[0].address().to_string(), "unit1, building3");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct ChatPlanner {
    model: Box<dyn ChatModel>,
    name: String,
    grammar: GrammarPlanner,
    is_bare: bool,
    falls_back: bool,
}

impl ChatPlanner {
    /// A planner that asks `model`; its name is `chat:` and the model's.
    pub fn new(model: Box<dyn ChatModel>) -> Self {
        let name = format!("chat:{}", model.name());
        Self {
            model,
            name,
            grammar: GrammarPlanner::new(),
            is_bare: false,
            falls_back: false,
        }
    }

    /// The same planner, with the grammar for the parts of a plan that the model cannot make.
    #[must_use]
    pub fn with_fallback(mut self) -> Self {
        self.falls_back = true;
        self
    }

    /// A planner that takes the first answer to the first prompt as it is, in its order:
    /// unverified, unchecked, asked once.
    ///
    /// It is for comparison, to see what the rest is worth; its name is `bare:` and the model's.
    pub fn unverified(model: Box<dyn ChatModel>) -> Self {
        let name = format!("bare:{}", model.name());
        Self {
            model,
            name,
            grammar: GrammarPlanner::new(),
            is_bare: true,
            falls_back: false,
        }
    }

    fn conversation<'a>(&'a self, request: &'a PlanRequest<'a>) -> Conversation<'a> {
        let model = self.model.as_ref();
        let instruction = Instruction::new(&self.grammar, request);
        Conversation {
            model,
            instruction,
            attempts: ATTEMPTS,
        }
    }

    /// The first answer as it is.
    fn plan_bare(&self, request: &PlanRequest<'_>) -> Result<Plan, PlanError> {
        let mut conversation = self.conversation(request);
        conversation.attempts = 1;
        // Otherwise `stops` would take streets and quarters from the grammar's reading.
        conversation.instruction.read = None;
        let entries = conversation.resolve_addresses()?;
        let stops = conversation.instruction.stops(entries).stops;
        let order: Vec<usize> = (0..stops.len()).collect();
        let deliveries = in_order(request, stops, &order);
        Ok(Plan {
            planner: self.name.clone(),
            deliveries,
            fallbacks: Vec::new(),
        })
    }

    /// That the grammar makes a part of a plan, and why.
    fn fallback(&self, part: PlanPart, error: &PlanError) -> Fallback {
        Fallback {
            part,
            from: self.grammar.name().to_owned(),
            because: with_causes(error),
        }
    }
}

impl Planner for ChatPlanner {
    fn name(&self) -> &str {
        &self.name
    }

    fn plan(&self, request: &PlanRequest<'_>) -> Result<Plan, PlanError> {
        if self.is_bare {
            return self.plan_bare(request);
        }
        let conversation = self.conversation(request);
        let Ordered {
            stops,
            order,
            fallback,
        } = match conversation.addresses() {
            Ok(stops) => match conversation.optimise(&stops) {
                Ok(order) => Ordered {
                    stops,
                    order,
                    fallback: None,
                },
                // The addresses hold; only their order is computed instead.
                Err(error) if self.falls_back => {
                    let fallback = self.fallback(PlanPart::Order, &error);
                    Ordered::shortest(request, stops, fallback)
                }
                Err(error) => return Err(error),
            },
            Err(error) if !self.falls_back => return Err(error),
            Err(error) => {
                let fallback = self.fallback(PlanPart::Addresses, &error);
                // Two planners were asked, and the last one does not understand.
                let read = conversation.instruction.read.ok_or_else(|| {
                    let hint = format!("{}: {}", self.name, with_causes(&error));
                    PlanError::not_understood(request.instruction, &hint)
                })?;
                Ordered::shortest(request, read, fallback)
            }
        };
        let deliveries = in_order(request, stops.stops, &order);
        let fallbacks = fallback.into_iter().collect();
        Ok(Plan {
            planner: self.name.clone(),
            deliveries,
            fallbacks,
        })
    }
}

/// Stops in driving order, and which part of it the grammar made.
struct Ordered {
    stops: Stops,
    order: Vec<usize>,
    fallback: Option<Fallback>,
}

impl Ordered {
    fn shortest(request: &PlanRequest<'_>, stops: Stops, fallback: Fallback) -> Self {
        let order = shortest(request, &stops);
        Self {
            stops,
            order,
            fallback: Some(fallback),
        }
    }
}
